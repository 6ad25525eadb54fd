"""The tables that the built-in leg is made from; every number stands there with its source."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from types import MappingProxyType

from vulnus.core.units import MILLIMETRE

_UNITS = {"mm": MILLIMETRE, "1": 1.0, "deg": 1.0}


@dataclass(frozen=True, slots=True)
class Measurement:
    """One number of the table: `value` in SI and where it comes from."""

    value: float
    source: str


@cache
def read_measurements() -> MappingProxyType[str, Measurement]:
    """The scalar measurements of the built-in leg by name, in SI."""
    text = files("vulnus.imaging").joinpath("data/leg_measurements.csv").read_text("utf-8")
    rows = csv.DictReader(text.splitlines())
    return MappingProxyType(
        {
            row["name"]: Measurement(float(row["value"]) * _UNITS[row["unit"]], row["source"])
            for row in rows
        }
    )


def measurement(name: str) -> float:
    """The value of one measurement [SI]."""
    return read_measurements()[name].value
