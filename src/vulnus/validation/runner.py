"""Runs validation cases one at a time and writes down what they found."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vulnus.core.errors import InputFileError, VulnusError
from vulnus.core.progress import Progress

from .catalogue import Case
from .report import CaseReport, Comparison


@dataclass(frozen=True, slots=True, eq=False)
class CaseOutcome:
    """A case that was run: its report, or the error that ended it, and the wall time [s]."""

    case: Case
    report: CaseReport
    error: str | None
    wall: float

    @property
    def passed(self) -> bool:
        """Whether the case ran to its end and every comparison agrees."""
        return self.error is None and all(c.passed for c in self.report.comparisons)


def run_case(case: Case, *, quick: bool, progress: Progress) -> CaseOutcome:
    """Run one case; an error that vulnus raises on purpose makes it fail, not the whole run."""
    begun = time.perf_counter()
    report, error = CaseReport(comparisons=()), None
    try:
        report = case.load()(quick, progress)
        _check(case, report)
    except VulnusError as trouble:
        error = str(trouble)
    return CaseOutcome(case, report, error, time.perf_counter() - begun)


def write_results(outcomes: Sequence[CaseOutcome], path: Path) -> Path:
    """Write all outcomes as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(as_json(outcomes) + "\n", encoding="utf-8")
    return path


def as_json(outcomes: Sequence[CaseOutcome]) -> str:
    """All outcomes as JSON; limits and values that are not finite are null."""
    return json.dumps([_outcome_as_dict(outcome) for outcome in outcomes], indent=1)


def _outcome_as_dict(outcome: CaseOutcome) -> dict[str, Any]:
    return {
        "case": outcome.case.id,
        "name": outcome.case.name,
        "passed": outcome.passed,
        "error": outcome.error,
        "wall_s": round(outcome.wall, 2),
        "comparisons": [_comparison_as_dict(c) for c in outcome.report.comparisons],
    }


def _comparison_as_dict(comparison: Comparison) -> dict[str, Any]:
    numbers = {
        name: value if value is not None and math.isfinite(value) else None
        for name in ("value", "reference", "lower", "upper")
        for value in (getattr(comparison, name),)
    }
    texts = {name: getattr(comparison, name) for name in ("name", "unit", "tolerance", "source")}
    return {**texts, **numbers, "passed": comparison.passed}


def _check(case: Case, report: CaseReport) -> None:
    if not isinstance(report, CaseReport) or not report.comparisons:
        raise InputFileError(
            str(case.folder / "case.py"),
            "run() gave no comparisons",
            "It must return a CaseReport with at least one",
        )
