"""Smooth shapes from the built-in leg's tables: contours, muscles, fat, cortex and arteries.

The tables stand in the frame of the sections: x lateral, y posterior, both in [m] after reading,
and the level, 0 at the tibia's distal joint face (plafond) and 1 at its plateau. The origin runs
along the tibia's axis from the one to the other.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from vulnus.core.arrays import FloatArray
from vulnus.core.units import MILLIMETRE

ANGLES = 180
"""Points round a contour; chosen: 2 degrees, finer than a voxel at 60 mm from the middle."""


def read_table(name: str) -> list[dict[str, str]]:
    """The rows of `data/<name>.csv`."""
    text = files("vulnus.imaging").joinpath(f"data/{name}.csv").read_text("utf-8")
    return list(csv.DictReader(text.splitlines()))


def columns(rows: Sequence[dict[str, str]], names: Sequence[str]) -> FloatArray:
    """The named columns of some rows as (rows, names), as the file gives them."""
    return np.array([[float(row[name]) for name in names] for row in rows], dtype=np.float64)


@dataclass(frozen=True, slots=True)
class ContourTable:
    """Star-shaped sections of one structure between `lowest` and `highest` level."""

    lowest: float
    highest: float
    spline: PchipInterpolator

    def at(self, level: float) -> tuple[FloatArray, FloatArray]:
        """Centre (2,) and radius (ANGLES,) [m] of the section; the ends are held."""
        row = self.spline(np.clip(level, self.lowest, self.highest))
        return row[:2], np.maximum(_ring(row.size - 2) @ row[2:], 0.0)


def contour_angles() -> FloatArray:
    """The angles of a contour's points [rad], from lateral (+x) over posterior (+y)."""
    angles: FloatArray = np.arange(ANGLES, dtype=np.float64) * (2.0 * np.pi / ANGLES)
    return angles


@cache
def _ring(count: int) -> FloatArray:
    """Matrix (ANGLES, count): the periodic cubic spline through `count` values round a circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, count + 1)
    unit = np.vstack([np.eye(count), np.eye(count)[:1]])
    matrix: FloatArray = CubicSpline(angle, unit, bc_type="periodic")(contour_angles())
    return matrix


@cache
def contour_table(structure: str) -> ContourTable:
    """The sections of "tibia", "fibula" or "fascia" (the envelope of muscles and bones)."""
    rows = [row for row in read_table("leg_sections") if row["structure"] == structure]
    names = [name for name in rows[0] if name not in ("structure", "level")]
    level = columns(rows, ["level"])[:, 0]
    table = columns(rows, names) * MILLIMETRE
    return ContourTable(float(level[0]), float(level[-1]), PchipInterpolator(level, table))


@dataclass(frozen=True, slots=True)
class MuscleTable:
    """One muscle belly or tendon as an ellipse in each section: middle and shape matrix [m]."""

    name: str
    lowest: float
    highest: float
    spline: PchipInterpolator

    def at(self, level: float) -> tuple[FloatArray, FloatArray]:
        """Middle (2,) and symmetric matrix (2, 2) that makes the ellipse of the unit circle."""
        x, y, xx, xy, yy = self.spline(level)
        return np.array([x, y]), np.array([[xx, xy], [xy, yy]])


_TIP = 0.2
"""A muscle ends half a level further on, with this part of its last section [chosen: pointed]."""


@cache
def muscle_tables() -> tuple[MuscleTable, ...]:
    """All muscles, in the order of the file."""
    rows = read_table("leg_muscles")
    levels = sorted({float(row["level"]) for row in rows})
    shape = ["shape_xx_mm", "shape_xy_mm", "shape_yy_mm"]
    tables = []
    for name in dict.fromkeys(row["muscle"] for row in rows):
        own = [row for row in rows if row["muscle"] == name]
        level = columns(own, ["level"])[:, 0]
        values = columns(own, ["centre_x_mm", "centre_y_mm", *shape]) * MILLIMETRE
        for end in (0, -1):
            index = levels.index(level[end]) + (-1 if end == 0 else 1)
            if 0 <= index < len(levels):
                place = level.size if end else 0
                tip = values[end] * np.array([1.0, 1.0, _TIP, _TIP, _TIP])
                level = np.insert(level, place, 0.5 * (level[end] + levels[index]))
                values = np.insert(values, place, tip, axis=0)
        spline = PchipInterpolator(level, values)
        tables.append(MuscleTable(name, float(level[0]), float(level[-1]), spline))
    return tuple(tables)


@cache
def fat_spline() -> PchipInterpolator:
    """Fat over the fascia by level and side, as a multiple of the calf's mean."""
    rows = read_table("leg_fat")
    table = columns(rows, [name for name in rows[0] if name != "level"])
    return PchipInterpolator(columns(rows, ["level"])[:, 0], table)


def fat_ratio(level: float) -> FloatArray:
    """Fat round the section (ANGLES,), as a multiple of the calf's mean thickness."""
    sides = fat_spline()(np.clip(level, 0.0, 1.0))
    ring: FloatArray = _ring(sides.size) @ sides
    return ring


@dataclass(frozen=True, slots=True)
class CortexRatio:
    """Wall of tibia and fibula as multiples of mid-shaft, and how wide the canal is (0-1)."""

    tibia: float
    fibula: float
    canal: float


@cache
def _cortex_spline() -> PchipInterpolator:
    rows = read_table("leg_cortex")
    table = columns(rows, ["tibia", "fibula", "canal"])
    return PchipInterpolator(columns(rows, ["level"])[:, 0], table)


def cortex_ratio(level: float) -> CortexRatio:
    """The bones' walls and canal at a level."""
    tibia, fibula, canal = _cortex_spline()(np.clip(level, 0.0, 1.0))
    return CortexRatio(float(tibia), float(fibula), float(canal))


def artery_rows(name: str) -> FloatArray:
    """One artery's course (n, 4): level, x [m], y [m], radius over the radius at its origin."""
    rows = [row for row in read_table("leg_arteries") if row["artery"] == name]
    table = columns(rows, ["level", "x_mm", "y_mm", "radius_ratio"])
    table[:, 1:3] *= MILLIMETRE
    return table
