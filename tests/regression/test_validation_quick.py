"""The quick subset of the validation cases agrees."""

from __future__ import annotations

import pytest

from vulnus.core.progress import SilentProgress
from vulnus.validation import find_cases, run_case

pytestmark = pytest.mark.regression

QUICK = ("M1", "M2", "M4", "M5")
"""Cases whose quick variant takes a few seconds; the others are run by `vulnus validate`."""


@pytest.mark.parametrize("case_id", QUICK)
def test_the_case_agrees(case_id: str) -> None:
    (case,) = (case for case in find_cases("injury") if case.id == case_id)
    outcome = run_case(case, quick=True, progress=SilentProgress())
    assert outcome.error is None
    failed = [c for c in outcome.report.comparisons if not c.passed]
    assert not failed, "\n".join(f"{c.name}: {c.value:g} {c.unit} ({c.tolerance})" for c in failed)


def test_every_case_has_what_a_reader_needs() -> None:
    for case in find_cases("injury"):
        assert (case.folder / "README.md").is_file(), case.folder
        assert callable(case.load())
