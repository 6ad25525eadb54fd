"""Checks of single values at the border of an experiment; each error names value and limit."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

ADVICE_SI = "Everything here is SI: metres, kilograms, seconds, pascals."


def finite(name: str, value: float) -> float:
    """`value` as a float, refused where it is not a finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise ScenarioError(name, f"is {value!r}, must be a finite number", ADVICE_SI)
    return number


def positive(name: str, value: float) -> float:
    """`value` as a float, refused where it is not above zero."""
    number = finite(name, value)
    if not number > 0.0:
        raise ScenarioError(name, f"is {number:g}, must be > 0", ADVICE_SI)
    return number


def not_negative(name: str, value: float) -> float:
    """`value` as a float, refused where it is below zero."""
    number = finite(name, value)
    if number < 0.0:
        raise ScenarioError(name, f"is {number:g}, must be >= 0", ADVICE_SI)
    return number


def vector(name: str, value: Any) -> Vector3:
    """`value` as three finite floats."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(0, np.nan)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ScenarioError(name, f"is {value!r}, must be three finite numbers", "Give (x, y, z).")
    x, y, z = array.tolist()
    return x, y, z


def unit_vector(name: str, value: Any) -> Vector3:
    """`value`, three finite numbers of any length but zero, scaled to length one."""
    array = np.asarray(vector(name, value))
    length = float(np.linalg.norm(array))
    if length == 0.0:
        raise ScenarioError(name, "has no direction: it is (0, 0, 0)", "Give (x, y, z).")
    x, y, z = (array / length).tolist()
    return x, y, z


def points(name: str, value: Any) -> FloatArray:
    """`value` as a contiguous (n, 3) array of finite floats."""
    try:
        array = np.ascontiguousarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
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
    if value in names:
        return value
    near = difflib.get_close_matches(str(value), names, n=1)
    guess = f"Did you mean {near[0]!r}? " if near else ""
    raise ScenarioError(name, f"{value!r} is not known", f"{guess}Known: {', '.join(names)}.")
