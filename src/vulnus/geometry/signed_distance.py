"""Signed distance of a voxel mask on its own grid."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import BoolArray, Float32Array, FloatArray


def mask_signed_distance(
    mask: BoolArray, spacing: FloatArray, *, smoothing: float = 0.0
) -> Float32Array:
    """Signed distance [m] (nx, ny, nz), negative inside, zero half way between in and out.

    `spacing` (3,) [m] of the voxels. `smoothing` [m]: standard deviation of a Gaussian on the
    result. A mask that is all inside or all outside gives minus or plus the grid's diagonal.
    """
    import edt

    steps = tuple(float(s) for s in spacing)
    inside = np.ascontiguousarray(mask, dtype=bool)
    if inside.all() or not inside.any():
        diagonal = float(np.linalg.norm(np.multiply(inside.shape, steps)))
        return np.full(inside.shape, -diagonal if inside.all() else diagonal, dtype=np.float32)
    # Distances run to the centre of the nearest voxel of the other kind; the surface lies half a
    # voxel before it. Beside the surface, where a distance is one voxel along an axis, half of it
    # is exact for every spacing; farther off the smallest spacing stands for the normal's.
    distance: Float32Array = edt.edt(inside, anisotropy=steps, black_border=False, parallel=0)
    distance -= edt.edt(~inside, anisotropy=steps, black_border=False, parallel=0)
    half = np.float32(0.5 * min(steps))
    distance = np.where(distance > 0.0, half - distance, -distance - half)
    if smoothing > 0.0:
        from scipy.ndimage import gaussian_filter

        sigma = [smoothing / step for step in steps]
        distance = gaussian_filter(distance, sigma, mode="nearest", truncate=3.0)
    return distance
