"""Fixtures that every test may use."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder with the real legs and reference series; skips where it is absent.

    Environment variable VULNUS_SHARED names it; else it is `../shared/data` beside the repository.
    """
    named = os.environ.get("VULNUS_SHARED")
    folder = Path(named) if named else REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no shared data at {folder}; set VULNUS_SHARED to the folder that holds them")
    return folder
