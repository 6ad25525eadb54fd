"""A rigid body on its way through tissue: where it begins, where it enters, how deep it is."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ProjectileError

from ..checked_values import unit_vector
from ..particle_reading import JoinedParticles
from .contact_way import Outline, way_to_contact
from .rigid_body import BodyState, RigidBody
from .shape_distance import distance_to
from .solids import triple

DEEPEST_START = 0.5  # cells a particle may be inside a body before the start [chosen: contact]


class Flight:
    """A body's straight line of flight as it was aimed, and the depth along it."""

    def __init__(self, body: RigidBody, particles: JoinedParticles) -> None:
        self.outline = Outline.of(body.shape)
        self.direction = aimed_direction(body)
        self._start = np.asarray(body.place)
        self._entry = float("nan")
        if self.direction is not None:
            way = way_to_contact(
                body.shape, body.turn, body.place, self.direction, particles, start=0.0
            )
            if way is not None:
                self._entry = way + self.outline.reach(self.direction, body.turn)

    @property
    def meets_tissue(self) -> bool:
        """Whether there is tissue on its line."""
        return bool(np.isfinite(self._entry))

    def depth(self, state: BodyState, time: float) -> float:
        """How far [m] the foremost point is beyond its place at first contact; NaN without one.

        Negative before contact. Along the direction of the start, also when the body turns off.
        """
        if self.direction is None:
            return float("nan")
        way = float((state.position - self._start) @ self.direction)
        return way + self.outline.reach(self.direction, state.rotation, time) - self._entry

    def foremost(self, state: BodyState, time: float) -> FloatArray:
        """Place (3,) [m] ahead of the centre along the flight, as far as the foremost point is.

        Along the present velocity; along the direction of the start where it has turned back.
        """
        if self.direction is None:
            return np.array(state.position)
        onwards = float(state.velocity @ self.direction) > 0.0
        heading = self.direction
        if onwards:
            heading = np.array(unit_vector("velocity", state.velocity))
        ahead: FloatArray = (
            state.position + self.outline.reach(heading, state.rotation, time) * heading
        )
        return ahead


def aimed_direction(body: RigidBody) -> FloatArray | None:
    """Unit vector (3,) of the flight at the start, None for a body that stands."""
    way = np.asarray(body.velocity, np.float64)
    if body.path is not None:
        steps = np.diff(np.asarray(body.path.positions, np.float64), axis=0)
        moving = np.flatnonzero(np.linalg.norm(steps, axis=1) > 0.0)
        way = steps[moving[0]] if len(moving) else np.zeros(3)
    return np.array(unit_vector("direction", way)) if way.any() else None


def start_before_contact(
    body: RigidBody, particles: JoinedParticles, *, target: Vector3, gap: float, name: str
) -> Vector3:
    """Centre [m] on the line through `target` from which `gap` [m] is left to the first contact."""
    direction = aimed_direction(body)
    assert direction is not None  # a projectile has a speed
    way = way_to_contact(body.shape, body.turn, target, direction, particles)
    if way is None:
        raise ProjectileError(
            name,
            f"its line through {target} m along {direction.round(4).tolist()} meets no tissue",
            "Check target and direction.",
        )
    return triple(np.asarray(target) + (way - gap) * direction)


def refuse_start_inside(body: RigidBody, particles: JoinedParticles, grid_spacing: float) -> None:
    """Refuse a body that begins inside tissue."""
    local = (particles.position - np.asarray(body.place)) @ body.turn
    lower, upper = body.shape.lower, body.shape.upper
    near = np.flatnonzero(((local > lower) & (local < upper)).all(axis=1))
    deep = near[distance_to(body.shape, local[near]) < -DEEPEST_START * grid_spacing]
    if len(deep):
        place = particles.position[deep[0]].round(6).tolist()
        raise ProjectileError(
            body.name,
            f"begins inside tissue: {len(deep)} particles are in it, the first at {place} m",
            "Move it back, or take its room out of the body of tissue.",
        )
