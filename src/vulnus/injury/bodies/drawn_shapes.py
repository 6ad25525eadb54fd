"""Shapes with a formula: cylinder, bullet ogive, box, blade."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..checked_values import vector
from .shapes import SampledShape, require_length
from .signed_distance import SignedDistance, sample

PROFILE_POINTS = 33
"""Points on the curve of an ogive; chosen: its sagitta is then below 1e-3 of the nose's length."""


BEVEL = 4.0
"""Width of a blade's bevel in thicknesses; chosen: 7 degrees a side, a ground knife."""


@dataclass(frozen=True, eq=False)
class Cylinder(SampledShape):
    """A right cylinder of `radius` and `length` [m] along x: a fragment-simulating projectile."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive."""
        require_length("cylinder", self.radius, self.length)

    def drawn_box(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the box around it, the middle at the origin."""
        half = np.array([0.5 * self.length, self.radius, self.radius])
        return -half, half

    def drawn(self) -> SignedDistance:
        """Distance to the barrel and the two faces."""

        def function(x: AnyArray, y: AnyArray, z: AnyArray) -> AnyArray:
            return joined(np.abs(x) - 0.5 * self.length, np.hypot(y, z) - self.radius)

        return sample(function, *self.drawn_box(), min(2.0 * self.radius, self.length))


@dataclass(frozen=True, eq=False)
class Ogive(SampledShape):
    """A bullet of `radius` and `length` [m] whose nose has `nose_length` [m], its tip at +x.

    The nose is a tangent ogive, or half an ellipse where it is shorter than the radius.
    """

    radius: float
    length: float
    nose_length: float

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive, and a nose longer than the bullet."""
        require_length("ogive", self.radius, self.length, self.nose_length)
        if self.nose_length > self.length:
            raise ScenarioError(
                "ogive nose_length",
                f"is {1e3 * self.nose_length:g} mm, must be <= the length "
                f"({1e3 * self.length:g} mm)",
                "Shorten the nose.",
            )

    def profile(self) -> FloatArray:
        """Half section (n, 2): x [m] from the base, and radius [m], from base to tip."""
        r, n = self.radius, self.nose_length
        s = n * (1.0 - np.linspace(0.0, 1.0, PROFILE_POINTS) ** 2)  # from the shoulder, tip dense
        s = s[::-1]
        if n >= r:
            rho = (r**2 + n**2) / (2.0 * r)
            height = np.sqrt(rho**2 - s**2) + r - rho
        else:
            height = r * np.sqrt(np.maximum(1.0 - (s / n) ** 2, 0.0))
        height[-1] = 0.0
        nose = np.column_stack([self.length - n + s, height])
        base = [[0.0, 0.0], [0.0, r]] if n < self.length else [[0.0, 0.0]]
        return np.concatenate([base, nose])

    def drawn_box(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the box around it, the base's centre at the origin."""
        r = self.radius
        return np.array([0.0, -r, -r]), np.array([self.length, r, r])

    def drawn(self) -> SignedDistance:
        """Distance to the solid of revolution of its profile."""
        profile = self.profile()

        def function(x: AnyArray, y: AnyArray, z: AnyArray) -> AnyArray:
            return revolved(profile, x, np.hypot(y, z))

        return sample(function, *self.drawn_box(), min(2.0 * self.radius, self.length))


@dataclass(frozen=True, eq=False)
class Box(SampledShape):
    """A box with edges `size` (x, y, z) [m]."""

    size: Vector3

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive."""
        require_length("box", *vector("box size", self.size))

    def drawn_box(self) -> tuple[FloatArray, FloatArray]:
        """Its corners, the middle at the origin."""
        half = 0.5 * np.asarray(self.size, np.float64)
        return -half, half

    def drawn(self) -> SignedDistance:
        """Distance to the six faces."""
        a, b, c = (0.5 * edge for edge in self.size)

        def function(x: AnyArray, y: AnyArray, z: AnyArray) -> AnyArray:
            return joined(np.abs(x) - a, np.abs(y) - b, np.abs(z) - c)

        return sample(function, *self.drawn_box(), min(self.size))


@dataclass(frozen=True, eq=False)
class BladeShape(SampledShape):
    """A blade with two edges: `length` along x to its tip, `thickness` along y, `width` along z.

    All in [m]. Over the last `tip_length` it narrows to a point in the middle of its width. Its
    faces meet at the edges under a bevel `BEVEL` thicknesses wide, at most half the width.
    """

    length: float
    width: float
    thickness: float
    tip_length: float

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive, and a tip longer than the blade."""
        require_length("blade", self.length, self.width, self.thickness, self.tip_length)
        if self.tip_length > self.length:
            raise ScenarioError(
                "blade tip_length",
                f"is {1e3 * self.tip_length:g} mm, must be <= the length "
                f"({1e3 * self.length:g} mm)",
                "Shorten the tip.",
            )

    @property
    def bevel(self) -> float:
        """Width [m] over which the blade thins to its edge."""
        return min(BEVEL * self.thickness, 0.5 * self.width)

    def drawn_box(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the box around it, the middle of the base at the origin."""
        t, w = 0.5 * self.thickness, 0.5 * self.width
        return np.array([0.0, -t, -w]), np.array([self.length, t, w])

    def drawn(self) -> SignedDistance:
        """Distance to the plate, its bevelled edges and its base."""
        w, shoulder = 0.5 * self.width, self.length - self.tip_length
        behind = -self.length  # the base has no edge
        outline = np.array(
            [[behind, -w], [shoulder, -w], [self.length, 0], [shoulder, w], [behind, w]]
        )
        half = 0.5 * self.thickness
        slope = math.atan2(half, self.bevel)

        def function(x: AnyArray, y: AnyArray, z: AnyArray) -> AnyArray:
            flat = polygon_distance(outline, *np.broadcast_arrays(x, z))
            away = np.abs(y)
            face = np.maximum(away - half, math.cos(slope) * away + math.sin(slope) * flat)
            beyond_edge = np.where(flat > 0.0, np.hypot(flat, away), face)
            return joined(np.maximum(face, beyond_edge), -x)

        return sample(function, *self.drawn_box(), min(self.thickness, self.width))


def joined(*parts: AnyArray) -> AnyArray:
    """Distance [m] to a product of slabs from the distances [m] to each of them."""
    outside = np.sqrt(sum(np.maximum(p, 0.0) ** 2 for p in parts))
    deepest = parts[0]
    for part in parts[1:]:
        deepest = np.maximum(deepest, part)
    result: AnyArray = outside + np.minimum(deepest, 0.0)
    return result


def revolved(profile: FloatArray, x: AnyArray, r: AnyArray) -> AnyArray:
    """Distance [m] at x and off-axis distance r [m] of the solid of revolution of a `profile`."""
    apart = _distance_to_line(profile, x, r)
    height = np.interp(x, profile[1:, 0], profile[1:, 1])
    inside = (x > profile[0, 0]) & (x < profile[-1, 0]) & (r < height)
    result: AnyArray = np.where(inside, -apart, apart)
    return result


def polygon_distance(corners: FloatArray, x: AnyArray, y: AnyArray) -> AnyArray:
    """Distance [m] at x, y [m] to the polygon with `corners` (n, 2) [m], negative inside."""
    closed = np.concatenate([corners, corners[:1]])
    inside = np.zeros(x.shape, bool)
    for (ax, ay), (bx, by) in pairwise(closed):
        if ay == by:
            continue
        crossing = ax + (y - ay) / (by - ay) * (bx - ax)
        inside ^= ((ay > y) != (by > y)) & (x < crossing)
    apart = _distance_to_line(closed, x, y)
    result: AnyArray = np.where(inside, -apart, apart)
    return result


def _distance_to_line(line: FloatArray, x: AnyArray, y: AnyArray) -> AnyArray:
    """Distance [m] at x, y [m] to the segments between successive points of `line` (n, 2) [m]."""
    squared = np.full(np.broadcast_shapes(x.shape, y.shape), np.inf)
    for (ax, ay), (bx, by) in pairwise(line):
        ex, ey = bx - ax, by - ay
        part = np.clip(((x - ax) * ex + (y - ay) * ey) / (ex**2 + ey**2), 0.0, 1.0)
        np.minimum(squared, (x - ax - part * ex) ** 2 + (y - ay - part * ey) ** 2, out=squared)
    result: AnyArray = np.sqrt(squared)
    return result
