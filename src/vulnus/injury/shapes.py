"""Shapes of rigid bodies: a sphere, or a signed distance sampled in the body's frame.

The origin of a body's frame is the centre of mass; the long axis is +x with the nose at +x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from vulnus.core.arrays import Float32Array, FloatArray
from vulnus.core.errors import ScenarioError


@dataclass(frozen=True, slots=True, eq=False)
class SignedDistance:
    """Signed distance [m], negative inside, at `lower` [m] + `spacing` [m] · (i, j, k)."""

    values: Float32Array
    lower: FloatArray
    spacing: float


class Shape(Protocol):
    """What a rigid body needs to know of its shape."""

    @property
    def volume(self) -> float:
        """Volume [m³]."""

    @property
    def unit_inertia(self) -> FloatArray:
        """Inertia tensor (3, 3) [m⁵] about the centre of mass, for unit density."""

    @property
    def lower(self) -> FloatArray:
        """Lower corner (3,) [m] of the box around the shape, from the centre of mass."""

    @property
    def upper(self) -> FloatArray:
        """Upper corner (3,) [m] of the box around the shape, from the centre of mass."""

    @property
    def inner_radius(self) -> float:
        """Radius [m] of the largest ball inside."""

    @property
    def distance(self) -> SignedDistance | None:
        """The sampled distance; None for a sphere."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball of `radius` [m] at time 0 that grows with `expansion_speed` [m/s]."""

    radius: float
    expansion_speed: float = 0.0
    distance: None = field(default=None, init=False)

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive."""
        require_positive("sphere radius", self.radius)

    @property
    def volume(self) -> float:
        """Volume [m³] at time 0."""
        return 4.0 / 3.0 * math.pi * self.radius**3

    @property
    def unit_inertia(self) -> FloatArray:
        """Inertia tensor (3, 3) [m⁵] for unit density: 2/5 V R² on the diagonal."""
        return np.eye(3) * (0.4 * self.volume * self.radius**2)

    @property
    def lower(self) -> FloatArray:
        """Lower corner (3,) [m] of the box around it."""
        return np.full(3, -self.radius)

    @property
    def upper(self) -> FloatArray:
        """Upper corner (3,) [m] of the box around it."""
        return np.full(3, self.radius)

    @property
    def inner_radius(self) -> float:
        """Radius [m]."""
        return self.radius


def require_positive(name: str, *values: float) -> None:
    """Refuse sizes that are not positive and finite."""
    for value in values:
        if not (math.isfinite(value) and value > 0.0):
            raise ScenarioError(name, f"is {value:g} m, must be > 0", "Give a positive length.")
