"""A rigid body on its way through tissue: where it begins, where it enters, how deep it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ProjectileError

from .particle_reading import JoinedParticles
from .rigid_body import BodyState, RigidBody
from .shape_distance import distance_to
from .shapes import Shape, Sphere
from .solids import triple

DEEPEST_START = 0.5  # cells a particle may be inside a body before the start [chosen: contact]


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """What a shape reaches: `radius` [m] of a ball, or points (n, 3) [m] of its convex hull."""

    radius: float
    growth: float
    corners: FloatArray

    @classmethod
    def of(cls, shape: Shape) -> Outline:
        """The outline of a shape, in the body's frame from its centre of mass."""
        if isinstance(shape, Sphere):
            return cls(shape.radius, shape.expansion_speed, np.zeros((0, 3)))
        return cls(0.0, 0.0, _hull(shape))

    def reach(self, direction: FloatArray, rotation: FloatArray, time: float = 0.0) -> float:
        """How far [m] the foremost point is ahead of the centre along a world `direction`."""
        if not len(self.corners):
            return self.radius + self.growth * time
        return float(np.max(self.corners @ (rotation.T @ direction)))

    def width(self, direction: FloatArray, rotation: FloatArray) -> float:
        """Largest distance [m] of any point from the line through the centre along `direction`."""
        if not len(self.corners):
            return self.radius
        turned = self.corners @ rotation.T
        across = turned - np.outer(turned @ direction, direction)
        return float(np.max(np.linalg.norm(across, axis=1)))


class Flight:
    """A body's straight line of flight as it was aimed, and the depth along it."""

    def __init__(self, body: RigidBody, particles: JoinedParticles) -> None:
        self._outline = Outline.of(body.shape)
        self.direction = aimed_direction(body)
        self._entry = float("nan")
        if self.direction is not None:
            width = self._outline.width(self.direction, body.turn)
            first = first_contact(particles, body.place, self.direction, width, behind=0.0)
            self._entry = float("nan") if first is None else first
        self._start = np.asarray(body.place)

    def depth(self, state: BodyState, time: float) -> float:
        """How far [m] the foremost point is behind the surface it flew at; NaN without a line.

        Negative before contact. Along the direction of the start, also when the body turns off.
        """
        if self.direction is None:
            return float("nan")
        way = float((state.position - self._start) @ self.direction)
        return way + self._outline.reach(self.direction, state.rotation, time) - self._entry


def aimed_direction(body: RigidBody) -> FloatArray | None:
    """Unit vector (3,) of the flight at the start, None for a body that stands."""
    way = np.asarray(body.velocity, np.float64)
    if body.path is not None:
        steps = np.diff(np.asarray(body.path.positions, np.float64), axis=0)
        moving = np.flatnonzero(np.linalg.norm(steps, axis=1) > 0.0)
        way = steps[moving[0]] if len(moving) else np.zeros(3)
    length = float(np.linalg.norm(way))
    return None if length == 0.0 else way / length


def first_contact(
    particles: JoinedParticles,
    point: Vector3,
    direction: FloatArray,
    width: float,
    *,
    behind: float = -np.inf,
) -> float | None:
    """Distance [m] from `point` along `direction` to the first tissue within `width` [m] of it.

    Tissue at less than the distance `behind` does not count.
    """
    offset = particles.position - np.asarray(point)
    along = offset @ direction
    beside = np.einsum("ij,ij->i", offset, offset) - along**2
    spacing = np.cbrt(particles.volume)
    near = (beside < (width + 0.5 * spacing) ** 2) & (along > behind)
    return float(np.min(along[near] - 0.5 * spacing[near])) if near.any() else None


def start_before_contact(
    body: RigidBody, particles: JoinedParticles, *, target: Vector3, gap: float, name: str
) -> Vector3:
    """Centre [m] on the line through `target` from which `gap` [m] is left to the first contact."""
    outline, direction = Outline.of(body.shape), aimed_direction(body)
    assert direction is not None  # a projectile has a speed
    first = first_contact(particles, target, direction, outline.width(direction, body.turn))
    if first is None:
        raise ProjectileError(
            name,
            f"its line through {target} m along {direction.round(4).tolist()} meets no tissue",
            "Check target and direction.",
        )
    way = first - gap - outline.reach(direction, body.turn)
    return triple(np.asarray(target) + way * direction)


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


def _hull(shape: Shape) -> FloatArray:
    """Corners (n, 3) [m] of the convex hull of the sampled inside."""
    from scipy.spatial import ConvexHull

    sampled = shape.distance
    assert sampled is not None  # every shape but the sphere is sampled
    inside = np.argwhere(sampled.values <= 0.5 * sampled.spacing)
    points = np.clip(sampled.lower + sampled.spacing * inside, shape.lower, shape.upper)
    corners: FloatArray = points[ConvexHull(points).vertices]
    return corners
