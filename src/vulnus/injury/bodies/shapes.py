"""Shapes of rigid bodies: a sphere, or a signed distance sampled in the body's frame.

The origin of a body's frame is the centre of mass; the long axis is +x with the nose at +x.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError

from ..checked_values import length, not_negative, not_too_fast
from .signed_distance import SignedDistance, SolidProperties, solid_properties


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
        """The sampled distance in the body's frame; None for a sphere."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball of `radius` [m] at time 0 that grows with `expansion_speed` [m/s]."""

    radius: float
    expansion_speed: float = 0.0
    distance: None = field(default=None, init=False)

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive, and one that shrinks."""
        require_length("sphere radius", self.radius)
        growing = not_negative("sphere expansion_speed", self.expansion_speed)
        not_too_fast("sphere expansion", growing)

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


class SampledShape(ABC):
    """A shape whose distance is sampled once; volume and inertia are sums over the samples."""

    @abstractmethod
    def drawn(self) -> SignedDistance:
        """The sampled distance in the frame in which the shape is drawn."""

    @abstractmethod
    def drawn_box(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner (3,) [m] of the box around it, in the frame of drawing."""

    @cached_property
    def _sampled(self) -> tuple[SignedDistance, SolidProperties]:
        drawn = self.drawn()
        found = solid_properties(drawn)
        if not (np.isfinite(found.inertia).all() and np.linalg.det(found.inertia) > 0.0):
            lower, upper = self.drawn_box()
            raise ScenarioError(
                type(self).__name__,
                f"of the edges {(upper - lower).tolist()} m is too slender to be sampled",
                "Make it thicker or shorter.",
            )
        return drawn, found

    @property
    def centre_of_mass(self) -> FloatArray:
        """Centre of mass (3,) [m] in the frame in which the shape is drawn."""
        return self._sampled[1].centre

    @property
    def volume(self) -> float:
        """Volume [m³]."""
        return self._sampled[1].volume

    @property
    def unit_inertia(self) -> FloatArray:
        """Inertia tensor (3, 3) [m⁵] about the centre of mass, for unit density."""
        return self._sampled[1].inertia

    @property
    def lower(self) -> FloatArray:
        """Lower corner (3,) [m] of the box around the shape, from the centre of mass."""
        return self.drawn_box()[0] - self.centre_of_mass

    @property
    def upper(self) -> FloatArray:
        """Upper corner (3,) [m] of the box around the shape, from the centre of mass."""
        return self.drawn_box()[1] - self.centre_of_mass

    @cached_property
    def inner_radius(self) -> float:
        """Radius [m] of the largest ball inside."""
        return -float(self._sampled[0].values.min())

    @cached_property
    def distance(self) -> SignedDistance:
        """The sampled distance in the body's frame."""
        return self._sampled[0].moved(self.centre_of_mass)


def require_length(name: str, *values: float) -> None:
    """Refuse sizes [m] that are not positive and finite, or of no use as a length."""
    for value in values:
        length(name, value)
