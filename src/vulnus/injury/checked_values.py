"""Checks of single values at the border of an experiment; each error names value and limit."""

from __future__ import annotations

import difflib
import inspect
import math
import numbers as numbers_abc
import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

SHORTEST, LONGEST = 1e-9, 1e6
"""Lengths [m] that an experiment knows [chosen: their fifth powers stay far from over- and
underflow, and no tissue is finer or larger]."""
SQUARED = 1e-100, 1e100
"""Numbers between these can be squared without over- or underflow."""
FASTEST = 2e4
"""Greatest speed [m/s] [chosen: twice the fastest projectiles of any gun]."""
MOST_POINTS = 2e8
"""Points of one body [chosen: 50 GB of fields]."""
LONGEST_SHOWN = 80  # characters [chosen: a line]
ADVICE_SI = "Everything here is SI: metres, kilograms, seconds, pascals."


def finite(name: str, value: Any) -> float:
    """`value` as a float, refused where it is not a finite number; texts are none."""
    try:
        number = math.nan if isinstance(value, str | bytes | bool | np.bool_) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ScenarioError(name, f"is {shown(value)}, must be a finite number", ADVICE_SI)
    return number


def not_a_number(value: object) -> bool:
    """Whether something is no finite number."""
    if not isinstance(value, numbers_abc.Real) or isinstance(value, bool):
        return True
    try:
        return not math.isfinite(float(value))
    except OverflowError:
        return True


def positive(name: str, value: Any) -> float:
    """`value` as a float, refused where it is not above zero."""
    number = finite(name, value)
    if not number > 0.0:
        raise ScenarioError(name, f"is {number:g}, must be > 0", ADVICE_SI)
    return number


def length(name: str, value: Any) -> float:
    """`value` [m] as a float, refused where it is none that can be computed with."""
    number = positive(name, value)
    if not SHORTEST <= number <= LONGEST:
        raise ScenarioError(
            name, f"is {number:g} m, must be {SHORTEST:g} to {LONGEST:g} m", ADVICE_SI
        )
    return number


def not_too_fast(name: str, speed: float) -> None:
    """Refuse a speed [m/s] that nothing shot or struck has."""
    if not speed <= FASTEST:
        raise ScenarioError(
            f"{name} speed", f"is {speed:g} m/s, must be at most {FASTEST:g}", ADVICE_SI
        )


def whole_number(name: str, value: Any, most: int) -> int:
    """`value` as an int, refused where it is not a whole number from 0 to `most`."""
    number = not_negative(name, value)
    if number > most or number != int(number):
        raise ScenarioError(
            name, f"is {number:g}, must be a whole number from 0 to {most}", "Round it."
        )
    return int(value)


def not_negative(name: str, value: Any) -> float:
    """`value` as a float, refused where it is below zero."""
    number = finite(name, value)
    if number < 0.0:
        raise ScenarioError(name, f"is {number:g}, must be >= 0", ADVICE_SI)
    return number


def vector(name: str, value: Any) -> Vector3:
    """`value` as three finite floats."""
    array = numbers(value)
    if array.shape != (3,) or not np.isfinite(array).all():
        told = f"is {shown(value)}, must be three finite numbers"
        raise ScenarioError(name, told, "Give (x, y, z).")
    x, y, z = array.tolist()
    return x, y, z


def unit_vector(name: str, value: Any) -> Vector3:
    """`value`, three finite numbers of any length but zero, scaled to length one."""
    array = np.asarray(vector(name, value))
    largest = float(np.max(np.abs(array)))
    if largest == 0.0:
        raise ScenarioError(name, "has no direction: it is (0, 0, 0)", "Give (x, y, z).")
    if not SQUARED[0] < largest < SQUARED[1]:
        array = array / largest
    x, y, z = (array / float(np.linalg.norm(array))).tolist()
    return x, y, z


def points(name: str, value: Any) -> FloatArray:
    """`value` as a contiguous (n, 3) array of finite floats."""
    array = np.ascontiguousarray(numbers(value))
    if array.ndim != 2 or array.shape[1] != 3:
        raise ScenarioError(
            name, f"has the shape {array.shape}, must be (n, 3)", "Give one row a point."
        )
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise ScenarioError(
            name, f"row {row} is {array[row].tolist()}, not finite", "Remove or mend that row."
        )
    return array


def one_of(name: str, value: str, known: Iterable[str]) -> str:
    """`value`, refused with the nearest known names where it is not one of `known`."""
    names = list(known)
    if isinstance(value, str) and value in names:
        return value
    near = difflib.get_close_matches(str(value), names, n=1)
    guess = f"Did you mean {near[0]!r}? " if near else ""
    choice = f"Known: {', '.join(names)}." if names else "There are none."
    raise ScenarioError(name, f"{shown(value)} is not known", guess + choice)


def numbers(value: Any) -> FloatArray:
    """`value` as an array of floats; empty where it holds anything but numbers."""
    try:
        given = np.asarray(value)
        if given.dtype.kind in "biuf":
            return given.astype(np.float64)
        return np.zeros(0) if given.dtype.kind != "O" else np.asarray(given, np.float64)
    except (TypeError, ValueError, OverflowError):
        return np.zeros(0)


def given_or_made(name: str, given: Any, position: FloatArray) -> Any:
    """What was given, or what a function that was given makes of positions (n, 3) [m]."""
    if not callable(given):
        return given
    try:
        return given(position)
    except Exception as error:
        raise ScenarioError(
            name,
            f"the function failed with {type(error).__name__}: {error}",
            "It takes positions (n, 3) [m] and gives a value for each.",
        ) from error


def shown(value: Any) -> str:
    """A value as an error shows it, cut where it is long."""
    text = repr(value)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def is_a(name: str, value: object, kinds: type | tuple[type, ...], advice: str) -> None:
    """Refuse what is not of these types."""
    if not isinstance(value, kinds):
        raise ScenarioError(name, f"is {shown(value)}", advice)


def true_or_false(name: str, value: object) -> None:
    """Refuse what is neither True nor False."""
    is_a(name, value, (bool, np.bool_), "Give True or False.")


def refuse_too_many(name: str, points: float) -> None:
    """Refuse to fill what takes more points than a computer holds."""
    if points > MOST_POINTS:
        raise ScenarioError(
            name,
            f"takes {points:.2g} points to fill, must be at most {MOST_POINTS:g}",
            "Use a larger grid_spacing or a smaller body.",
        )


def warn_user(text: str) -> None:
    """Warn at the line outside of vulnus that led here."""
    level, frame = 1, inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__", "").startswith("vulnus."):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, stacklevel=level)


def has_methods(name: str, value: object, methods: Iterable[str], what: str) -> None:
    """Refuse what lacks one of these methods."""
    if not all(callable(getattr(value, method, None)) for method in methods):
        raise ScenarioError(name, f"is {shown(value)}", f"Give {what}.")


def may_be_called(name: str, value: object) -> None:
    """Refuse what is given and is no function."""
    if value is not None and not callable(value):
        raise ScenarioError(name, f"is {shown(value)}", "Give a function, or leave it out.")
