"""What a validation case gives back: comparisons with their tolerance, and curves to look at."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vulnus.core.arrays import AnyArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """One number of a case beside its reference.

    `value` and `reference` have the `unit`; the case agrees where `lower <= value <= upper`.
    `source` says where reference and tolerance come from. Make one with `within`, `between`,
    `at_most` or `at_least`.
    """

    name: str
    value: float
    unit: str
    reference: float | None
    lower: float
    upper: float
    tolerance: str
    source: str

    @property
    def passed(self) -> bool:
        """Whether the value is inside the tolerance; one that is not finite never is."""
        return bool(math.isfinite(self.value) and self.lower <= self.value <= self.upper)

    def __post_init__(self) -> None:
        """Plain floats, whatever kind of number a case gives."""
        for name in ("value", "reference", "lower", "upper"):
            given = getattr(self, name)
            object.__setattr__(self, name, None if given is None else float(given))

    @classmethod
    def within(
        cls,
        name: str,
        value: float,
        *,
        reference: float,
        unit: str,
        source: str,
        relative: float | None = None,
        absolute: float | None = None,
    ) -> Comparison:
        """Agreement within a `relative` part of the reference or an `absolute` distance from it."""
        if (relative is None) == (absolute is None):
            raise ValueError("give either relative or absolute")
        span = absolute if absolute is not None else (relative or 0.0) * abs(reference)
        text = f"±{100.0 * relative:g} %" if relative is not None else f"±{span:g}"
        return cls(
            name=name,
            value=value,
            unit=unit,
            reference=reference,
            lower=reference - span,
            upper=reference + span,
            tolerance=text,
            source=source,
        )

    @classmethod
    def between(
        cls,
        name: str,
        value: float,
        *,
        lower: float,
        upper: float,
        unit: str,
        source: str,
        reference: float | None = None,
    ) -> Comparison:
        """Agreement with a range; `reference` is shown where there is one inside of it."""
        return cls(
            name=name,
            value=value,
            unit=unit,
            reference=reference,
            lower=lower,
            upper=upper,
            tolerance=f"{lower:g} to {upper:g}",
            source=source,
        )

    @classmethod
    def at_most(
        cls, name: str, value: float, *, limit: float, unit: str, source: str
    ) -> Comparison:
        """Agreement where the value does not exceed the limit."""
        return cls(
            name=name,
            value=value,
            unit=unit,
            reference=None,
            lower=-math.inf,
            upper=limit,
            tolerance=f"≤ {limit:g}",
            source=source,
        )

    @classmethod
    def at_least(
        cls, name: str, value: float, *, limit: float, unit: str, source: str
    ) -> Comparison:
        """Agreement where the value reaches the limit."""
        return cls(
            name=name,
            value=value,
            unit=unit,
            reference=None,
            lower=limit,
            upper=math.inf,
            tolerance=f"≥ {limit:g}",
            source=source,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """One line or cloud of a plot: `x` and `y` (n,) in the units of the axes.

    `kind` tells what it is: a result of vulnus, a reference to compare with, or points.
    `error` (n,) draws bars.
    """

    x: AnyArray
    y: AnyArray
    label: str
    kind: Literal["result", "reference", "points", "reference points"] = "result"
    error: AnyArray | None = None

    def __post_init__(self) -> None:
        """Refuse curves whose axes differ in length."""
        if np.shape(self.x) != np.shape(self.y) or np.ndim(self.x) != 1:
            raise ValueError(f"{self.label}: x {np.shape(self.x)} and y {np.shape(self.y)}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """One pair of axes of a case's plot; `x` and `y` are their labels with units."""

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CaseReport:
    """All that a case found, and what its plot shows."""

    comparisons: tuple[Comparison, ...]
    panels: tuple[Panel, ...] = ()
