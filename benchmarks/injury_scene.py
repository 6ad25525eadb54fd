"""The scene of the material point benchmarks: a cube of three tissues, sheared, and a ball."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.handoff import Tissue
from vulnus.injury.bodies.rigid_body import RigidBody
from vulnus.injury.bodies.shapes import Sphere
from vulnus.injury.materials import tissue_table
from vulnus.injury.solver import MpmSolver, Precision

SPACING = 0.003
PARTICLES_PER_CELL = 8
GRAVITY = (0.0, 0.0, -9.81)
BALL_VELOCITY = (0.0, 350.0, 0.0)


@dataclass(frozen=True, slots=True)
class Scene:
    """A cube of particles around the origin, sheared in space, with the ball at its face."""

    position: np.ndarray
    tissue: np.ndarray
    velocity: np.ndarray

    @property
    def volume(self) -> float:
        """Of one particle [m³]."""
        return SPACING**3 / PARTICLES_PER_CELL

    @property
    def half_edge(self) -> float:
        """Of the cube [m]."""
        return float(np.max(self.position))

    @property
    def ball_radius(self) -> float:
        """[m]."""
        return min(0.0045, self.half_edge / 3.0)

    @property
    def ball(self) -> RigidBody:
        """The ball at its start, without friction."""
        return RigidBody(
            shape=Sphere(self.ball_radius),
            centre=self.ball_centre,
            velocity=BALL_VELOCITY,
            friction=0.0,
        )

    @property
    def contact_radius(self) -> float:
        """Of the nodes that touch the ball [m]."""
        return self.ball_radius + self.ball.contact_margin(SPACING)

    @property
    def ball_centre(self) -> tuple[float, float, float]:
        """At the start [m]: the ball touches the cube."""
        return (0.0, -self.half_edge - self.ball_radius, 0.0)


def scene(count: int) -> Scene:
    """The scene with about `count` particles."""
    edge = round(count ** (1.0 / 3.0))
    step = SPACING / PARTICLES_PER_CELL ** (1.0 / 3.0)
    side = edge * step
    axis = (np.arange(edge) + 0.5) * step - 0.5 * side
    x = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    x += np.random.default_rng(0).uniform(-0.3, 0.3, x.shape) * step
    off_axis = np.hypot(x[:, 0], x[:, 1])
    tissue = np.full(len(x), Tissue.MUSCLE, np.uint8)
    tissue[off_axis > 0.45 * side] = Tissue.SKIN
    tissue[off_axis < 0.12 * side] = Tissue.BONE
    shear = 60.0 * np.sin(2.0 * np.pi / 0.015 * x[:, [1, 2, 0]])  # 2.5e4 /s: flows in some steps
    return Scene(x, tissue, shear)


def loaded_solver(
    case: Scene,
    *,
    largest_step: float = 1e30,
    precision: Precision = "float32",
    passage_steps: int | None = None,
) -> MpmSolver:
    """The solver with the scene's particles and ball; with `passage_steps` of 1 plain APIC."""
    reach = case.half_edge + 0.5
    solver = MpmSolver(
        materials=tissue_table(SPACING), grid_spacing=SPACING, lower=(-reach,) * 3,
        upper=(reach,) * 3, gravity=GRAVITY, bodies=[case.ball], largest_step=largest_step,
        precision=precision, passage_steps=passage_steps,
    )  # fmt: skip
    solver.set_particles(
        case.position,
        volume=np.full(len(case.position), case.volume),
        material=case.tissue,
        velocity=case.velocity,
    )
    return solver
