"""M14: the tract does not depend on how the setup lies in the grid, and converges with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, RigidBody, RigidBodyRecord, Sphere, rotation_about
from vulnus.validation import CaseReport, Comparison, Curve, Panel

RADIUS, MASS, SPEED = 7.5e-3, 2e-3, 150.0  # [m], [kg], [m/s] [chosen: 5 cells of 3 mm across, and
# so light that it loses two thirds of its speed within two diameters]
BLOCK = (45e-3, 45e-3, 42e-3)  # [m] [chosen: three balls wide, and the ball stays inside]
STAND_OFF = 0.1e-3  # [m] [chosen: the ball starts just outside]
UNTIL = 0.3e-3  # [s] [chosen: two diameters deep]
SAMPLES = 20  # [chosen: enough for a curve; 2 and 100 give the same depth within 0.1 mm]
SPACINGS = (3e-3, 2e-3, 1.5e-3)  # [m] [PHYSICS M14]
LEAST_ORDER = 0.8  # [PHYSICS M14]
SHIFT = (0.5, 0.25, 0.33)  # cells [chosen: the greatest along one axis, none alike]
TURN = rotation_about((1.0, 2.0, 0.5), 0.6)  # [chosen: no axis stays on another]
SAME_DEPTH = 0.02  # [chosen: a fifth of what refining from 3 to 2 mm changes]
SAME_LINE = 0.1  # cells [chosen: a fiftieth of the ball's diameter]
SOURCE = "PHYSICS M14"


@dataclass(frozen=True, eq=False)
class Tract:
    """One run, in the frame of the setup: the ball flies along -z from the origin."""

    spacing: float
    turn: FloatArray
    ball: RigidBodyRecord

    @property
    def depth(self) -> float:
        """Depth [m] of the ball's foremost point at the end."""
        return float(self.ball.depth[-1])

    @property
    def drift(self) -> float:
        """Largest distance [cells] of the ball's centre from the line that it was shot along."""
        own = self.ball.position @ self.turn
        return float(np.max(np.linalg.norm(own[:, :2], axis=1)) / self.spacing)


def run(quick: bool, progress: Progress) -> CaseReport:
    """Turned and shifted on 3 mm cells, then 2 and 1.5 mm; the quick version has 3 mm alone.

    The order is that of the mean depth of plain and shifted grid.
    """
    plain = shoot(SPACINGS[0], progress)
    shifted = shoot(SPACINGS[0], progress, shift=SHIFT)
    turned = shoot(SPACINGS[0], progress, turn=TURN)
    comparisons = [
        *same_tract("shifted grid", shifted, plain),
        *same_tract("turned setup", turned, plain),
    ]
    tracts = [plain]
    moved = [shifted]
    if not quick:
        tracts += [shoot(spacing, progress) for spacing in SPACINGS[1:]]
        moved += [shoot(spacing, progress, shift=SHIFT) for spacing in SPACINGS[1:]]
        depths = [0.5 * (one.depth + two.depth) for one, two in zip(tracts, moved, strict=True)]
        comparisons.append(
            Comparison.at_least(
                "order of convergence of the depth",
                order_of(depths),
                limit=LEAST_ORDER,
                unit="1",
                source=SOURCE,
            )
        )
    panels = (depth_panel(tracts, shifted, turned), convergence_panel(tracts, moved, turned))
    return CaseReport(comparisons=tuple(comparisons), panels=panels)


def shoot(
    spacing: float,
    progress: Progress,
    *,
    shift: Vector3 = (0.0, 0.0, 0.0),
    turn: FloatArray | None = None,
) -> Tract:
    """The ball into the block; `shift` [cells] of the grid, `turn` of block and ball together."""
    rotation = np.eye(3) if turn is None else turn
    offset = tuple(float(s) * spacing for s in shift)
    experiment = Experiment(grid_spacing=spacing, grid_offset=offset)
    block = Block(size=BLOCK, centre=(0.0, 0.0, -BLOCK[2] / 2))
    experiment.add_body(
        block.rotated(rotation, about=(0.0, 0.0, 0.0)), material="gelatin_10", name="gel"
    )
    flight = rotation @ np.array([0.0, 0.0, -1.0])
    experiment.add_rigid_body(
        RigidBody(
            shape=Sphere(RADIUS),
            centre=tuple(-(RADIUS + STAND_OFF) * flight),
            velocity=tuple(SPEED * flight),
            motion="dynamic",
            mass=MASS,
            friction=0.0,
            name="ball",
        )
    )
    result = experiment.run(until=UNTIL, sample_interval=UNTIL / SAMPLES, progress=progress)
    return Tract(spacing, rotation, result.rigid_body("ball"))


def same_tract(name: str, tract: Tract, plain: Tract) -> list[Comparison]:
    """Depth and straightness of a tract against the plain one."""
    return [
        Comparison.within(
            f"{name}: depth",
            tract.depth,
            reference=plain.depth,
            unit="m",
            relative=SAME_DEPTH,
            source=f"{SOURCE}; chosen: a fifth of what a refinement changes",
        ),
        Comparison.at_most(
            f"{name}: drift",
            tract.drift,
            limit=SAME_LINE,
            unit="cells",
            source=f"{SOURCE}; chosen: a fiftieth of the ball",
        ),
    ]


def order_of(depths: list[float]) -> float:
    """Order p of depth = d + c h^p through three depths; NaN where they do not converge.

    (P1 - P2)/(P2 - P3) = (h1^p - h2^p)/(h2^p - h3^p), which grows with p.
    """
    one, two, three = SPACINGS
    first, second = depths[0] - depths[1], depths[1] - depths[2]

    def excess(p: float) -> float:
        return float((one**p - two**p) / (two**p - three**p) - first / second)

    if not first * second > 0.0 or excess(0.01) * excess(10.0) > 0.0:
        return float("nan")
    return float(brentq(excess, 0.01, 10.0))


def depth_panel(tracts: list[Tract], shifted: Tract, turned: Tract) -> Panel:
    """Depth over time."""
    named = [(f"{1e3 * tract.spacing:g} mm", tract) for tract in tracts]
    named += [("3 mm, grid shifted", shifted), ("3 mm, setup turned", turned)]
    curves = [
        Curve(x=1e3 * tract.ball.time, y=1e3 * tract.ball.depth, label=name)
        for name, tract in named
    ]
    return Panel(title="ball in gelatin", x="time / ms", y="depth / mm", curves=tuple(curves))


def convergence_panel(tracts: list[Tract], moved: list[Tract], turned: Tract) -> Panel:
    """Depth at the end over the grid spacing."""
    return Panel(
        title="depth after 0.3 ms",
        x="grid spacing / mm",
        y="depth / mm",
        curves=(
            Curve(
                x=1e3 * np.array([tract.spacing for tract in tracts]),
                y=1e3 * np.array([tract.depth for tract in tracts]),
                label="plain",
                kind="points",
            ),
            Curve(
                x=1e3 * np.array([tract.spacing for tract in (*moved, turned)]),
                y=1e3 * np.array([tract.depth for tract in (*moved, turned)]),
                label="grid shifted, setup turned",
                kind="points",
            ),
        ),
    )
