"""M8a: a steel BB at 179.8 m/s into 10 % gelatin: the depth that calibrates the material."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, RigidBody, RigidBodyRecord, Sphere, projectile
from vulnus.validation import CaseReport, Comparison, Curve, Panel

SPEED = 179.8  # [m/s], 590 ft/s [F: Hornady/FBI]
SPACINGS = (0.85e-3, 0.7e-3)  # [m], 5.2 and 6.3 cells a diameter [chosen: PHYSICS 1.6, and finer]
LENGTH, WIDTH = 0.108, 0.0153  # [m] of a quarter of the block [chosen: 20 mm wide gave 1 % less]
PARTICLES_PER_CELL = 4.63  # 5 in 3 cells along each axis [chosen: 8 gave the same within 1 %]
STOPPED = 3.0  # [m/s]; from there on the ball goes less than 0.1 mm [D]
SOURCE = "FBI gelatin calibration, 85 ± 10 mm [F: Hornady/FBI, PHYSICS M8a]"
DATA = Path(__file__).with_name("depths.csv")


def run(quick: bool, progress: Progress) -> CaseReport:
    """Depth on two grids; `quick`: the speed left after 20 mm on the coarser one."""
    if quick:
        return quick_report(progress)
    shots = [fly(spacing, LENGTH, 4e-3, progress) for spacing in SPACINGS]
    depths = [1e3 * shot.greatest_depth for shot in shots]
    comparisons = tuple(
        Comparison.within(
            f"depth on cells of {1e3 * spacing:g} mm", depth, reference=85.0, unit="mm",
            absolute=10.0, source=SOURCE,
        )
        for spacing, depth in zip(SPACINGS, depths, strict=True)
    )  # fmt: skip
    calibrated = Comparison.within(
        "mean of both, as calibrated", float(np.mean(depths)), reference=85.0, unit="mm",
        absolute=5.0, source="PHYSICS M8a: calibrate on this one to 5 mm, then freeze",
    )  # fmt: skip
    return CaseReport(comparisons=(*comparisons, calibrated), panels=panels(shots))


def quick_report(progress: Progress) -> CaseReport:
    """The first 20 mm: what inertia and strength take from the speed."""
    shot = fly(SPACINGS[0], 0.027, 2e-4, progress)
    left = float(np.interp(0.020, shot.depth, shot.speed))
    expected = float(np.interp(20.0, *poncelet()))
    comparison = Comparison.within(
        "speed after 20 mm", left, reference=expected, unit="m/s", relative=0.12,
        source="Poncelet's law of the measured depth (PHYSICS 1.2); 12 % chosen: coarse grid",
    )  # fmt: skip
    return CaseReport(comparisons=(comparison,))


def fly(spacing: float, length: float, until: float, progress: Progress) -> RigidBodyRecord:
    """A quarter of ball and block between two planes of symmetry along the line of flight."""
    ball = projectile("bb_4.5mm")
    width = spacing * round(WIDTH / spacing)
    experiment = Experiment(grid_spacing=spacing)
    experiment.add_body(
        Block(size=(length, width, width), centre=(length / 2, width / 2, width / 2)),
        material="gelatin_10",
        particles_per_cell=PARTICLES_PER_CELL,
        name="gelatin",
    )
    for normal in ("y", "z"):
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    experiment.add_rigid_body(
        RigidBody(
            shape=Sphere(ball.diameter / 2),
            centre=(-ball.diameter / 2 - spacing, 0.0, 0.0),
            velocity=(SPEED, 0.0, 0.0),
            motion="dynamic",
            mass=ball.mass / 4,
            rail=(1.0, 0.0, 0.0),
            name="ball",
        )
    )
    result = experiment.run(
        until=until,
        sample_interval=2e-5,
        stop_when=lambda run: run.rigid_body("ball").velocity[0] < STOPPED,
        progress=progress,
    )
    return result.rigid_body("ball")


def poncelet() -> tuple[FloatArray, FloatArray]:
    """Depth [mm] and speed [m/s] of v dv/dx = -(A/m)(c0 + rho Cd v²/2) that stops at 85 mm."""
    ball = projectile("bb_4.5mm")
    area = np.pi * ball.diameter**2 / 4
    density, drag = 1030.0, 0.35  # PHYSICS 1.1 and 1.2
    k = density * drag * area / ball.mass
    strength = 0.5 * density * drag * SPEED**2 / np.expm1(0.085 * k)
    x = np.linspace(0.0, 0.085, 171)
    square = (SPEED**2 + 2 * strength / (density * drag)) * np.exp(-k * x) - 2 * strength / (
        density * drag
    )
    return 1e3 * x, np.sqrt(np.maximum(square, 0.0))


def panels(shots: list[RigidBodyRecord]) -> tuple[Panel, ...]:
    """Speed over depth, and depth against the measured ones at several speeds."""
    x, speed = poncelet()
    curves = [
        Curve(x=1e3 * shot.depth, y=shot.speed, label=f"vulnus, cells of {1e3 * spacing:g} mm")
        for spacing, shot in zip(SPACINGS, shots, strict=True)
    ]
    data = np.loadtxt(DATA, delimiter=",", skiprows=1, usecols=(0, 1, 2), ndmin=2)
    measured = Curve(
        x=data[:, 1], y=0.0 * data[:, 1], error=None, label="measured, 85 ± 10 mm",
        kind="reference points",
    )  # fmt: skip
    bars = Curve(
        x=data[0, 1] + data[0, 2] * np.array((-1.0, 1.0)), y=np.zeros(2), label="its tolerance",
        kind="reference",
    )  # fmt: skip
    law = Curve(x=x, y=speed, label="Poncelet's law through 85 mm", kind="reference")
    return (
        Panel(
            title="BB into 10 % gelatin", x="depth / mm", y="speed / m/s",
            curves=(*curves, law, measured, bars),
        ),
    )  # fmt: skip
