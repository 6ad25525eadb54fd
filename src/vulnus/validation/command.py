"""What `vulnus validate` does: run the chosen cases, say how far it is, print the table."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vulnus.core.progress import Progress

from .catalogue import chosen_cases, find_cases
from .runner import CaseOutcome, as_json, run_case, write_results
from .table import outcome_table, summary_line

if TYPE_CHECKING:
    from rich.console import Console


@dataclass(frozen=True, slots=True, kw_only=True)
class ValidationWishes:
    """Which cases of a stage to run, and where the results go."""

    stage: str
    ids: tuple[str, ...] = ()
    quick: bool = False
    plots: bool = False
    output: Path | None = None
    json: bool = False


def list_cases(stage: str) -> None:
    """Print id, name and folder of every case of a stage."""
    for case in find_cases(stage):
        print(f"{case.id:<5} {case.name:<40} {case.folder}")


def run_validation(wishes: ValidationWishes, progress: Progress, console: Console) -> int:
    """Run the cases; gives the exit code 0 where all agree, else 1.

    What is done when the user interrupts is still printed.
    """
    cases = chosen_cases(find_cases(wishes.stage), wishes.ids)
    outcomes: list[CaseOutcome] = []
    try:
        for case in cases:
            console.print(f"{case.id} {case.name}", highlight=False)
            outcome = run_case(case, quick=wishes.quick, progress=progress)
            outcomes.append(outcome)
            _draw(outcome, wishes)
    finally:
        progress.end()
        if outcomes:
            _show(outcomes, wishes)
    return 0 if all(outcome.passed for outcome in outcomes) else 1


def _draw(outcome: CaseOutcome, wishes: ValidationWishes) -> None:
    if not outcome.report.panels or not (wishes.plots or wishes.output):
        return
    from .plot import draw_report

    case = outcome.case
    path = case.folder / "plot.png"
    if wishes.output is not None:
        path = wishes.output / f"{case.folder.name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
    draw_report(outcome.report, path, title=f"{case.id} {case.name}")


def _show(outcomes: list[CaseOutcome], wishes: ValidationWishes) -> None:
    from rich.console import Console

    if wishes.output is not None:
        write_results(outcomes, wishes.output / "results.json")
    if wishes.json:
        sys.stdout.write(as_json(outcomes) + "\n")
        return
    console = Console()
    console.print(outcome_table(outcomes))
    console.print(summary_line(outcomes), highlight=False)
