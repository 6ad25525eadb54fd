"""The plot of a case: its panels side by side, results in blue, references in grey."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from vulnus.visualization.figure_style import new_figure, save_figure, style_axes

from .report import CaseReport, Curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RESULT_COLOURS = ("#2b6cb0", "#d9480f", "#2f8f4e", "#8d5bb5", "#b3121d", "#0f8b8d")
REFERENCE_COLOURS = ("#22262b", "#8a9099", "#b8863b")
LINE_STYLES = {"result": "-", "reference": "--", "points": "", "reference points": ""}
MARKERS = {"result": "", "reference": "", "points": "o", "reference points": "s"}


def draw_report(report: CaseReport, path: Path, *, title: str) -> Path:
    """Write the plot of a report as PNG, at most three panels a row."""
    count = len(report.panels)
    columns = min(3, count)
    rows = -(-count // columns)
    figure = new_figure(4.4 * columns, 3.4 * rows + 0.4)
    figure.suptitle(title, x=0.01, ha="left", fontsize=12)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, pane in zip(report.panels, axes, strict=False):
        style_axes(pane, x=panel.x, y=panel.y, title=panel.title)
        if panel.logarithmic:
            pane.set_xscale("log")
            pane.set_yscale("log")
        _draw_curves(pane, panel.curves)
    for pane in axes[count:]:
        pane.set_visible(False)
    return save_figure(figure, path, 110)


def _draw_curves(axes: Axes, curves: tuple[Curve, ...]) -> None:
    used = {"result": 0, "reference": 0}
    for curve in curves:
        role = "reference" if curve.kind.startswith("reference") else "result"
        colours = REFERENCE_COLOURS if role == "reference" else RESULT_COLOURS
        colour = colours[used[role] % len(colours)]
        used[role] += 1
        axes.errorbar(
            curve.x,
            curve.y,
            yerr=curve.error,
            label=curve.label,
            color=colour,
            linestyle=LINE_STYLES[curve.kind],
            marker=MARKERS[curve.kind],
            markersize=4.5,
            linewidth=1.5 if role == "result" else 1.2,
            capsize=3,
            zorder=2 if role == "result" else 3,  # a thin dashed reference over a line
        )
    axes.legend(fontsize=8, frameon=False)
