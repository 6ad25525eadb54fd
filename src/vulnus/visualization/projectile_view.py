"""The projectile where it is at an instant, in its own shape."""

from __future__ import annotations

import numpy as np

from ..core.handoff import ShotLine, TriangleSurface
from .camera import unit


def projectile_surface(shot: ShotLine, time: float) -> TriangleSurface:
    """The sphere at `time` [s] since it touched the skin; it keeps its velocity."""
    from ..geometry import LevelSet

    radius = 0.5 * shot.diameter
    flown = shot.speed * time - radius
    centre = np.asarray(shot.entry_point) + flown * unit(shot.direction)
    return LevelSet.from_particles(centre[None], radius, voxel=radius / 8.0).to_surface()
