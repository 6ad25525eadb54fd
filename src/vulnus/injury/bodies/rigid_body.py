"""Rigid bodies among the tissue: projectiles, blades, plates.

A body is kinematic (keeps its velocity and spin), guided (follows a path) or dynamic (six degrees
of freedom, moved by the impulses that the tissue gives it). Bodies do not touch one another.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from .. import _native
from ..checked_values import (
    is_a,
    not_a_number,
    not_negative,
    not_too_fast,
    numbers,
    shown,
    true_or_false,
    unit_vector,
    vector,
)
from .rotations import rotation_matrix
from .shapes import SampledShape, Shape, Sphere

Motion = Literal["kinematic", "dynamic"]

CONTACT_MARGIN = 0.2
"""Distance [cells] from a body's surface within which nodes touch it; chosen: with it a ball of
five cells leaves a hole of its own radius in gel within 10 %, as
tests/physics/test_injury_contact_radius.py measures (0 leaves one 10-17 % too small)."""

SMALLEST_RADIUS = 0.9
"""Least acting inner radius [cells]; chosen: half a cell's diagonal is 0.87, and a smaller body
could pass between the nodes."""

SMALLEST_BLADE = 0.5
"""Least acting half thickness [cells] of a cutting body; chosen: one layer of nodes."""

SHAPE_KEYS = ("volume", "unit_inertia", "lower", "upper", "inner_radius", "distance")
"""What a shape of one's own must have, see `Shape`."""

STATE_ROWS = {
    "position": slice(0, 3),
    "velocity": slice(3, 6),
    "orientation": slice(6, 10),
    "angular_velocity": slice(10, 13),
    "angular_momentum": slice(13, 16),
    "impulse": slice(16, 19),
    "angular_impulse": slice(19, 22),
    "normal_impulse": slice(22, 23),
    "work": slice(23, 24),
}
"""Where the values of a body stand among those of `native/injury/rigid_body.hpp`."""
STATE_SIZE = 24


