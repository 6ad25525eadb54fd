"""The cavity: space that tissue encloses and has left.

A point of space is enclosed where tissue stands in most of 26 directions around it: inside a tract
that is open at both ends as well as inside a closed hole, but not in front of the limb. Volumes
are integrals of 1 - (share of tissue), so that they do not depend on where a voxel's centre lies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vulnus.core.arrays import AnyArray, BoolArray, Float32Array, FloatArray

VOXELS_PER_SPACING = 1.5
"""Voxels a spacing of the points; chosen: a sphere of 4 spacings is within 3 %."""

SMOOTHING = 0.6
"""Width (standard deviation) of a point's cloud over the spacing; chosen: it covers 10 points, so
that their irregular places leave the share within a tenth of 1 in whole tissue."""

OPEN_SHARE = 0.5
"""Share of tissue below which a place is empty: half, so that a flat surface stays in place."""

ENCLOSING_DIRECTIONS = 13
"""Directions of 26 with tissue in them from which a place is enclosed: half. Just outside a flat
surface it is 8 or 9, in the mouth of a tract 16."""

RIM = 2.0
"""How far around empty places missing tissue counts, over the spacing: the cloud's reach."""

LEAST_VOLUME = 4.0
"""Holes smaller than this many cubes of the spacing are gaps between points; chosen."""

