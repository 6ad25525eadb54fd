"""Open Image Denoise on the processor: removes path-tracing noise, guided by albedo and normal."""

from __future__ import annotations

import importlib.util

import numpy as np

from ..core.arrays import Float32Array


def can_denoise() -> bool:
    """Whether the package pyoidn is installed."""
    return importlib.util.find_spec("pyoidn") is not None


def denoise(colour: Float32Array, albedo: Float32Array, normal: Float32Array) -> Float32Array:
    """The picture (height, width, 3) in linear light without its sampling noise.

    The picture comes back as it is where the library is missing or refuses to work: noise is
    better than no picture.
    """
    if not can_denoise():
        return colour
    try:
        import pyoidn

        result = pyoidn.denoise(
            np.ascontiguousarray(colour, dtype=np.float32),
            np.ascontiguousarray(np.clip(albedo, 0.0, 1.0), dtype=np.float32),
            np.ascontiguousarray(np.clip(normal, -1.0, 1.0), dtype=np.float32),
            hdr=True,
        )
    except (ImportError, OSError, RuntimeError):
        return colour
    return np.asarray(result, dtype=np.float32)
