"""Curves of a run: the paper's Fig. 4, flow, pressures and the ledger of the blood."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..core.handoff import BleedLedger, BleedOutcome, BleedWaveforms
from ..core.units import MILLILITRE, MILLILITRE_PER_MINUTE, MILLIMETRE_OF_MERCURY
from .figure_style import AORTA, ARTERY, OUT_OF_LIMB, WOUND, new_figure, style_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def cycle_figure(beat: BleedWaveforms, *, artery: str = "injured artery") -> Figure:
    """The paper's Fig. 4: pressures (left) and rate of blood loss (right) over one heartbeat."""
    figure = new_figure(9.0, 3.6)
    left, right = figure.subplots(1, 2)
    time = beat.time - beat.time[0]
    left.plot(time, beat.pressure_aorta / MILLIMETRE_OF_MERCURY, "--", color=AORTA, label="aorta")
    name = artery.replace("_", " ")
    left.plot(time, beat.pressure_artery / MILLIMETRE_OF_MERCURY, color=ARTERY, label=name)
    style_axes(left, x="time [s]", y="pressure [mmHg]", title="one cardiac cycle")
    left.legend(frameon=False, fontsize=9)
    right.plot(time, beat.flow_injury / MILLILITRE_PER_MINUTE, color=ARTERY)
    right.set_ylim(bottom=min(0.0, right.get_ylim()[0]))
    style_axes(right, x="time [s]", y="rate of blood loss [ml/min]", title="initial blood loss")
    for axes in (left, right):
        axes.set_xlim(0.0, float(time[-1]))
    return figure


def flow_figure(outcome: BleedOutcome) -> Figure:
    """Blood loss rate over the run, with the mean of each heartbeat."""
    figure = new_figure(8.0, 3.4)
    axes = figure.subplots()
    waves = outcome.waveforms
    axes.plot(waves.time, waves.flow_injury / MILLILITRE_PER_MINUTE, color=ARTERY, label="flow")
    means = np.asarray(outcome.mean_flow_per_beat) / MILLILITRE_PER_MINUTE
    if means.size:
        edges = outcome.period * np.arange(means.size + 1)
        axes.stairs(means, edges, color=AORTA, linewidth=1.4, label="mean of each beat")
    style_axes(axes, x="time [s]", y="rate of blood loss [ml/min]", title="flow out of the artery")
    _fit_time(axes, waves.time)
    axes.set_ylim(min(0.0, axes.get_ylim()[0]), 1.12 * axes.get_ylim()[1])
    axes.legend(frameon=False, fontsize=9, ncols=2, loc="upper right")
    return figure


def pressure_figure(outcome: BleedOutcome, *, artery: str = "injured artery") -> Figure:
    """Pressures in the aorta, in the injured artery and around the wound over the run."""
    figure = new_figure(8.0, 3.4)
    axes = figure.subplots()
    waves = outcome.waveforms
    for values, colour, line, name in (
        (waves.pressure_aorta, AORTA, "--", "aorta"),
        (waves.pressure_artery, ARTERY, "-", artery.replace("_", " ")),
        (waves.pressure_injury, WOUND, "-", "tissue around the wound"),
    ):
        axes.plot(waves.time, values / MILLIMETRE_OF_MERCURY, line, color=colour, label=name)
    style_axes(axes, x="time [s]", y="pressure [mmHg]", title="pressures")
    _fit_time(axes, waves.time)
    axes.margins(y=0.18)
    axes.legend(frameon=False, fontsize=9, ncols=3, loc="upper right")
    return figure


def ledger_figure(ledger: BleedLedger) -> Figure:
    """Where the lost blood is: in the limb, out of it, removed; the line is what was injected."""
    figure = new_figure(8.0, 3.4)
    axes = figure.subplots()
    shares = [ledger.in_limb, ledger.out_of_limb, ledger.removed, ledger.pending]
    axes.stackplot(
        ledger.time,
        *(share / MILLILITRE for share in shares),
        colors=[ARTERY, OUT_OF_LIMB, "#f0b49b", "#d5d9de"],
        labels=["in the limb", "out of the limb", "fallen away", "not yet a particle"],
        linewidth=0.0,
    )
    injected = ledger.injected / MILLILITRE
    axes.plot(ledger.time, injected, color=AORTA, linewidth=1.2, label="lost by the artery")
    style_axes(axes, x="time [s]", y="blood [ml]", title="blood loss")
    _fit_time(axes, ledger.time)
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False, fontsize=9, loc="upper left")
    return figure


def _fit_time(axes: Axes, time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    if time.size > 1 and time[-1] > time[0]:
        axes.set_xlim(float(time[0]), float(time[-1]))