@dataclass(frozen=True, slots=True, eq=False)
class BodyPath:
    """A path of the centre: `times` (n,) [s], growing, and `positions` (n, 3) [m].

    Linear between the points; before the first and after the last the body stands.
    """

    times: FloatArray
    positions: FloatArray

    def __post_init__(self) -> None:
        """Refuse times that do not grow and places that do not match them."""
        times, positions = numbers(self.times), numbers(self.positions)
        if times.ndim != 1 or len(times) < 2 or not np.all(np.diff(times) > 0.0):
            raise ScenarioError(
                "path times", "must be at least two growing numbers", "Sort and thin them."
            )
        if positions.shape != (len(times), 3):
            raise ScenarioError(
                "path positions",
                f"have shape {positions.shape}, must be ({len(times)}, 3)",
                "Give one place (x, y, z) for every time.",
            )
        if not (np.all(np.isfinite(times)) and np.all(np.isfinite(positions))):
            raise ScenarioError("path", "holds a value that is not finite", "Check the path.")
        with np.errstate(over="ignore"):
            pace = np.linalg.norm(np.diff(positions, axis=0), axis=1) / np.diff(times)
        not_too_fast("path", float(np.max(pace)))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "positions", positions)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigidBody:
    """A rigid body at time 0; `centre` [m] is its centre of mass, by default the path's start.

    `rotation` (3, 3) turns the body's frame into the world's; `mass` [kg] is needed by a dynamic
    body; `cutting` breaks the particles that the body sweeps. A dynamic body with a `rail` moves
    only along this direction and does not turn: one whose centre is on planes of symmetry, where
    half or a quarter of the tissue is computed, with half or a quarter of its mass.
    """

    shape: Shape
    centre: Vector3 | None = None
    velocity: Vector3 = (0.0, 0.0, 0.0)
    rotation: FloatArray | None = None
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)
    motion: Motion = "kinematic"
    mass: float | None = None
    friction: float = 0.1  # chosen: wet tissue on polished metal
    cutting: bool = False
    path: BodyPath | None = None
    rail: Vector3 | None = None
    name: str = "projectile"

    def __post_init__(self) -> None:
        """Refuse what cannot move as told; numbers are kept as floats."""
        if not isinstance(self.motion, str) or self.motion not in ("kinematic", "dynamic"):
            raise ScenarioError(
                f"{self.name} motion", f"is {shown(self.motion)}", 'Use "kinematic" or "dynamic".'
            )
        self._check_kinds()
        if self.centre is None and self.path is None:
            raise ScenarioError(
                f"{self.name} centre", "is missing", "Give its centre or a path to follow."
            )
        for key in ("centre", "velocity", "angular_velocity"):
            if key != "centre" or self.centre is not None:
                object.__setattr__(self, key, vector(f"{self.name} {key}", getattr(self, key)))
        not_too_fast(self.name, math.hypot(*self.velocity))
        friction = not_negative(f"{self.name} friction", self.friction)
        object.__setattr__(self, "friction", friction)
        if self.rotation is not None:
            object.__setattr__(self, "rotation", self._checked_rotation())
        self._check_motion()
        self._check_rail()

    def _check_kinds(self) -> None:
        """Refuse pieces that are something else."""
        known = isinstance(self.shape, Sphere | SampledShape)
        if not known and not all(hasattr(type(self.shape), key) for key in SHAPE_KEYS):
            raise ScenarioError(
                f"{self.name} shape",
                f"is {shown(self.shape)}",
                "Give a Sphere, Cylinder, Ogive, Box, BladeShape or MeshShape.",
            )
        if self.path is not None:
            is_a(f"{self.name} path", self.path, BodyPath, "Give a BodyPath(times, positions).")
        true_or_false(f"{self.name} cutting", self.cutting)

    def _checked_rotation(self) -> FloatArray:
        try:
            return rotation_matrix(self.rotation)
        except ScenarioError as error:
            raise ScenarioError(f"{self.name} rotation", error.problem, error.advice) from None

    def _check_motion(self) -> None:
        mass = 0.0 if self.mass is None and self.motion == "dynamic" else self.mass
        if mass is not None and (not_a_number(mass) or not mass > 0.0):
            told = f"is {shown(self.mass)}, must be > 0 kg"
            raise ScenarioError(f"{self.name} mass", told, "Give its mass.")
        if self.path is not None and any(self.velocity):
            raise ScenarioError(
                f"{self.name} velocity",
                "goes with a path",
                "Leave it out.",
            )
        if self.motion == "dynamic":
            if self.path is not None:
                raise ScenarioError(
                    f"{self.name} path", "goes with a dynamic body", "Use a kinematic one."
                )
            return
        if self.path is None:
            return
        for key in ("velocity", "angular_velocity"):
            if np.any(getattr(self, key)):
                raise ScenarioError(
                    f"{self.name} {key}",
                    "goes with a path, which alone says how the body moves, without turning",
                    "Leave one of them out.",
                )
        if self.centre is not None:
            apart = np.linalg.norm(np.subtract(self.centre, self.path.positions[0]))
            if apart > 1e-9:
                raise ScenarioError(
                    f"{self.name} centre",
                    f"is {1e3 * apart:g} mm from the path's first place",
                    "Leave it out: a guided body starts there.",
                )

    def _check_rail(self) -> None:
        if self.rail is None:
            return
        if self.motion != "dynamic":
            raise ScenarioError(
                f"{self.name} rail", "goes with a kinematic body", "Use a dynamic one."
            )
        along = unit_vector(f"{self.name} rail", self.rail)
        across = np.subtract(self.velocity, np.dot(self.velocity, along) * np.asarray(along))
        if np.linalg.norm(across) > 1e-6 * np.linalg.norm(self.velocity):
            raise ScenarioError(f"{self.name} rail", "is not along its velocity", "Turn one.")
        if np.any(self.angular_velocity):
            raise ScenarioError(f"{self.name} rail", "goes with a spin", "Leave one of them out.")

    @property
    def place(self) -> Vector3:
        """Centre of mass [m] at time 0."""
        if self.centre is not None:
            return self.centre
        assert self.path is not None
        x, y, z = (float(v) for v in self.path.positions[0])
        return x, y, z

    @property
    def turn(self) -> FloatArray:
        """Rotation (3, 3) of the body's frame into the world's at time 0."""
        return np.eye(3) if self.rotation is None else np.asarray(self.rotation, np.float64)

    @property
    def inertia(self) -> FloatArray:
        """Inertia tensor (3, 3) [kg m²] in the body's frame; of unit mass where none is given."""
        return self.shape.unit_inertia * ((self.mass or 1.0) / self.shape.volume)

    def contact_margin(self, grid_spacing: float) -> float:
        """Distance [m] from its surface within which nodes of this spacing [m] touch it.

        More for bodies so small or thin that they would slip between the nodes; a blade touches
        what is in it.
        """
        smallest = SMALLEST_BLADE if self.cutting else SMALLEST_RADIUS
        margin = 0.0 if self.cutting else CONTACT_MARGIN
        missing = smallest * grid_spacing - self.shape.inner_radius
        return max(margin * grid_spacing, missing)


