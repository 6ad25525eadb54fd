"""Distance of points to the shape of a rigid body, in its own frame."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray

from .shapes import Shape, Sphere


def distance_to(shape: Shape, local: FloatArray) -> FloatArray:
    """Signed distance (n,) [m] of points (n, 3) [m] from the centre of mass, negative inside.

    Trilinear between the samples; beyond them, the way to the sampled box is added.
    """
    found, beyond = _sampled_distance(shape, local)
    return found + beyond


def clearance(shape: Shape, local: FloatArray) -> FloatArray:
    """At most the distance (n,) [m] of points (n, 3) [m] from the shape, negative inside."""
    found, beyond = _sampled_distance(shape, local)
    nearest: FloatArray = np.where(beyond > 0.0, np.maximum(beyond, found - beyond), found)
    return nearest


def _sampled_distance(shape: Shape, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distance (n,) [m] at the nearest point of the sampled box, and that from there."""
    if isinstance(shape, Sphere):
        ball: FloatArray = np.linalg.norm(local, axis=1) - shape.radius
        return ball, np.zeros(len(local))
    from scipy.ndimage import map_coordinates

    sampled = shape.distance
    assert sampled is not None  # every shape but the sphere is sampled
    index = (local - sampled.lower) / sampled.spacing
    inside = np.clip(index, 0.0, np.array(sampled.values.shape) - 1.0)
    found: FloatArray = map_coordinates(sampled.values.astype(np.float64), inside.T, order=1)
    beyond: FloatArray = sampled.spacing * np.linalg.norm(index - inside, axis=1)
    return found, beyond
