"""The built-in leg at one level: contours of skin, fascia and bones in metres, scaled to girths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from vulnus.core.arrays import FloatArray

from .leg_tables import ANGLES, contour_angles, contour_table, cortex_ratio, fat_ratio
from .measurements import measurement
from .parameters import LegMeasurements

LOWEST_LEVEL = 0.0
HIGHEST_LEVEL = 0.985
GIRTH_LEVELS = (0.13, 0.72, 0.91)
"""Levels of the least ankle, greatest calf and tibial-tuberosity girths (bare of the table's own
proportions: where its sections are least, greatest, and cross the tuberosity)."""

_SHAFT_LEVELS = (0.04, 0.15, 0.84, 0.90)
"""Where the fibula's shaft begins and ends between malleolus and head."""

_END = 0.021
"""Levels by which a bone reaches past its last section (the fibula's apex: 0.966, measured)."""


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A star-shaped closed curve: `centre` (2,) and `radius` (ANGLES,) [m]."""

    centre: FloatArray
    radius: FloatArray

    @property
    def points(self) -> FloatArray:
        """The curve's points (ANGLES, 2) [m]."""
        angle = contour_angles()
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        points: FloatArray = self.centre + self.radius[:, None] * unit
        return points

    @property
    def girth(self) -> float:
        """Length of the curve [m]."""
        points = self.points
        return float(np.sum(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)))

    @property
    def area(self) -> float:
        """Enclosed area [m²]."""
        x, y = self.points.T
        return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))

    def offset(self, distance: FloatArray | float) -> Contour:
        """The curve moved outward by `distance` [m] along its normals, scalar or (ANGLES,)."""
        angle = contour_angles()
        step = 2.0 * np.pi / ANGLES
        slope = (np.roll(self.radius, -1) - np.roll(self.radius, 1)) / (2.0 * step)
        size = np.hypot(self.radius, slope)
        safe = np.maximum(size, 1e-9)
        radial = self.radius / safe
        tangential = slope / safe
        # A normal of a star-shaped curve is (r e_r - r' e_t) / |.|.
        out_radial = self.radius + distance * radial
        out_tangential = -distance * tangential
        moved = angle + np.arctan2(out_tangential, out_radial)
        new = np.interp(angle, moved, np.hypot(out_radial, out_tangential), period=2.0 * np.pi)
        return Contour(self.centre, new)

    def enclosing(self, other: Contour) -> Contour:
        """The curve widened, where it must be, to go round `other`."""
        x, y = (other.points - self.centre).T
        index = np.rint(np.arctan2(y, x) * (ANGLES / (2.0 * np.pi))).astype(np.intp) % ANGLES
        reach = np.zeros(ANGLES)
        np.maximum.at(reach, index, np.hypot(x, y))
        excess = np.maximum(reach - self.radius, 0.0)
        widest = np.maximum(np.maximum(np.roll(excess, 1), excess), np.roll(excess, -1))
        return Contour(self.centre, self.radius + widest)

    def radius_at(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distance of points to the centre, and the curve's radius in their direction [m]."""
        dx = x - self.centre[0]
        dy = y - self.centre[1]
        turn = np.arctan2(dy, dx) * (ANGLES / (2.0 * np.pi))
        low = np.floor(turn)
        part = turn - low
        index = low.astype(np.intp) % ANGLES
        ring = np.append(self.radius, self.radius[0])
        return np.hypot(dx, dy), ring[index] * (1.0 - part) + ring[index + 1] * part


@dataclass(frozen=True, slots=True, eq=False)
class LegSection:
    """All contours of the leg at one level."""

    level: float
    scale: float
    skin: Contour
    fat: Contour
    fascia: Contour
    bones: tuple[BoneSection, ...]


@dataclass(frozen=True, slots=True, eq=False)
class BoneSection:
    """One bone's periosteal, endosteal and canal contours."""

    outer: Contour
    inner: Contour
    canal: Contour


class LegShape:
    """The leg as a continuous shape; independent of any voxel size."""

    def __init__(self, leg: LegMeasurements) -> None:
        self.leg = leg
        self._bone_scale = measurement("plateau_breadth") / measurement("plateau_breadth_of_tables")
        self._shaft_scale = measurement("fibula_breadth") / measurement("fibula_breadth_of_tables")
        goals = (leg.ankle_girth, leg.calf_girth, leg.knee_girth)
        scales = [self._solve_scale(*pair) for pair in zip(GIRTH_LEVELS, goals, strict=True)]
        self._scale = PchipInterpolator(GIRTH_LEVELS, scales)

    def scale(self, level: float) -> float:
        """In-plane scale of soft tissue and places against the tables."""
        return float(self._scale(np.clip(level, GIRTH_LEVELS[0], GIRTH_LEVELS[-1])))

    def height(self, level: float) -> float:
        """Height of a level above the plafond [m]."""
        return level * self.leg.tibia_length

    def section(self, level: float) -> LegSection:
        """The contours at a level."""
        return self._section(level, self.scale(level))

    def bone(self, name: str, level: float, scale: float) -> Contour | None:
        """Outer contour of "tibia" or "fibula", or None where the bone does not reach."""
        table = contour_table(name)
        if not table.lowest <= level <= table.highest + _END:
            return None
        centre, radius = table.at(level)
        beyond = max(0.0, (level - table.highest) / _END)
        # A bone that ends inside the leg closes like half an ellipse.
        closing = np.sqrt(max(0.0, 1.0 - beyond**2)) if table.highest < HIGHEST_LEVEL else 1.0
        place = centre * max(scale, self._bone_scale)
        return Contour(place, radius * (self._bone_size(name, level) * closing))

    def _bone_size(self, name: str, level: float) -> float:
        """In-plane size of a bone against the tables; the fibula's shaft has its own."""
        shaft = np.interp(level, _SHAFT_LEVELS, (0.0, 1.0, 1.0, 0.0)) if name == "fibula" else 0.0
        return float(self._bone_scale + shaft * (self._shaft_scale - self._bone_scale))

    def _section(self, level: float, scale: float) -> LegSection:
        leg = self.leg
        bones = self._bones(level, scale)
        centre, radius = contour_table("fascia").at(level)
        fascia = Contour(centre * scale, radius * scale)
        for bone in bones:
            fascia = fascia.enclosing(bone.outer)
        fat = fascia.offset(leg.fat_thickness * fat_ratio(level))
        return LegSection(level, scale, fat.offset(leg.skin_thickness), fat, fascia, bones)

    def _bones(self, level: float, scale: float) -> tuple[BoneSection, ...]:
        ratio = cortex_ratio(level)
        walls = {
            "tibia": self.leg.cortex_thickness * ratio.tibia,
            "fibula": self.leg.fibula_cortex_thickness * ratio.fibula,
        }
        bones = []
        for name, wall in walls.items():
            outer = self.bone(name, level, scale)
            if outer is not None:
                inner = Contour(outer.centre, np.maximum(outer.offset(-wall).radius, 0.0))
                bones.append(
                    BoneSection(outer, inner, Contour(outer.centre, inner.radius * ratio.canal))
                )
        return tuple(bones)

    def _solve_scale(self, level: float, girth: float) -> float:
        scale = 1.0
        for _ in range(20):
            scale *= girth / self._section(level, scale).skin.girth
        return scale
