"""Where the validation cases are, and how one is loaded.

They live in `validation/` at the repository's root; a wheel carries a copy of that folder as
`vulnus/cases/validation`. A checkout is looked at first.
"""

from __future__ import annotations

import importlib.util
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from vulnus.core.errors import InputFileError, ScenarioError
from vulnus.core.progress import Progress

from .report import CaseReport

PACKAGE = Path(__file__).resolve().parents[1]
PLACES = (PACKAGE.parents[1] / "validation", PACKAGE / "cases" / "validation")
"""Folders that may hold the cases, the first one that is there counts."""
FOLDER_NAME = re.compile(r"(?P<id>[A-Z]+[0-9]+[a-z]?)_(?P<name>[a-z0-9_]+)")


@dataclass(frozen=True, slots=True)
class Case:
    """A validation case: its `id` (M1), its `name` in words, and its folder."""

    id: str
    name: str
    folder: Path

    def load(self) -> Callable[[bool, Progress], CaseReport]:
        """The function `run` of the case's `case.py`."""
        module = _load(self.folder / "case.py", f"vulnus_validation_{self.folder.name}")
        run = getattr(module, "run", None)
        if not callable(run):
            raise InputFileError(
                str(self.folder / "case.py"),
                "has no function run(quick, progress)",
                "Write it as in validation/README.md",
            )
        return run  # type: ignore[no-any-return]


def stages(places: Sequence[Path] | None = None) -> tuple[str, ...]:
    """Names of the stages that have validation cases."""
    root = _root(places)
    return tuple(sorted(path.name for path in root.iterdir() if any(path.glob("*/case.py"))))


def find_cases(stage: str, places: Sequence[Path] | None = None) -> tuple[Case, ...]:
    """All cases of a stage, in the order of their ids; refused where the stage has none."""
    root = _root(places)
    known = stages(places)
    if stage not in known:
        raise ScenarioError(
            "stage", f"{stage!r} has no validation cases", f"There are some for: {', '.join(known)}"
        )
    found = []
    for path in (root / stage).iterdir():
        match = FOLDER_NAME.fullmatch(path.name)
        if match and (path / "case.py").is_file():
            found.append(Case(match["id"], match["name"].replace("_", " "), path))
    return tuple(sorted(found, key=lambda case: _order(case.id)))


def chosen_cases(cases: Sequence[Case], ids: Sequence[str]) -> tuple[Case, ...]:
    """Those of `cases` that `ids` name, all where it is empty; refused where one is not known."""
    known = {case.id.lower(): case for case in cases}
    for wish in ids:
        if wish.lower() not in known:
            raise ScenarioError(
                "--case", f"{wish!r} is not known", f"Known: {', '.join(c.id for c in cases)}"
            )
    wanted = {wish.lower() for wish in ids}
    return tuple(case for case in cases if not wanted or case.id.lower() in wanted)


def _root(places: Sequence[Path] | None) -> Path:
    places = PLACES if places is None else places
    for place in places:
        if any(place.glob("*/*/case.py")):
            return place
    raise InputFileError(
        " or ".join(str(place) for place in places),
        "no validation cases are there",
        "Run from a checkout of the repository, or install a wheel that was built from one",
    )


def _order(case_id: str) -> tuple[str, int, str]:
    letters, number, rest = re.fullmatch(r"([A-Z]+)([0-9]+)([a-z]?)", case_id).groups()  # type: ignore[union-attr]
    return letters, int(number), rest


def _load(path: Path, name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise InputFileError(str(path), "cannot be read as Python", "Mend or restore the file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module
