"""M1: longitudinal waves in an elastic bar: first mode and a step."""

from __future__ import annotations

import numpy as np

from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, PointSensor, elastic
from vulnus.validation import CaseReport, Comparison, Curve, Panel

YOUNGS_MODULUS, DENSITY = 1e7, 1000.0  # [chosen: c = 100 m/s]
LENGTH, SPEED = 0.24, 0.1  # [m], [m/s] [chosen: strains of 0.1 %, so that linear theory holds]
WAVE_SPEED = np.sqrt(YOUNGS_MODULUS / DENSITY)
CLOSED_FORM = "wave equation, Poisson's ratio 0"


def run(quick: bool, progress: Progress) -> CaseReport:
    """Both parts; `quick` has 24 cells along the bar in place of 96."""
    cells = 24 if quick else 96
    mode, mode_panel = first_mode(cells, progress)
    step, step_panel = step_wave(cells, progress)
    return CaseReport(comparisons=(*mode, *step), panels=(mode_panel, step_panel))


def bar(cells: int, velocity) -> Experiment:
    """A bar of `cells` by 2 by 2 cells from x = 0, held there."""
    spacing = LENGTH / cells
    experiment = Experiment(grid_spacing=spacing, precision="float64", courant_number=0.3)
    experiment.add_body(
        Block(size=(LENGTH, 2 * spacing, 2 * spacing), centre=(LENGTH / 2, spacing, spacing)),
        material=elastic(density=DENSITY, youngs_modulus=YOUNGS_MODULUS, poisson_ratio=0.0),
        velocity=velocity,
        name="bar",
    )
    experiment.hold_ends(axis="x", lower=0.0)
    end = PointSensor(position=(LENGTH, spacing, spacing), name="tip", quantities=("displacement",))
    experiment.add_sensor(end)
    return experiment


def first_mode(cells: int, progress: Progress) -> tuple[tuple[Comparison, ...], Panel]:
    """Period and loss of the mode v = V0 sin(pi x / 2 L)."""
    period = 4.0 * LENGTH / WAVE_SPEED
    amplitude = SPEED * period / (2.0 * np.pi)
    experiment = bar(cells, lambda x: np.sin(0.5 * np.pi * x / LENGTH) * (SPEED, 0.0, 0.0))
    result = experiment.run(until=2.3 * period, sample_interval=period / 200, progress=progress)
    time, tip = result.time, result.sensor("tip")["displacement"][:, 0]
    measured = falling_zeros(time, tip)
    peaks = [np.max(tip[(time >= n * period) & (time < (n + 0.5) * period)]) for n in (0, 1, 2)]
    loss = 1.0 - np.sqrt(peaks[2] / peaks[0])
    comparisons = (
        Comparison.within(
            "period of the first mode", measured, reference=period, unit="s", relative=0.01,
            source=f"{CLOSED_FORM}: 4 L / c; 1 % PHYSICS 3",
        ),
        Comparison.at_most(
            "amplitude lost in a period", loss, limit=0.05, unit="1", source="PHYSICS 3, APIC"
        ),
    )  # fmt: skip
    exact = amplitude * np.sin(2.0 * np.pi * time / period)
    panel = Panel(
        title="first mode", x="time / period", y="tip's displacement / mm",
        curves=(
            Curve(x=time / period, y=1e3 * tip, label="vulnus"),
            Curve(x=time / period, y=1e3 * exact, label="wave equation", kind="reference"),
        ),
    )  # fmt: skip
    return comparisons, panel


def falling_zeros(time: np.ndarray, tip: np.ndarray) -> float:
    """Time [s] between the first two zeros where the displacement falls."""
    before = np.flatnonzero((tip[:-1] > 0.0) & (tip[1:] <= 0.0))[:2]
    part = tip[before] / (tip[before] - tip[before + 1])
    zeros = time[before] + part * (time[before + 1] - time[before])
    return float(zeros[1] - zeros[0])


def step_wave(cells: int, progress: Progress) -> tuple[tuple[Comparison, ...], Panel]:
    """The bar runs into its held end: a step of pressure rho c v runs up it at c."""
    spacing, until = LENGTH / cells, 0.6 * LENGTH / WAVE_SPEED
    experiment = bar(cells, (-SPEED, 0.0, 0.0))
    final = experiment.run(until=until, progress=progress).final
    x, stress, speed = profile(final, cells)
    front = front_position(x, speed)
    plateau = stress[(x > 4 * spacing) & (x < front - 6 * spacing)].mean()
    expected = -DENSITY * WAVE_SPEED * SPEED
    comparisons = (
        Comparison.within(
            "front of the step", front, reference=WAVE_SPEED * until, unit="m",
            absolute=2.0 * spacing, source=f"{CLOSED_FORM}: c t; two cells, PHYSICS 3",
        ),
        Comparison.within(
            "stress behind the front", plateau, reference=expected, unit="Pa", relative=0.02,
            source=f"{CLOSED_FORM}: rho c v; 2 % chosen: linear theory at strains of 0.1 %",
        ),
    )  # fmt: skip
    exact = np.where(x < WAVE_SPEED * until, expected, 0.0)
    panel = Panel(
        title="step", x="place along the bar / mm", y="axial stress / kPa",
        curves=(
            Curve(x=1e3 * x, y=1e-3 * stress, label="vulnus"),
            Curve(x=1e3 * x, y=1e-3 * exact, label="wave equation", kind="reference"),
        ),
    )  # fmt: skip
    return comparisons, panel


def profile(fields, cells: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place [m], axial stress [Pa] and speed [m/s] along the bar, mean over each cell."""
    cell = (fields.reference_position[:, 0] / LENGTH * cells).astype(int)
    count = np.bincount(cell)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(cell, values) / count

    return mean(fields.position[:, 0]), mean(fields.stress[:, 0, 0]), mean(fields.velocity[:, 0])


def front_position(x: np.ndarray, speed: np.ndarray) -> float:
    """Where [m] the speed is half of its value ahead of the front."""
    beyond = int(np.flatnonzero(speed > -0.5 * SPEED)[-1])
    return float(np.interp(0.5 * SPEED, -speed[beyond : beyond + 2], x[beyond : beyond + 2]))
