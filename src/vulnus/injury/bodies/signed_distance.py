"""Signed distances sampled on a grid, and what of a body follows from them by quadrature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, Float32Array, FloatArray
from vulnus.core.errors import ScenarioError

POINTS_ACROSS = 16
"""Sampling points across the thinnest part; chosen: volumes and inertia within 1 %."""

MOST_POINTS = 3_000_000
"""Largest number of sampling points; chosen: 12 MB, and 5 s for the slowest shape."""

COARSEST = 0.5
"""Spacing of the samples over the thinnest part at most [chosen: two across still show it]."""

DistanceFunction = Callable[[AnyArray, AnyArray, AnyArray], AnyArray]
"""Signed distance [m] at x, y, z [m] of one shape, which broadcast."""


@dataclass(frozen=True, slots=True, eq=False)
class SignedDistance:
    """Signed distance [m], negative inside, at `lower` [m] + `spacing` [m] · (i, j, k)."""

    values: Float32Array
    lower: FloatArray
    spacing: float

    def axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coordinates [m] along the three axes, shaped to broadcast."""
        x, y, z = (
            self.lower[a] + self.spacing * np.arange(self.values.shape[a], dtype=np.float64)
            for a in range(3)
        )
        return x[:, None, None], y[None, :, None], z[None, None, :]

    def moved(self, offset: FloatArray) -> SignedDistance:
        """The same with its origin at `offset` [m]."""
        return SignedDistance(self.values, self.lower - offset, self.spacing)


@dataclass(frozen=True, slots=True, eq=False)
class SolidProperties:
    """Volume [m³], centre of mass (3,) [m], inertia (3, 3) [m⁵] about it, for unit density."""

    volume: float
    centre: FloatArray
    inertia: FloatArray


def sampling_grid(
    lower: FloatArray, upper: FloatArray, thinnest: float
) -> tuple[FloatArray, float, tuple[int, int, int]]:
    """First point [m], spacing [m] and counts of a grid around the box [lower, upper] [m].

    A point stands at the box's centre; the margin is a quarter of the `thinnest` part [m].
    """
    extent = upper - lower + 0.5 * thinnest
    spacing = max(thinnest / POINTS_ACROSS, float(np.prod(extent) / MOST_POINTS) ** (1.0 / 3.0))
    if spacing > COARSEST * thinnest:
        raise ScenarioError(
            "shape",
            f"with the edges {(upper - lower).tolist()} m is too slender to be sampled: it is "
            f"{thinnest:g} m thin, {MOST_POINTS:g} points are {spacing:.2g} m apart",
            "Make it thicker, smaller across, or check the units: lengths are metres.",
        )
    half = np.ceil(0.5 * extent / spacing).astype(int) + 1
    nx, ny, nz = (int(2 * h + 1) for h in half)
    return 0.5 * (lower + upper) - half * spacing, spacing, (nx, ny, nz)


def sample(
    function: DistanceFunction, lower: FloatArray, upper: FloatArray, thinnest: float
) -> SignedDistance:
    """Sample a distance around the box [lower, upper] [m] of a shape `thinnest` [m] somewhere."""
    first, spacing, counts = sampling_grid(lower, upper, thinnest)
    grid = SignedDistance(np.empty(counts, np.float32), first, spacing)
    x, y, z = grid.axes()
    for i in range(counts[0]):
        grid.values[i] = function(x[i], y[0], z[0])
    return grid


def solid_properties(distance: SignedDistance) -> SolidProperties:
    """Sums over the cells; a cell that the surface cuts counts in part."""
    share = np.clip(0.5 - distance.values / distance.spacing, 0.0, 1.0).astype(np.float64)
    axes = distance.axes()
    sums = share.sum(axis=(1, 2)), share.sum(axis=(0, 2)), share.sum(axis=(0, 1))
    total = float(sums[0].sum())
    x, y, z = (axis.ravel() for axis in axes)
    centre = np.array([s @ c / total for s, c in zip(sums, (x, y, z), strict=True)])
    x, y, z = x - centre[0], y - centre[1], z - centre[2]
    xx, yy, zz = sums[0] @ x**2, sums[1] @ y**2, sums[2] @ z**2
    xy = float(x @ share.sum(axis=2) @ y)
    yz = float(y @ share.sum(axis=0) @ z)
    xz = float(x @ share.sum(axis=1) @ z)
    inertia = np.array([[yy + zz, -xy, -xz], [-xy, xx + zz, -yz], [-xz, -yz, xx + yy]])
    cell = distance.spacing**3
    return SolidProperties(volume=total * cell, centre=centre, inertia=inertia * cell)
