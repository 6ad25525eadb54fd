"""A signed distance on a regular grid around the limb, and solids made of material points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, Float32Array, FloatArray

from . import _native

CLOSING_REACH = 2.0
"""Radius of the closing of a solid's material points over their spacing. With `SOLID_RADIUS` it
closes gaps up to 1.4 spacings from the nearest point. Chosen: a Poisson-disk set leaves gaps up to
1, unbroken skin stretches them to 1.5 (ultimate stretch 1.54, PHYSICS §1.1); wider are holes."""

SOLID_RADIUS = 0.6
"""How far a solid extends beyond its outermost points, over their spacing. Chosen: half the mean
distance of neighbours in a Poisson-disk set (1.2)."""


@dataclass(frozen=True, slots=True, eq=False)
class NodeGrid:
    """Nodes at `origin + cell * (i, j, k)` [m]; `shape` counts them along x, y, z."""

    origin: FloatArray
    cell: float
    shape: tuple[int, int, int]

    @classmethod
    def around(cls, lower: AnyArray, upper: AnyArray, cell: float, margin: float) -> NodeGrid:
        """The grid over a box [m] with a margin [m]."""
        origin = np.asarray(lower, dtype=np.float64) - margin
        counts = np.ceil((np.asarray(upper) + margin - origin) / cell).astype(int) + 1
        return cls(origin, cell, (int(counts[0]), int(counts[1]), int(counts[2])))

    @property
    def corner(self) -> tuple[float, float, float]:
        """The origin as a tuple [m]."""
        return (float(self.origin[0]), float(self.origin[1]), float(self.origin[2]))

    @property
    def node_count(self) -> int:
        """How many nodes there are."""
        return int(np.prod(self.shape))

    def axis(self, axis: int) -> FloatArray:
        """Coordinates of the nodes along an axis [m]."""
        return np.asarray(self.origin[axis] + self.cell * np.arange(self.shape[axis]))

    def distance_to(self, points: AnyArray, reach: float) -> Float32Array:
        """Distance of each node to the nearest point [m], at most `reach`."""
        contiguous = np.ascontiguousarray(points, dtype=np.float32).reshape(-1, 3)
        return _native.nearest_distance(contiguous, self.corner, self.cell, self.shape, reach)

    def sample(self, values: Float32Array, points: AnyArray) -> tuple[FloatArray, FloatArray]:
        """A distance field and its unit gradient at points (n, 3) [m]; 1 km outside the grid."""
        contiguous = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        return _native.sample_distance(contiguous, self.corner, self.cell, values)


def closed_solid(grid: NodeGrid, points: AnyArray, spacing: float) -> Float32Array:
    """Signed distance [m] of the solid that material points stand for, watertight between them.

    A closing of the points by balls: dilated by `CLOSING_REACH`, eroded back to `SOLID_RADIUS`
    times the spacing.
    """
    reach = CLOSING_REACH * spacing
    radius = SOLID_RADIUS * spacing
    if len(points) == 0:
        return np.full(grid.shape, np.float32(reach), dtype=np.float32)
    import edt

    outside = grid.distance_to(points, reach + 2.0 * grid.cell)
    dilated = outside < reach
    depth: Float32Array = edt.edt(dilated, anisotropy=(grid.cell,) * 3, parallel=0)
    depth -= np.float32(0.5 * grid.cell)  # to the surface, not to the first node outside
    np.subtract(outside, np.float32(radius), out=outside)
    inside = np.float32(reach - radius) - depth
    return np.where(dilated, inside, outside)
