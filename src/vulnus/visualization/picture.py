"""From linear light to picture files: tone curve, background, panels, atomic PNG files."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import FloatArray, Vector3
from ..core.errors import StorageError

Picture = NDArray[np.uint8]
"""An 8-bit sRGB picture (height, width, 3)."""

_SHOULDER = 0.78  # chosen: linear below, smooth roll-off of highlights above


def write_whole(path: Path, write: Callable[[Path], object]) -> Path:
    """Let `write` fill a neighbouring temporary file, then rename it to `path` in one step."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        write(partial)
        os.replace(partial, path)
    except OSError as error:
        advice = "Free some space or choose another directory"
        raise StorageError(str(path), f"cannot be written ({error.strerror})", advice) from error
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)
    return path


def write_png(path: Path, picture: Picture) -> Path:
    """Write an 8-bit picture (height, width, 3) as PNG, whole or not at all."""
    from PIL import Image

    return write_whole(path, lambda partial: Image.fromarray(picture).save(partial, format="PNG"))


def to_srgb(linear: FloatArray) -> Picture:
    """Display values 0-255 of linear light (…, 3), highlights rolled off towards white."""
    light = np.maximum(np.nan_to_num(linear), 0.0)
    over = np.maximum(light - _SHOULDER, 0.0)
    span = 1.0 - _SHOULDER
    light = np.minimum(light, _SHOULDER) + span * (1.0 - np.exp(-over / span))
    # IEC 61966-2-1 transfer function.
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.asarray(np.clip(np.rint(255.0 * encoded), 0, 255), dtype=np.uint8)


def backdrop(width: int, height: int, colour: Vector3) -> FloatArray:
    """A studio backdrop in linear light (height, width, 3): `colour`, falling off to the rims."""
    y, x = np.meshgrid(np.linspace(-1, 1, height), np.linspace(-1, 1, width), indexing="ij")
    distance = np.sqrt((0.75 * x) ** 2 + (0.85 * (y + 0.15)) ** 2)
    level = 1.0 - 0.42 * np.clip(distance, 0.0, 1.5) ** 1.6 / 1.5**1.6 * 1.5
    return np.asarray(level[..., None] * np.asarray(colour), dtype=np.float64)


def side_by_side(panels: Sequence[FloatArray], gap: int = 2) -> FloatArray:
    """Panels of equal height next to each other in linear light, a white `gap` [px] between."""
    height = panels[0].shape[0]
    rule = np.ones((height, gap, 3))
    parts: list[FloatArray] = []
    for index, panel in enumerate(panels):
        parts += [panel] if index == 0 else [rule, panel]
    return np.concatenate(parts, axis=1)
