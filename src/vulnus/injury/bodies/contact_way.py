"""How far a body flies along a straight line until it touches tissue."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3

from ..particle_reading import JoinedParticles
from .shape_distance import clearance
from .shapes import Shape, Sphere

POINTS_AT_ONCE = 4096  # [chosen: the foremost tissue is among the first few thousand points]
MOST_STEPS = 200  # of a point towards a shape; a grazing one takes some tens
TOUCHING = 1e-3  # of a particle's spacing [chosen: far below what a grid resolves]
BESIDE = 0.71  # half a face's diagonal: how far beside its middle a particle's face reaches


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
        return cls(0.0, 0.0, _hull(shape))  # type: ignore[arg-type]  # by identity

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


@dataclass(frozen=True, slots=True, eq=False)
class _Faces:
    """Faces of particles towards a body: `points` (n, 3) [m] from its line, and their `spacing`."""

    points: FloatArray
    spacing: FloatArray


def way_to_contact(
    shape: Shape,
    rotation: FloatArray,
    place: Vector3,
    direction: FloatArray,
    particles: JoinedParticles,
    *,
    start: float = -np.inf,
) -> float | None:
    """Way [m] of the centre from `place` along `direction` to the first contact with tissue.

    None where the body meets none after the way `start` [m]. A particle meets the body with a face
    across the flight, half its spacing ahead of it and as far to the sides.
    """
    outline = Outline.of(shape)
    faces = _faces_beside(particles, place, direction, outline.width(direction, rotation))
    if not len(faces.points):
        return None
    reach = outline.reach(direction, rotation)
    found = [_way_of_tip(outline, rotation, direction, faces, start)]
    points = _nearest_to_line(faces, direction)
    if isinstance(shape, Sphere):
        found.append(_way_of_ball(shape.radius, direction, points, start))
    else:
        touching = TOUCHING * float(faces.spacing.min())
        found.append(
            _way_of_shape(
                shape, rotation, direction, points, start=start, reach=reach, touching=touching
            )
        )
    way = min(found)
    return way if np.isfinite(way) else None


def _faces_beside(
    particles: JoinedParticles, place: Vector3, direction: FloatArray, width: float
) -> _Faces:
    """Middles of the faces that a body of this `width` [m] can meet."""
    offset = particles.position - np.asarray(place)
    along = offset @ direction
    beside = np.einsum("ij,ij->i", offset, offset) - along**2
    spacing = np.cbrt(particles.volume)
    near = beside < (width + 0.5 * spacing) ** 2
    return _Faces(offset[near] - np.outer(0.5 * spacing[near], direction), spacing[near])


def _nearest_to_line(faces: _Faces, direction: FloatArray) -> FloatArray:
    """The place (n, 3) [m] of each face that is nearest to the line of flight."""
    across = faces.points - np.outer(faces.points @ direction, direction)
    apart = np.linalg.norm(across, axis=1)
    inwards = np.minimum(0.5 * faces.spacing, apart) / np.maximum(apart, 1e-300)
    nearest: FloatArray = faces.points - across * inwards[:, None]
    return nearest


def _way_of_tip(
    outline: Outline,
    rotation: FloatArray,
    direction: FloatArray,
    faces: _Faces,
    start: float,
) -> float:
    """Where the foremost point meets a face: a flat one across the flight, exactly."""
    tip = outline.radius * direction
    if len(outline.corners):
        turned = outline.corners @ rotation.T
        tip = turned[int(np.argmax(turned @ direction))]
    offset = faces.points - tip
    way = offset @ direction
    beside = np.linalg.norm(offset - np.outer(way, direction), axis=1)
    met = way[(beside < BESIDE * faces.spacing) & (way >= start)]
    return float(met.min(initial=np.inf))


def _way_of_ball(radius: float, direction: FloatArray, points: FloatArray, start: float) -> float:
    along = points @ direction
    beside = np.einsum("ij,ij->i", points, points) - along**2
    depth = np.sqrt(np.maximum(radius**2 - beside, 0.0))
    met = (beside < radius**2) & (along + depth >= start)
    return float(np.maximum(along - depth, start)[met].min(initial=np.inf))


def _way_of_shape(
    shape: Shape,
    rotation: FloatArray,
    direction: FloatArray,
    points: FloatArray,
    *,
    start: float,
    reach: float,
    touching: float,
) -> float:
    """Every point goes towards the shape by its clearance, the foremost points first."""
    length = float(np.linalg.norm(shape.upper - shape.lower))
    earliest = np.maximum(points @ direction - reach, start)
    ahead = earliest <= points @ direction + length
    order = np.flatnonzero(ahead)[np.argsort(earliest[ahead], kind="stable")]
    best = np.inf
    for first in range(0, len(order), POINTS_AT_ONCE):
        part = order[first : first + POINTS_AT_ONCE]
        if earliest[part[0]] >= best:
            break
        way, local = earliest[part].copy(), points[part] @ rotation
        last = points[part] @ direction + length
        for _ in range(MOST_STEPS):
            apart = clearance(shape, local - np.outer(way, direction @ rotation))
            met = apart <= touching
            best = min(best, float(way[met].min(initial=np.inf)))
            going = ~met & (way + apart < np.minimum(best, last))
            if not going.any():
                break
            way, local, last = way[going] + apart[going], local[going], last[going]
    return best


@lru_cache(maxsize=16)
def _hull(shape: Shape) -> FloatArray:
    """Corners (n, 3) [m] of the convex hull of the sampled inside."""
    from scipy.spatial import ConvexHull

    sampled = shape.distance
    assert sampled is not None  # every shape but the sphere is sampled
    inside = sampled.values <= 0.5 * sampled.spacing
    across = np.argwhere(inside.any(axis=2))
    row = inside[across[:, 0], across[:, 1]]
    first, last = row.argmax(axis=1), row.shape[1] - 1 - row[:, ::-1].argmax(axis=1)
    ends = np.concatenate([np.column_stack([across, first]), np.column_stack([across, last])])
    points = np.clip(sampled.lower + sampled.spacing * ends, shape.lower, shape.upper)
    corners: FloatArray = points[ConvexHull(points).vertices]
    return corners
