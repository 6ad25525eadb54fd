"""The deformation gradient of particles, from how their neighbours have moved."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray, IndexArray

NEIGHBOUR_REACH = 1.9
"""Distance of neighbours before the start over their spacing [chosen: the 26 around on a lattice,
12 in a Poisson-disk set]."""

LEAST_SPREAD = 1e-3
"""Least over largest spread of a point's neighbours from which a gradient is told [chosen]."""


def least_spacing(points: FloatArray) -> float:
    """Distance [m] to the nearest neighbour that only one point (n, 3) of twenty falls below."""
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(points).query(points, k=2)
    return float(np.quantile(np.asarray(distance)[:, 1], 0.05))


def deformation_gradient(
    reference: FloatArray, position: FloatArray, body: IndexArray
) -> FloatArray:
    """F (n, 3, 3) that takes the way to each neighbour in the same `body` to what it is now.

    By least squares, with the weight falling to none at the reach; NaN for a point whose neighbours
    do not span space.
    """
    from scipy.spatial import cKDTree

    count = len(reference)
    gradient = np.full((count, 3, 3), np.nan)
    if count < 2:
        return gradient
    reach = NEIGHBOUR_REACH * least_spacing(reference)
    pairs = cKDTree(reference).query_pairs(reach, output_type="ndarray")
    pairs = pairs[body[pairs[:, 0]] == body[pairs[:, 1]]]
    before = reference[pairs[:, 1]] - reference[pairs[:, 0]]
    now = position[pairs[:, 1]] - position[pairs[:, 0]]
    weight = 1.0 - np.einsum("ni,ni->n", before, before) / reach**2
    spread = _summed(before * weight[:, None], before, pairs, count)
    moved = _summed(now * weight[:, None], before, pairs, count)
    size = np.linalg.eigvalsh(spread)
    whole = size[:, 0] > LEAST_SPREAD * size[:, 2]
    gradient[whole] = moved[whole] @ np.linalg.inv(spread[whole])
    return gradient


def _summed(left: FloatArray, right: FloatArray, pairs: IndexArray, count: int) -> FloatArray:
    """Sum (count, 3, 3) over both ends of every pair of the outer products of their vectors."""
    total = np.empty((count, 3, 3))
    for i in range(3):
        for j in range(3):
            product = left[:, i] * right[:, j]
            total[:, i, j] = np.bincount(pairs[:, 0], product, count)
            total[:, i, j] += np.bincount(pairs[:, 1], product, count)
    return total
