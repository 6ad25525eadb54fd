"""Points that stand for the room a projectile takes, among those of the tissue."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray

from ..bodies.shape_distance import distance_to
from ..bodies.shapes import Shape
from ..bodies.solids import FilledPoints

POINTS_PER_SPACING = 2.0
"""Points a spacing of the tissue's, along each axis; chosen: finer than the cavity's voxels."""


def body_filling(shape: Shape, pose: FloatArray, spacing: float) -> FilledPoints:
    """Points inside a body whose volumes add up to its own, for tissue of this `spacing` [m].

    `pose` (12,) is the place of its middle [m] and the rows of its rotation.
    """
    step = spacing / POINTS_PER_SPACING
    counts = np.maximum(1, np.rint((shape.upper - shape.lower) / step)).astype(int)
    axes = [
        low + (np.arange(count) + 0.5) * (high - low) / count
        for low, high, count in zip(shape.lower, shape.upper, counts, strict=True)
    ]
    local = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = local[distance_to(shape, local) < 0.0]
    if len(inside) == 0:
        inside = np.zeros((1, 3))
    place = pose[:3] + inside @ pose[3:].reshape(3, 3).T
    return FilledPoints(place, np.full(len(place), shape.volume / len(place)))
