"""Words and scale bars on pictures, set in the typeface that comes with matplotlib."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..core.arrays import FloatArray
from ..core.units import MILLIMETRE
from .camera import Camera

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

_INK = 0.025  # linear light of the letters: nearly black
_MARGIN = 0.022  # of the picture's height
_LETTER = 0.032  # of the picture's height; chosen: read at half the size

Corner = Literal["top_left", "top_right", "bottom_left", "bottom_right"]


@functools.cache
def typeface(size: int) -> FreeTypeFont:
    """DejaVu Sans at `size` [px]."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", size)


def write_text(
    picture: FloatArray, text: str, corner: Corner = "top_left", *, letter: float = _LETTER
) -> FloatArray:
    """The picture (h, w, 3) in linear light with `text` in a corner.

    `letter` is the height of the letters as a part of the picture's.
    """
    from PIL import Image, ImageDraw

    height, width = picture.shape[:2]
    font = typeface(max(9, round(letter * height)))
    mask = Image.new("L", (width, height), 0)
    draw = ImageDraw.Draw(mask)
    left, top, right, bottom = draw.multiline_textbbox((0, 0), text, font=font)
    margin = max(4, round(_MARGIN * height))
    x = margin - left if corner.endswith("left") else width - margin - right
    y = margin - top if corner.startswith("top") else height - margin - bottom
    draw.multiline_text((x, y), text, font=font, fill=255)
    return _ink(picture, np.asarray(mask, dtype=np.float64) / 255.0)


def scale_bar(
    picture: FloatArray, camera: Camera, *, length: float, letter: float = _LETTER
) -> FloatArray:
    """The picture with a bar as long as `length` [m] is at the camera's target, and its size."""
    right = camera.axes[0]
    ends = np.asarray(camera.target) + np.array([[0.0], [length]]) * right
    pixels = float(np.abs(np.diff(camera.project(ends)[:, 0]))[0])
    height, width = picture.shape[:2]
    margin = max(4, round(_MARGIN * height))
    text = f"{length / MILLIMETRE:g} mm"
    written = write_text(picture, text, "bottom_right", letter=letter)
    mask = np.zeros((height, width))
    lift = margin + round(1.4 * letter * height)
    thickness = max(2, round(0.006 * height))
    first = max(0, round(width - margin - pixels))
    mask[height - lift - thickness : height - lift, first : width - margin] = 1.0
    return _ink(written, mask)


def _ink(picture: FloatArray, mask: FloatArray) -> FloatArray:
    weight = mask[..., None]
    return np.asarray((1.0 - weight) * picture + weight * _INK)
