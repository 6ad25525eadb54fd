"""The gallery's scripts run and their assertions hold."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import vulnus

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs_and_its_assertions_hold(script: Path) -> None:
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "assert " in script.read_text(encoding="utf-8")


def test_public_names_are_few_and_there() -> None:
    assert len(vulnus.__all__) <= 15
    assert all(getattr(vulnus, name) for name in vulnus.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = vulnus.nothing
