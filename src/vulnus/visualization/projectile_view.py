"""The projectiles where they are at an instant, in their own shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.handoff import ParticleFrame, ShotLine, TriangleSurface
from .camera import unit

POSITION, ROTATION = "projectile_position_m", "projectile_rotation"
"""Names in a frame's `frame_data`: places (b, 3) [m] and rotations (b, 9), row by row."""


def projectiles_in(
    frame: ParticleFrame, shot: ShotLine, shapes: Sequence[TriangleSurface] = ()
) -> list[TriangleSurface]:
    """The surface of each projectile in a frame.

    `shapes` are their surfaces in their own frames, mass centre at 0. A frame that does not say
    where they are has one sphere, which keeps its velocity.
    """
    if POSITION not in frame.frame_data or not shapes:
        return [_sphere(shot, frame.time)]
    places = np.asarray(frame.frame_data[POSITION], np.float64).reshape(-1, 3)
    turns = np.asarray(frame.frame_data[ROTATION], np.float64).reshape(-1, 3, 3)
    return [
        TriangleSurface(
            (shape.vertices @ turn.T + place).astype(np.float32), shape.triangles, shape.vertex_data
        )
        for shape, place, turn in zip(shapes, places, turns, strict=False)
    ]


def _sphere(shot: ShotLine, time: float) -> TriangleSurface:
    """The paper's sphere at `time` [s] since it touched the skin."""
    from ..geometry import LevelSet

    radius = 0.5 * shot.diameter
    flown = shot.speed * time - radius
    centre = np.asarray(shot.entry_point) + flown * unit(shot.direction)
    return LevelSet.from_particles(centre[None], radius, voxel=radius / 8.0).to_surface()
