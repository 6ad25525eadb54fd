"""M8d: steel balls of 4.5 and 3 mm at one speed into 10 % gelatin: depth in proportion to size."""

from __future__ import annotations

import numpy as np

from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, RigidBody, RigidBodyRecord, Sphere
from vulnus.validation import CaseReport, Comparison, Curve, Panel

SPEED = 179.8  # [m/s], that of M8a
STEEL = 7800.0  # [kg/m³] [M]
DIAMETERS = (4.5e-3, 3.0e-3)  # [m]
CELLS = 5.0  # of a diameter: the same error of the grid for both [chosen: PHYSICS 1.6]
LENGTH, WIDTH = 120.0, 17.0  # cells of a quarter of the block [chosen: as M8a]
PARTICLES_PER_CELL = 4.63  # as M8a
STOPPED = 3.0  # [m/s], as M8a
SCALING = "PHYSICS M8d: P in proportion to d where Cd and strength do not depend on size"


def run(quick: bool, progress: Progress) -> CaseReport:
    """Depths in diameters; `quick`: the speed left after 5 diameters of both."""
    shots = [fly(d, 32.0 if quick else LENGTH, quick, progress) for d in DIAMETERS]
    if quick:
        left = [
            float(np.interp(5 * d, s.depth, s.speed)) for d, s in zip(DIAMETERS, shots, strict=True)
        ]
        comparison = Comparison.within(
            "speed lost after 5 diameters, 3 over 4.5 mm", (SPEED - left[1]) / (SPEED - left[0]),
            reference=1.0, unit="1", relative=0.10, source=SCALING,
        )  # fmt: skip
        return CaseReport(comparisons=(comparison,))
    depths = [shot.greatest_depth for shot in shots]
    comparison = Comparison.within(
        "depth of 3 mm over that of 4.5 mm", depths[1] / depths[0],
        reference=DIAMETERS[1] / DIAMETERS[0], unit="1", relative=0.10, source=SCALING,
    )  # fmt: skip
    curves = [
        Curve(
            x=shot.depth / d,
            y=shot.speed,
            label=f"{1e3 * d:g} mm: {1e3 * shot.greatest_depth:.1f} mm",
        )
        for d, shot in zip(DIAMETERS, shots, strict=True)
    ]
    panel = Panel(
        title="same speed, two sizes", x="depth / diameter", y="speed / m/s", curves=tuple(curves)
    )
    return CaseReport(comparisons=(comparison,), panels=(panel,))


def fly(diameter: float, cells: float, quick: bool, progress: Progress) -> RigidBodyRecord:
    """A quarter of ball and block between two planes of symmetry along the line of flight."""
    spacing = diameter / CELLS
    length, width = cells * spacing, WIDTH * spacing
    experiment = Experiment(grid_spacing=spacing)
    experiment.add_body(
        Block(size=(length, width, width), centre=(length / 2, width / 2, width / 2)),
        material="gelatin_10",
        particles_per_cell=PARTICLES_PER_CELL,
        name="gelatin",
    )
    for normal in ("y", "z"):
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    shape = Sphere(diameter / 2)
    experiment.add_rigid_body(
        RigidBody(
            shape=shape,
            centre=(-diameter / 2 - spacing, 0.0, 0.0),
            velocity=(SPEED, 0.0, 0.0),
            motion="dynamic",
            mass=STEEL * shape.volume / 4,
            rail=(1.0, 0.0, 0.0),
            name="ball",
        )
    )
    result = experiment.run(
        until=(0.04 if quick else 1.0) * diameter,  # [s]: 1 s a metre of diameter is three times
        sample_interval=4.5e-3 * diameter,  # what the flight takes; chosen: 20 µs at 4.5 mm
        stop_when=lambda run: run.rigid_body("ball").velocity[0] < STOPPED,
        progress=progress,
    )
    return result.rigid_body("ball")
