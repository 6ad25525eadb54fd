"""The table that `vulnus validate` prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .runner import CaseOutcome

if TYPE_CHECKING:
    from rich.table import Table

SHOWN_DIGITS = 5


def outcome_table(outcomes: Sequence[CaseOutcome]) -> Table:
    """Case, quantity, value, reference, tolerance and verdict, a row a comparison."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, header_style="bold")
    for title in ("case", "quantity", "value", "reference", "tolerance", "verdict"):
        table.add_column(title, justify="right" if title in ("value", "reference") else "left")
    for outcome in outcomes:
        heading = Text(f"{outcome.case.name} ({outcome.wall:.0f} s)", "bold")
        table.add_row(outcome.case.id, heading)
        for comparison in outcome.report.comparisons:
            table.add_row(
                "",
                comparison.name,
                _shown(comparison.value, comparison.unit),
                _shown(comparison.reference, comparison.unit),
                comparison.tolerance,
                Text("agrees", "green") if comparison.passed else Text("FAILS", "bold red"),
            )
        if outcome.error is not None:
            table.add_row("", Text(outcome.error, "red"), "", "", "", Text("FAILS", "bold red"))
        table.add_section()
    return table


def summary_line(outcomes: Sequence[CaseOutcome]) -> str:
    """How many comparisons of how many cases agree."""
    comparisons = [c for outcome in outcomes for c in outcome.report.comparisons]
    agreeing = sum(c.passed for c in comparisons)
    cases = sum(outcome.passed for outcome in outcomes)
    wall = sum(outcome.wall for outcome in outcomes)
    return (
        f"{cases} of {len(outcomes)} cases agree ({agreeing} of {len(comparisons)} comparisons), "
        f"{wall:.0f} s"
    )


def _shown(value: float | None, unit: str) -> str:
    if value is None:
        return ""
    return f"{value:.{SHOWN_DIGITS}g} {'' if unit == '1' else unit}".rstrip()
