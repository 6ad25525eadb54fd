"""Boundaries of the material point grid: held ends, walls, ends that absorb waves.

Every boundary is one or two half spaces in which nodes are held, kept from crossing, or calmed.
Air drag is not modelled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from . import _native
from .material_model import COLUMNS

WallKind = Literal["fixed", "slip", "separating"]
KIND = {"fixed": 0, "slip": 1, "separating": 2, "absorbing": 3}

STEEPNESS = 1.5
"""Exponent of the damping's rise, plus one, for a layer of one cell; it grows with the layer, so
that damping is always concentrated in 2/3 of a cell. Chosen: wider layers send long waves back."""

MATCH = 0.95
"""Part of the wave's impedance that the layer has, for the nodes beyond the plane add to it.
Chosen: wherever the plane lies between nodes, 7-8 % of a pulse's height comes back, less than 1 %
of its energy (tests/physics/test_injury_boundaries.py)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfSpace:
    """Nodes with x·`normal` <= `height` [m]; a damped layer of `thickness` [m] before it.

    The layer matches waves of `sound_speed` [m/s], by default the slowest material's.
    """

    kind: str
    normal: Vector3
    height: float
    velocity: Vector3 = (0.0, 0.0, 0.0)
    friction: float = 0.0
    thickness: float = 0.0
    sound_speed: float | None = None


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
        return _ends(self.axis, self.lower, self.upper)


@dataclass(frozen=True, slots=True, kw_only=True)
class AbsorbingEnds:
    """Ends [m] of the body at which waves leave as if it went on.

    The nodes in the last `thickness` [m] before `lower` and `upper`, and all beyond, are damped so
    that together they resist like the material that is missing, rho c v (Lysmer & Kuhlemeyer
    1969). Waves of `sound_speed` [m/s] that arrive head-on are taken up; default: the speed of the
    slowest material in the table. Nothing is held: under a lasting load the end creeps.
    """

    axis: Vector3
    lower: float
    upper: float
    thickness: float
    sound_speed: float | None = None

    def half_spaces(self) -> tuple[HalfSpace, ...]:
        """Both ends with their layer."""
        for name, value in (("thickness", self.thickness), ("sound_speed", self.sound_speed)):
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ScenarioError(
                    "absorbing ends", f"{name} is {value:g}, must be > 0", "Give some cells."
                )
        lower, upper = _ends(self.axis, self.lower, self.upper)
        return self._with_layer(lower), self._with_layer(upper)

    def _with_layer(self, end: HalfSpace) -> HalfSpace:
        return replace(
            end, kind="absorbing", thickness=self.thickness, sound_speed=self.sound_speed
        )


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


def add_boundaries(
    solver: _native.Solver32,
    boundaries: Sequence[Boundary],
    *,
    origin: FloatArray,
    grid_spacing: float,
    materials: FloatArray,
) -> None:
    """Give the native solver these boundaries and no others; ends match waves in `materials`."""
    solver.clear_boundaries()
    slowest = _slowest_sound(materials)
    for half in (half for boundary in boundaries for half in boundary.half_spaces()):
        if not np.all(np.isfinite((*half.normal, half.height, *half.velocity, half.friction))):
            raise ScenarioError("boundary", "holds a value that is not finite", "Check it.")
        layer = max(half.thickness, grid_spacing)
        exponent = STEEPNESS * layer / grid_spacing - 1.0
        damped = half.thickness > 0.0
        speed = half.sound_speed or slowest  # the integral of the rate over the layer
        solver.add_boundary(
            kind=KIND[half.kind],
            normal=half.normal,
            height=half.height - float(np.dot(half.normal, origin)),
            velocity=half.velocity,
            friction=half.friction,
            thickness=layer if damped else 0.0,
            rate=(exponent + 1.0) * MATCH * speed / layer if damped else 0.0,
            exponent=exponent,
        )


def _slowest_sound(materials: FloatArray) -> float:
    """Speed [m/s] of longitudinal waves in the slowest material of a table."""
    names = ("density", "bulk_modulus", "shear_modulus", "network_modulus")
    density, bulk, shear, network = (materials[:, COLUMNS.index(name)] for name in names)
    return float(np.sqrt(np.min((bulk + 4.0 / 3.0 * (shear + network)) / density)))


def _ends(axis: Vector3, lower: float, upper: float) -> tuple[HalfSpace, HalfSpace]:
    if not lower < upper:
        raise ScenarioError(
            "ends", f"lower {lower:g} m is not below upper {upper:g} m", "Swap or move them."
        )
    x, y, z = _unit(axis)
    return (
        HalfSpace(kind="fixed", normal=(x, y, z), height=lower),
        HalfSpace(kind="fixed", normal=(-x, -y, -z), height=-upper),
    )


def _unit(direction: Vector3) -> Vector3:
    length = math.hypot(*direction)
    if not (math.isfinite(length) and length > 0.0):
        raise ScenarioError("direction", f"{direction} has no length", "Give (x, y, z).")
    x, y, z = (float(v) / length for v in direction)
    return x, y, z
