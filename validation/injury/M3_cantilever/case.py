"""M3: a cantilever that begins to feel its weight: deflection and first frequency."""

from __future__ import annotations

import numpy as np

from vulnus.core.constants import STANDARD_GRAVITY
from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, ExperimentResult, PointSensor, elastic
from vulnus.validation import CaseReport, Comparison, Curve, Panel

DEPTH_CELLS, WIDTH_CELLS = 8, 2  # 8 cells as PHYSICS 3 asks; a narrow beam of free sides [chosen]
DEPTH, DENSITY, YOUNGS_MODULUS = 0.01, 1000.0, 1e7  # [chosen: the tip sinks by about 1 %]
SPACING = DEPTH / DEPTH_CELLS
FIRST_ROOT = 1.8751  # of cos x cosh x = -1
PERIODS = 0.65  # [chosen: past the lowest point, which tells both numbers]
SLENDERNESS = {0.3: 10.0, 0.49: 8.0}  # length over depth [chosen: shear adds 1 to 2 %]
QUICK_SLENDERNESS = {0.3: 6.0}
TOLERANCE = 0.05  # PHYSICS 3, at 8 cells across the depth


def run(quick: bool, progress: Progress) -> CaseReport:
    """Poisson's ratio 0.3 and 0.49; quick: 0.3 alone, and a shorter beam."""
    comparisons: list[Comparison] = []
    curves: list[Curve] = []
    for poisson_ratio, slenderness in (QUICK_SLENDERNESS if quick else SLENDERNESS).items():
        found, lines = compare(slenderness, poisson_ratio, progress)
        comparisons += found
        curves += lines
    panel = Panel(
        title="tip of the cantilever", x="time / first period", y="deflection / static deflection",
        curves=tuple(curves),
    )  # fmt: skip
    return CaseReport(comparisons=tuple(comparisons), panels=(panel,))


def static_deflection(length: float) -> float:
    """Tip's deflection [m] rho g A L⁴ / (8 E I) under its own weight."""
    return 1.5 * DENSITY * STANDARD_GRAVITY * length**4 / (YOUNGS_MODULUS * DEPTH**2)


def first_frequency(length: float) -> float:
    """Frequency [Hz] (1.8751² / (2 pi L²)) sqrt(E I / (rho A))."""
    bending = np.sqrt(YOUNGS_MODULUS * DEPTH**2 / (12.0 * DENSITY))
    return float(FIRST_ROOT**2 / (2.0 * np.pi * length**2) * bending)


def compare(
    slenderness: float, poisson_ratio: float, progress: Progress
) -> tuple[list[Comparison], list[Curve]]:
    """Deflection and frequency of one beam beside the beam theory."""
    length = slenderness * DEPTH
    expected, frequency = static_deflection(length), first_frequency(length)
    result = swing(length, poisson_ratio, PERIODS / frequency, progress)
    time, sunk = result.time, -result.sensor("tip")["displacement"][:, 2]
    deflection, found = fit_swing(time, sunk, frequency)
    label = f"Poisson's ratio {poisson_ratio:g}"
    comparisons = [
        Comparison.within(
            f"deflection, {label}", 1e3 * deflection, reference=1e3 * expected, unit="mm",
            relative=TOLERANCE, source="rho g A L^4 / 8 E I; PHYSICS 3",
        ),
        Comparison.within(
            f"first frequency, {label}", found, reference=frequency, unit="Hz",
            relative=TOLERANCE, source="Euler-Bernoulli; PHYSICS 3",
        ),
    ]  # fmt: skip
    swings = time * frequency
    exact = 1.0 - np.cos(2.0 * np.pi * swings)
    curves = [Curve(x=swings, y=sunk / expected, label=label)]
    if poisson_ratio == 0.3:
        curves.append(Curve(x=swings, y=exact, label="first mode", kind="reference"))
    return comparisons, curves


def swing(
    length: float, poisson_ratio: float, until: float, progress: Progress
) -> ExperimentResult:
    """The run: weight sets in at time 0, so that the tip swings about its static deflection."""
    width = WIDTH_CELLS * SPACING
    experiment = Experiment(
        grid_spacing=SPACING, precision="float64", gravity=(0.0, 0.0, -STANDARD_GRAVITY)
    )
    experiment.add_body(
        Block(size=(length, width, DEPTH), centre=(0.5 * length, 0.5 * width, 0.5 * DEPTH)),
        material=elastic(DENSITY, YOUNGS_MODULUS, poisson_ratio),
        name="beam",
    )
    experiment.hold_ends(axis="x", lower=0.0)
    tip = (length, 0.5 * width, 0.5 * DEPTH)
    experiment.add_sensor(
        PointSensor(position=tip, radius=2 * SPACING, quantities=("displacement",), name="tip")
    )
    return experiment.run(until=until, progress=progress)


def fit_swing(time: np.ndarray, sunk: np.ndarray, guess: float) -> tuple[float, float]:
    """Static deflection [m] and frequency [Hz] of d (1 - exp(-k t) cos(2 pi f t))."""
    from scipy.optimize import curve_fit

    def swinging(t: np.ndarray, depth: float, frequency: float, loss: float) -> np.ndarray:
        return depth * (1.0 - np.exp(-loss * t) * np.cos(2.0 * np.pi * frequency * t))

    start = (0.5 * np.max(sunk), guess, 0.0)
    (depth, frequency, _), _ = curve_fit(swinging, time, sunk, p0=start)
    return float(depth), float(frequency)
