"""The wound in curves: cavity over time, energy and tract along the path, and what was torn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..core.units import MILLILITRE, MILLIMETRE, MILLISECOND, SQUARE_MILLIMETRE
from .figure_style import AORTA, ARTERY, INK, OUT_OF_LIMB, WOUND, new_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..core.wound_report import ProjectileReport, WoundReport

_COLOURS = (ARTERY, WOUND, OUT_OF_LIMB, AORTA)
_CENTIMETRE = 1e-2


def wound_figure(report: WoundReport) -> Figure:
    """Cavity volume over time, energy left and tract radius along the path, with a caption."""
    figure = new_figure(11.0, 4.0)
    cavity, energy, tract = figure.subplots(1, 3)
    draw_cavity(cavity, report)
    for number, one in enumerate(report.projectiles):
        colour = _COLOURS[number % len(_COLOURS)]
        draw_energy(energy, one, colour)
    style_axes(energy, x="path [mm]", y="energy left [J/cm]", title="energy along the path")
    if len(report.projectiles) > 1:
        energy.legend(frameon=False, fontsize=8)
    draw_tract(tract, report.projectiles[0])
    figure.supxlabel(wound_caption(report), fontsize=9, color=INK)
    return figure


def draw_cavity(axes: Axes, report: WoundReport) -> None:
    """Volume of the cavity [ml] over time [ms], the largest marked."""
    time = report.cavity.time / MILLISECOND
    volume = report.cavity.volume / MILLILITRE
    axes.plot(time, volume, color=ARTERY)
    if volume.size:
        axes.fill_between(time, volume, color=ARTERY, alpha=0.12, linewidth=0)
        at = report.temporary_time / MILLISECOND
        axes.plot([at], [float(np.interp(at, time, volume))], "o", color=ARTERY, markersize=5)
        axes.set_xlim(0.0, float(time[-1]))
        axes.set_ylim(0.0, 1.15 * max(float(volume.max()), 1e-3))
    style_axes(axes, x="time [ms]", y="volume [ml]", title="cavity")


def draw_energy(axes: Axes, projectile: ProjectileReport, colour: str) -> None:
    """Energy that a projectile left in the limb per length of its path [J/cm]."""
    deposit = projectile.energy
    per_length = deposit.energy / np.maximum(np.diff(deposit.edges), 1e-9) * _CENTIMETRE
    label = f"{projectile.name}: {deposit.total:.0f} J"
    axes.stairs(per_length, deposit.edges / MILLIMETRE, color=colour, label=label)


def draw_tract(axes: Axes, projectile: ProjectileReport) -> None:
    """Radii [mm] of the tract along the path: open cavity, end, and destroyed tissue."""
    tract = projectile.tract
    place = tract.arc_length / MILLIMETRE
    axes.fill_between(
        place,
        tract.destroyed_radius / MILLIMETRE,
        color=ARTERY,
        alpha=0.25,
        linewidth=0,
        label="destroyed tissue",
    )
    two = not np.array_equal(tract.temporary_radius, tract.permanent_radius)
    if two:
        axes.plot(place, tract.temporary_radius / MILLIMETRE, "--", color=AORTA, label="temporary")
    name = "permanent" if two else "cavity at the end"
    axes.plot(place, tract.permanent_radius / MILLIMETRE, color=WOUND, label=name)
    if place.size:
        axes.set_xlim(0.0, float(place[-1]))
    axes.set_ylim(0.0, 1.35 * max(axes.get_ylim()[1], 1e-3))
    style_axes(axes, x="depth [mm]", y="radius [mm]", title="tract")
    axes.legend(frameon=False, fontsize=8, loc="upper right")


def wound_caption(report: WoundReport) -> str:
    """Two or more lines of text that say the report's numbers."""
    volume = report.cavity.volume / MILLILITRE
    largest = float(volume.max(initial=0.0))
    last = float(volume[-1]) if volume.size else 0.0
    cavity = f"cavity {largest:.0f} ml at {report.temporary_time / MILLISECOND:.1f} ms"
    if last < largest:
        cavity += f", {last:.0f} ml at the end"
    lines = [_flight(one) for one in report.projectiles]
    return "\n".join([*lines, "; ".join([cavity, *_bones(report), _arteries(report)])])


def _flight(one: ProjectileReport) -> str:
    name = one.name.replace("_", " ")
    fate = {"left": "left the limb", "stopped": "stopped in the limb", "inside": "still inside"}
    text = f"{name}: {one.speed_before:.0f} → {one.speed_after:.0f} m/s, {fate[one.fate]}, "
    text += f"{one.energy.total:.0f} J left on {one.tract.arc_length[-1] / MILLIMETRE:.0f} mm; "
    text += f"skin destroyed {one.entry.destroyed_area / SQUARE_MILLIMETRE:.0f} mm² at the entry"
    if one.exit is not None:
        text += f", {one.exit.destroyed_area / SQUARE_MILLIMETRE:.0f} mm² at the exit"
    return text


def _bones(report: WoundReport) -> list[str]:
    bone = report.bone
    if bone.debris_mass == 0.0 and not bone.fragments:
        return []
    text = f"bone: {bone.debris_mass * 1e3:.1f} g of debris"
    if bone.fragments:
        pieces = "fragment" if len(bone.fragments) == 1 else "fragments"
        text += f", {len(bone.fragments)} {pieces}"
    return [text]


def _arteries(report: WoundReport) -> str:
    torn = [
        f"{one.artery.replace('_', ' ')} artery {one.kind}"
        for one in report.vessels
        if one.kind != "intact"
    ]
    return ", ".join(torn) if torn else "no artery torn"