@dataclass(frozen=True, slots=True, eq=False)
class BodyState:
    """A body at the solver's time, and what contact has done to it since time 0.

    `rotation` (3, 3) turns its frame into the world's; `impulse` [N s] and `angular_impulse`
    [N m s] (about the centre) are those that the tissue gave it; `normal_impulse` [N s] sums the
    sizes of all normal impulses; `work` [J] is what it did on the tissue.
    """

    name: str
    position: FloatArray
    velocity: FloatArray
    rotation: FloatArray
    angular_velocity: FloatArray
    impulse: FloatArray
    angular_impulse: FloatArray
    normal_impulse: float
    work: float

    @classmethod
    def from_row(cls, name: str, row: FloatArray, origin: FloatArray) -> BodyState:
        """Read the native values of a body; `origin` [m] is that of the solver's frame."""
        part = {key: np.array(row[place]) for key, place in STATE_ROWS.items()}
        return cls(
            name=name,
            position=part["position"] + origin,
            velocity=part["velocity"],
            rotation=rotation_of(part["orientation"]),
            angular_velocity=part["angular_velocity"],
            impulse=part["impulse"],
            angular_impulse=part["angular_impulse"],
            normal_impulse=float(part["normal_impulse"][0]),
            work=float(part["work"][0]),
        )


def add_body(
    solver: _native.Solver32, body: RigidBody, *, origin: FloatArray, grid_spacing: float
) -> None:
    """Give a body to the native solver, whose frame has its `origin` [m] there."""
    path = np.zeros((0, 4))
    if body.path is not None:
        path = np.column_stack([body.path.times, np.asarray(body.path.positions) - origin])
    native = _native.RigidBody.make(
        motion=2 if body.path is not None else int(body.motion == "dynamic"),
        mass=body.mass or 1.0,
        inertia=np.ascontiguousarray(body.inertia),
        inverse_inertia=np.ascontiguousarray(np.linalg.inv(body.inertia)),
        friction=body.friction,
        margin=body.contact_margin(grid_spacing),
        cutting=body.cutting,
        rail=(0.0, 0.0, 0.0) if body.rail is None else unit_vector("rail", body.rail),
        path=np.ascontiguousarray(path, dtype=np.float64),
    )
    state = np.zeros(STATE_SIZE)
    state[STATE_ROWS["position"]] = np.asarray(body.place) - origin
    state[STATE_ROWS["velocity"]] = body.velocity
    state[STATE_ROWS["orientation"]] = orientation_of(body.turn)
    state[STATE_ROWS["angular_velocity"]] = body.angular_velocity
    world_inertia = body.turn @ body.inertia @ body.turn.T
    state[STATE_ROWS["angular_momentum"]] = world_inertia @ np.asarray(body.angular_velocity)
    solver.add_body(_native_shape(body.shape), native, state)


def _native_shape(shape: Shape) -> _native.BodyShape:
    sampled = shape.distance
    values = np.zeros((2, 2, 2), np.float32) if sampled is None else sampled.values
    lower = np.zeros(3) if sampled is None else sampled.lower
    return _native.BodyShape.make(
        radius=shape.radius if isinstance(shape, Sphere) else 0.0,
        expansion_speed=shape.expansion_speed if isinstance(shape, Sphere) else 0.0,
        distance=np.ascontiguousarray(values, dtype=np.float32),
        distance_lower=_triple(lower),
        distance_spacing=1.0 if sampled is None else sampled.spacing,
        lower=_triple(shape.lower),
        upper=_triple(shape.upper),
        inner_radius=shape.inner_radius,
    )


def orientation_of(rotation: FloatArray) -> FloatArray:
    """Unit quaternion (4,) w x y z of a rotation (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z])


def rotation_of(orientation: FloatArray) -> FloatArray:
    """Rotation (3, 3) of a unit quaternion (4,) w x y z."""
    from scipy.spatial.transform import Rotation

    w, x, y, z = orientation
    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix(), np.float64)


def _triple(values: FloatArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
