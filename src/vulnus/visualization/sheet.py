"""Pictures side by side on one white sheet, with titles above the columns and a legend below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..core.arrays import Vector3
from .caption import typeface
from .picture import Picture, to_srgb, write_whole

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

_GAP = 6  # px between two panels
_MARGIN = 14  # px around the sheet
_INK = (34, 38, 43)
_LARGEST_FILE = 300_000  # byte of a picture for a page; chosen: it opens at once
_QUALITIES = (92, 88, 84, 80, 75, 70, 60, 50)


@dataclass(frozen=True, slots=True)
class LegendEntry:
    """A dot of linear `colour` and what it stands for."""

    colour: Vector3
    text: str


def compose(
    rows: Sequence[Sequence[Picture]],
    *,
    titles: Sequence[str],
    legend: Sequence[LegendEntry] = (),
    footer: str = "",
) -> Picture:
    """One picture of a grid of panels; panels of a column are equally wide, of a row equally high.

    `titles` stand above the columns; `legend` and `footer` below, on one line each.
    """
    from PIL import Image, ImageDraw

    widths = [panel.shape[1] for panel in rows[0]]
    heights = [row[0].shape[0] for row in rows]
    letter = max(12, round(0.0145 * sum(widths)))
    head = round(2.0 * letter)
    foot = round(1.9 * letter) * (bool(legend) + bool(footer))
    width = 2 * _MARGIN + sum(widths) + _GAP * (len(widths) - 1)
    height = 2 * _MARGIN + head + sum(heights) + _GAP * (len(heights) - 1) + foot
    sheet = Image.new("RGB", (width, height), (255, 255, 255))
    draw = ImageDraw.Draw(sheet)
    font = typeface(letter)
    left = _MARGIN
    for index, title in enumerate(titles):
        middle = (left + widths[index] // 2, _MARGIN + round(0.8 * letter))
        draw.text(middle, title, font=font, fill=_INK, anchor="mm")
        left += widths[index] + _GAP
    top = _MARGIN + head
    for row in rows:
        left = _MARGIN
        for panel in row:
            sheet.paste(Image.fromarray(panel), (left, top))
            left += panel.shape[1] + _GAP
        top += row[0].shape[0] + _GAP
    line = top + round(0.7 * letter)
    if legend:
        _draw_legend(draw, legend, letter, width, line)
        line += round(1.9 * letter)
    if footer:
        draw.text((width // 2, line), footer, font=font, fill=_INK, anchor="mm")
    return np.asarray(sheet, dtype=np.uint8)


def write_jpeg(path: Path, picture: Picture) -> Path:
    """Write a picture as JPEG for a page, as good as 300 kB allow, whole or not at all."""
    from PIL import Image

    image = Image.fromarray(picture)

    def write(partial: Path) -> None:
        for quality in _QUALITIES:
            image.save(partial, format="JPEG", quality=quality, optimize=True, progressive=True)
            if partial.stat().st_size <= _LARGEST_FILE:
                return

    return write_whole(path, write)


def _draw_legend(
    draw: ImageDraw, legend: Sequence[LegendEntry], letter: int, width: int, line: int
) -> None:
    """Dots and words on one line, in the middle of the sheet."""
    font = typeface(letter)
    dot, space = round(0.9 * letter), round(1.6 * letter)
    lengths = [dot + round(0.4 * letter) + round(font.getlength(one.text)) for one in legend]
    left = (width - sum(lengths) - space * (len(legend) - 1)) // 2
    for one, length in zip(legend, lengths, strict=True):
        red, green, blue = (int(v) for v in to_srgb(np.array([one.colour]))[0])
        box = (left, line - dot // 2, left + dot, line + dot // 2)
        draw.ellipse(box, fill=(red, green, blue), outline=(120, 120, 120))
        draw.text(
            (left + dot + round(0.4 * letter), line), one.text, font=font, fill=_INK, anchor="lm"
        )
        left += length + space
