"""The look of every figure: one type size, few lines, colours that mean something."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..core.handoff import Tissue
from .materials import TISSUE_COLOUR
from .picture import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARTERY = "#b3121d"
AORTA = "#3a3f47"
WOUND = "#2b6cb0"
OUT_OF_LIMB = "#d9480f"
INK = "#22262b"

FIGURE_2_COLOURS: dict[Tissue, str] = {
    Tissue.SKIN: "#e8c93f",  # yellow, red and white as in the paper's Fig. 2
    Tissue.FAT: "#e9a23b",
    Tissue.MUSCLE: "#b5322c",
    Tissue.BONE: "#f6f3ea",
    Tissue.CANCELLOUS: "#eadfc8",
    Tissue.MARROW: "#e3c3ad",
    Tissue.ARTERY: "#ff2a2a",
}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of `width` by `height` [inch] that belongs to no window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def style_axes(axes: Axes, *, x: str, y: str, title: str = "") -> None:
    """Labels with units, two spines, a faint grid."""
    axes.set_xlabel(x, color=INK, fontsize=10)
    axes.set_ylabel(y, color=INK, fontsize=10)
    if title:
        axes.set_title(title, loc="left", fontsize=11, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color("#8a9099")
    axes.tick_params(colors=INK, labelsize=9, length=3)
    axes.grid(visible=True, color="#e4e7eb", linewidth=0.7)
    axes.set_axisbelow(True)


def bare_axes(axes: Axes, title: str = "") -> None:
    """No frame and no ticks: for pictures inside a figure."""
    axes.set_axis_off()
    if title:
        axes.set_title(title, fontsize=10, color=INK)


def save_figure(figure: Figure, path: Path, dots_per_inch: int) -> Path:
    """Write the figure as PNG, whole or not at all."""
    return write_whole(
        path, lambda partial: figure.savefig(partial, dpi=dots_per_inch, format="png")
    )


def linear_colour(tissue: Tissue) -> tuple[float, float, float]:
    """The renderer's colour of a tissue as matplotlib's sRGB fractions."""
    red, green, blue = (channel ** (1 / 2.2) for channel in TISSUE_COLOUR[tissue])
    return red, green, blue