VOXEL_LIMIT = 20_000_000
"""Voxels at most; the voxel grows to keep it. Chosen: 200 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class Cavity:
    """Empty space [m³] of voxels whose centres lie at `origin + cell * (i, j, k)` [m].

    `void` (n,) [m³] of the voxels at `index` (n, 3); the others have none.
    """

    origin: FloatArray
    cell: float
    index: NDArray[np.int64]
    void: FloatArray

    @property
    def volume(self) -> float:
        """The whole cavity [m³]."""
        return max(float(self.void.sum()), 0.0)

    @property
    def centres(self) -> FloatArray:
        """Centres (n, 3) [m] of its voxels."""
        return np.asarray(self.origin + self.cell * self.index)


def cavity_volume(
    positions: AnyArray,
    spacing: float,
    *,
    volume: AnyArray | None = None,
    box: tuple[AnyArray, AnyArray] | None = None,
) -> float:
    """Volume [m³] that material points at `positions` (n, 3) [m] enclose and do not fill.

    `spacing` [m] is their mean distance: the cube root of the volume of one. `volume` (n,) [m³],
    where they differ. `box` holds two corners [m] of the space that is looked at; by default that
    of the points, without the hundredth that has flown farthest. A hole that is open to outside,
    as a tract, ends where less than half of the directions meet tissue, flush with the surface.
    Holes narrower than about two spacings are not seen; a sphere of four is measured to 5 %.
    """
    return find_cavity(positions, spacing, volume=volume, box=box).volume


def find_cavity(
    positions: AnyArray,
    spacing: float,
    *,
    volume: AnyArray | None = None,
    box: tuple[AnyArray, AnyArray] | None = None,
) -> Cavity:
    """The empty voxels behind `cavity_volume`, which see."""
    from scipy.ndimage import binary_dilation, binary_opening, label

    points = np.asarray(positions, np.float64).reshape(-1, 3)
    nothing = Cavity(np.zeros(3), spacing, np.zeros((0, 3), np.int64), np.zeros(0))
    if len(points) == 0:
        return nothing
    lower, upper = _robust_box(points) if box is None else (np.asarray(box[0]), np.asarray(box[1]))
    cell = spacing / VOXELS_PER_SPACING
    extent = upper - lower + 6.0 * spacing
    cell = max(cell, float(np.prod(extent) / VOXEL_LIMIT) ** (1.0 / 3.0))
    origin = lower - 3.0 * spacing
    shape = np.ceil(extent / cell).astype(int) + 1
    share = tissue_share(points, volume, spacing, origin=origin, cell=cell, shape=shape)
    solid = _largest_piece(share >= OPEN_SHARE)
    enclosed = ~solid & (directions_with_tissue(solid) >= ENCLOSING_DIRECTIONS)
    # The hollows of a surface's roughness are a voxel or two deep; an opening takes them out.
    pieces, count = label(binary_opening(enclosed, np.ones((3, 3, 3), bool)))
    size = np.bincount(pieces.ravel(), minlength=count + 1) * cell**3
    kept = size >= LEAST_VOLUME * spacing**3
    kept[0] = False
    hole = kept[pieces]
    if not hole.any():
        return nothing
    reach = max(1, round(RIM * spacing / cell))
    region = binary_dilation(hole, iterations=reach)
    region &= hole | solid  # not out of the limb
    index = np.argwhere(region)
    void = (1.0 - share[region].astype(np.float64)) * cell**3
    return Cavity(origin, cell, index, void)


def tissue_share(
    points: FloatArray,
    volume: AnyArray | None,
    spacing: float,
    *,
    origin: FloatArray,
    cell: float,
    shape: AnyArray,
) -> Float32Array:
    """Share of space that tissue fills at voxels (nx, ny, nz): 1 where it is whole."""
    from scipy.ndimage import gaussian_filter

    weight = np.full(len(points), spacing**3) if volume is None else np.asarray(volume, np.float64)
    share = deposit(points, weight / cell**3, origin=origin, cell=cell, shape=shape)
    # The cloud of a trilinear deposit has a variance of a sixth of a cell squared already.
    width = np.sqrt(max((SMOOTHING * spacing / cell) ** 2 - 1.0 / 6.0, 0.0))
    smooth: Float32Array = gaussian_filter(share, width, mode="constant", truncate=3.0)
    return smooth


def deposit(
    points: FloatArray, weight: FloatArray, *, origin: FloatArray, cell: float, shape: AnyArray
) -> Float32Array:
    """Sum of `weight` (n,) at voxels (nx, ny, nz), shared linearly among the eight around."""
    shape = np.asarray(shape, int)
    place = (points - origin) / cell
    low = np.floor(place).astype(np.int64)
    inside = np.all((low >= 0) & (low < shape - 1), axis=1)
    low, offset, weight = low[inside], (place - low)[inside], weight[inside]
    total = np.zeros(int(np.prod(shape)))
    for corner in np.ndindex(2, 2, 2):
        part = np.prod(np.where(np.array(corner) == 1, offset, 1.0 - offset), axis=1)
        flat = np.ravel_multi_index(tuple((low + corner).T), tuple(shape))
        total += np.bincount(flat, part * weight, minlength=len(total))
    result: Float32Array = total.reshape(tuple(shape)).astype(np.float32)
    return result


def directions_with_tissue(solid: BoolArray) -> NDArray[np.uint8]:
    """In how many of the 26 directions to neighbours a ray from each voxel meets `solid`."""
    count = np.zeros(solid.shape, np.uint8)
    for step in np.ndindex(3, 3, 3):
        direction = (step[0] - 1, step[1] - 1, step[2] - 1)
        if any(direction):
            count += _seen_along(solid, direction)
    return count


def _seen_along(solid: BoolArray, direction: tuple[int, int, int]) -> BoolArray:
    """Whether a ray from each voxel in `direction` meets `solid`, the voxel itself not counted."""
    axis = next(a for a in range(3) if direction[a])
    others = [a for a in range(3) if a != axis]
    stack = np.moveaxis(solid, axis, 0)
    seen = np.zeros_like(stack)
    step = direction[axis]
    order = range(len(stack) - 2, -1, -1) if step > 0 else range(1, len(stack))
    here, there = zip(*(_shifted(direction[a]) for a in others), strict=True)
    for k in order:
        seen[k][here] = (stack[k + step] | seen[k + step])[there]
    return np.moveaxis(seen, 0, axis)


def _shifted(step: int) -> tuple[slice, slice]:
    """Slices of the voxels that have a neighbour at `step` (-1, 0, 1) and of those neighbours."""
    if step == 0:
        return slice(None), slice(None)
    return (slice(None, -1), slice(1, None)) if step > 0 else (slice(1, None), slice(None, -1))


def _largest_piece(solid: BoolArray) -> BoolArray:
    """The limb without what has flown off it."""
    from scipy.ndimage import label

    pieces, count = label(solid)
    if count <= 1:
        return solid
    sizes = np.bincount(pieces.ravel())
    sizes[0] = 0
    largest: BoolArray = pieces == int(np.argmax(sizes))
    return largest


def _robust_box(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two corners [m] around all but the hundredth of the points that has flown farthest."""
    lower, upper = np.quantile(points, 0.005, axis=0), np.quantile(points, 0.995, axis=0)
    margin = 0.1 * (upper - lower)
    return (
        np.maximum(points.min(axis=0), lower - margin),
        np.minimum(points.max(axis=0), upper + margin),
    )
