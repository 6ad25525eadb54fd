"""The surface of a rigid body's shape, for pictures."""

from __future__ import annotations

import numpy as np

from vulnus.core.handoff import TriangleSurface
from vulnus.geometry import LevelSet

from ..bodies.shapes import Shape, Sphere
from ..parameters import InjuryParameters
from .flying_bodies import shape_of

_SPHERE_VOXELS = 10  # of a radius; chosen: round to the eye at any size


def projectile_surfaces(parameters: InjuryParameters) -> tuple[TriangleSurface, ...]:
    """The surface of each projectile of a run in its body's frame, in the order of its frames."""
    others = (shot.projectile for shot in parameters.other_shots)
    return tuple(body_surface(shape_of(one)) for one in (parameters.projectile, *others))


def body_surface(shape: Shape) -> TriangleSurface:
    """The closed surface of a shape in its body's frame: mass centre at 0, nose towards +x [m]."""
    if isinstance(shape, Sphere):
        voxel = shape.radius / _SPHERE_VOXELS
        return LevelSet.from_particles(np.zeros((1, 3)), shape.radius, voxel=voxel).to_surface()
    sampled = shape.distance
    assert sampled is not None  # every shape but the sphere is sampled
    return LevelSet.from_dense(
        sampled.values,
        origin=sampled.lower,
        spacing=np.full(3, sampled.spacing),
        direction=np.eye(3),
        voxel=sampled.spacing,
    ).to_surface()
