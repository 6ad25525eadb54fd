"""Validation cases: what they compare, where they are found, how they are run and shown.

A case is a folder `validation/<stage>/<ID>_<name>/` with a `case.py` that has a function
`run(quick, progress) -> CaseReport`. `vulnus validate injury` runs them.
"""

from __future__ import annotations

from .catalogue import Case, chosen_cases, find_cases, stages
from .report import CaseReport, Comparison, Curve, Panel
from .runner import CaseOutcome, run_case, write_results

__all__ = [
    "Case",
    "CaseOutcome",
    "CaseReport",
    "Comparison",
    "Curve",
    "Panel",
    "chosen_cases",
    "find_cases",
    "run_case",
    "stages",
    "write_results",
]
