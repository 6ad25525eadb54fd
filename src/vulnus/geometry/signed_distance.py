"""Signed distance of a voxel mask on its own grid, near the mask's surface."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import BoolArray, Float32Array, FloatArray

VOXELS_PER_PASS = 12_000_000
"""Voxels of one slab; chosen: a slab takes about 0.4 s, so that Ctrl-C is answered."""


def mask_signed_distance(
    mask: BoolArray, spacing: FloatArray, *, reach: float, smoothing: float = 0.0
) -> Float32Array:
    """Signed distance [m] (nx, ny, nz), negative inside, zero half way between in and out.

    `spacing` (3,) [m] of the voxels. Distances beyond `reach` [m] are given as `reach`.
    `smoothing` [m]: standard deviation of a Gaussian on the result. The grid is worked on in slabs
    along its longest axis that overlap by `reach`, so memory and waiting stay small.
    """
    steps = np.asarray(spacing, dtype=np.float64)
    axis = int(np.argmax(mask.shape))
    overlap = int(np.ceil((reach + 3.0 * smoothing) / steps[axis])) + 2
    area = mask.size // mask.shape[axis]
    thickness = max(VOXELS_PER_PASS // max(area, 1) - 2 * overlap, overlap)
    distance = np.empty(mask.shape, dtype=np.float32)
    for start in range(0, mask.shape[axis], thickness):
        stop = min(start + thickness, mask.shape[axis])
        first = max(start - overlap, 0)
        slab = _along(axis, first, min(stop + overlap, mask.shape[axis]))
        values = _slab_distance(np.ascontiguousarray(mask[slab]), steps, reach, smoothing)
        distance[_along(axis, start, stop)] = values[_along(axis, start - first, stop - first)]
    return distance


def _along(axis: int, start: int, stop: int) -> tuple[slice, ...]:
    return tuple(slice(start, stop) if a == axis else slice(None) for a in range(3))


def _slab_distance(
    inside: BoolArray, steps: FloatArray, reach: float, smoothing: float
) -> Float32Array:
    import edt

    if inside.all() or not inside.any():
        return np.full(inside.shape, -reach if inside.any() else reach, dtype=np.float32)
    # Distances run to the centre of the nearest voxel of the other kind; the surface lies half a
    # voxel before it. Beside the surface, where a distance is one voxel along an axis, half of it
    # is right for every spacing; farther off the smallest spacing stands for the normal's.
    kind = inside.view(np.uint8) + np.uint8(1)
    distance: Float32Array = edt.edt(
        kind, anisotropy=tuple(steps.tolist()), black_border=False, parallel=0
    )
    distance -= np.float32(0.5 * steps.min())
    np.minimum(distance, np.float32(reach), out=distance)
    np.negative(distance, out=distance, where=inside)
    if smoothing > 0.0:
        from scipy.ndimage import gaussian_filter

        distance = gaussian_filter(distance, smoothing / steps, mode="nearest", truncate=3.0)
    return distance


def without_stairs(distance: Float32Array, strength: float) -> Float32Array:
    """The distance [m] on a grid of half the resolution, without the stairs of the voxels.

    Its voxels are twice as large and its first one is centred half an old voxel further on along
    each axis. A Gaussian G of `strength` old voxels along each axis acts twice, as 2G - G², which
    leaves the curvature of wide surfaces alone.
    """
    from scipy.ndimage import gaussian_filter

    odd = [(0, n % 2) for n in distance.shape]
    even = np.pad(distance, odd, mode="edge") if any(n for _, n in odd) else distance
    nx, ny, nz = (n // 2 for n in even.shape)
    coarse = even.reshape(nx, 2, ny, 2, nz, 2).mean(axis=(1, 3, 5), dtype=np.float32)
    smooth: Float32Array = gaussian_filter(coarse, 0.5 * strength, mode="nearest", truncate=3.0)
    smooth += gaussian_filter(coarse - smooth, 0.5 * strength, mode="nearest", truncate=3.0)
    return smooth
