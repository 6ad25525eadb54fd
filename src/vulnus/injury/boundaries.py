"""Boundaries of the material point grid: held ends, walls, ends that absorb waves.

Every boundary is one or two half spaces in which nodes are held, kept from crossing, or calmed.
Air drag is not modelled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from . import _native

WallKind = Literal["fixed", "slip", "separating"]
KIND = {"fixed": 0, "slip": 1, "separating": 2, "absorbing": 3}

ABSORPTION = 14.0
"""ln of the amplitude lost on the way through a sponge and back, times 3: the rate r (d/L)² takes
exp(-r L / 3c) from a wave of speed c that crosses the length L twice; chosen: 1 %."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfSpace:
    """Nodes with x·`normal` <= `height` [m]; a sponge of `thickness` [m] before it."""

    kind: str
    normal: Vector3
    height: float
    velocity: Vector3 = (0.0, 0.0, 0.0)
    friction: float = 0.0
    thickness: float = 0.0


class Boundary(Protocol):
    """Anything that consists of half spaces."""

    def half_spaces(self) -> tuple[HalfSpace, ...]:
        """Half spaces in which it acts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldEnds:
    """Nodes whose coordinate along the unit vector `axis` is outside [lower, upper] [m] stand."""

    axis: Vector3
    lower: float
    upper: float

    def half_spaces(self) -> tuple[HalfSpace, ...]:
        """Both ends."""
        return _ends(self.axis, self.lower, self.upper, kind="fixed", thickness=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class AbsorbingEnds:
    """Held ends with a sponge of `thickness` [m] before each, in which waves die.

    Node velocities are damped with a rate that grows with the square of the depth; about ten
    cells absorb waves as short as the sponge is thick.
    """

    axis: Vector3
    lower: float
    upper: float
    thickness: float

    def half_spaces(self) -> tuple[HalfSpace, ...]:
        """Both ends with their sponge."""
        if not (math.isfinite(self.thickness) and self.thickness > 0.0):
            raise ScenarioError(
                "absorbing ends",
                f"thickness is {self.thickness:g} m, must be > 0",
                "Give about ten cells.",
            )
        return _ends(self.axis, self.lower, self.upper, kind="absorbing", thickness=self.thickness)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wall:
    """A plane through `point` [m] that acts on the side away from `normal`, and its `velocity`.

    "fixed" nodes have the wall's velocity, "slip" nodes keep what is tangential, "separating" ones
    may leave, and slide with Coulomb `friction` while they press. The plane moves along. A "slip"
    wall at rest that lies on a layer of nodes across a coordinate axis is a plane of symmetry: the
    tissue moves as half of the whole body (mirror.hpp); elsewhere the layer of cells beside it is
    too stiff.
    """

    point: Vector3
    normal: Vector3
    kind: WallKind = "fixed"
    friction: float = 0.0
    velocity: Vector3 = (0.0, 0.0, 0.0)

    def half_spaces(self) -> tuple[HalfSpace, ...]:
        """The side behind the plane."""
        if self.kind not in ("fixed", "slip", "separating"):
            raise ScenarioError(
                "wall kind", f"is {self.kind!r}", 'Use "fixed", "slip" or "separating".'
            )
        if not self.friction >= 0.0:
            raise ScenarioError("wall friction", f"is {self.friction:g}, must be >= 0", "Use 0.")
        normal = _unit(self.normal)
        return (
            HalfSpace(
                kind=self.kind,
                normal=normal,
                height=float(np.dot(normal, self.point)),
                velocity=self.velocity,
                friction=self.friction,
            ),
        )


def add_boundary(
    solver: _native.Solver32, boundary: Boundary, *, origin: FloatArray, sound_speed: float
) -> None:
    """Give a boundary to the native solver; the sponge absorbs waves of `sound_speed` [m/s]."""
    for half in boundary.half_spaces():
        if not np.all(np.isfinite((*half.normal, half.height, *half.velocity, half.friction))):
            raise ScenarioError("boundary", "holds a value that is not finite", "Check it.")
        sponge = half.thickness > 0.0
        solver.add_boundary(
            kind=KIND[half.kind],
            normal=half.normal,
            height=half.height - float(np.dot(half.normal, origin)),
            velocity=half.velocity,
            friction=half.friction,
            thickness=half.thickness,
            rate=ABSORPTION * sound_speed / half.thickness if sponge else 0.0,
        )


def _ends(
    axis: Vector3, lower: float, upper: float, *, kind: str, thickness: float
) -> tuple[HalfSpace, ...]:
    if not lower < upper:
        raise ScenarioError(
            "ends", f"lower {lower:g} m is not below upper {upper:g} m", "Swap or move them."
        )
    x, y, z = _unit(axis)
    return (
        HalfSpace(kind=kind, normal=(x, y, z), height=lower, thickness=thickness),
        HalfSpace(kind=kind, normal=(-x, -y, -z), height=-upper, thickness=thickness),
    )


def _unit(direction: Vector3) -> Vector3:
    length = math.hypot(*direction)
    if not (math.isfinite(length) and length > 0.0):
        raise ScenarioError("direction", f"{direction} has no length", "Give (x, y, z).")
    x, y, z = (float(v) / length for v in direction)
    return x, y, z
