"""One key of a scenario: its unit, meaning and limits, and the SI parameter that it becomes.

A key's default is the parameter's own default in the key's unit, so that no number stands twice.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, cast, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic.fields import FieldInfo

from vulnus.core import units

AUTO = "auto"
"""Stands in TOML, which has no null, for "the program chooses"."""

UNITS: Mapping[str, float] = {
    "": 1.0,
    "mm": units.MILLIMETRE,
    "m": 1.0,
    "ms": units.MILLISECOND,
    "s": 1.0,
    "deg": units.DEGREE,
    "m/s": 1.0,
    "mPa s": 1e-3,
    "kg/m³": 1.0,
    "g": units.GRAM,
    "m²": 1.0,
    "mm²": units.SQUARE_MILLIMETRE,
    "ml": units.MILLILITRE,
    "mmHg": units.MILLIMETRE_OF_MERCURY,
    "ml/mmHg": units.MILLILITRE / units.MILLIMETRE_OF_MERCURY,
    "Pa": 1.0,
    "kPa": units.KILOPASCAL,
    "MPa": units.MEGAPASCAL,
    "GPa": units.GIGAPASCAL,
    "Pa s/m³": 1.0,
    "1/min": 1.0 / 60.0,
    "1/s": 1.0,
    "rev/s": 2.0 * math.pi,
    "px": 1.0,
}
"""Unit of a key, as its comment shows it, to SI."""

Parameters = TypeVar("Parameters")


class Section(BaseModel):
    """A table of a scenario: no unknown keys, no silent conversion, finite numbers only."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _read_auto(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        return {
            key: None if value == AUTO and may_be_auto(cls.model_fields.get(key)) else value
            for key, value in data.items()
        }


def may_be_auto(field: FieldInfo | None) -> bool:
    """Whether the key takes "auto": its default is that the program chooses."""
    return field is not None and field.default is None and field.default_factory is None


def quantity(owner: type, parameter: str, unit: str, meaning: str, **limits: Any) -> Any:
    """A key that becomes `owner.parameter` [SI], given in `unit`; its default is the owner's."""
    return Field(
        default=_in_unit(_default_of(owner, parameter), UNITS[unit]),
        description=meaning,
        json_schema_extra={"unit": unit, "parameter": parameter},
        **limits,
    )


def auto_quantity(parameter: str, unit: str, meaning: str, **limits: Any) -> Any:
    """A key that becomes `parameter` [SI], given in `unit`; "auto", its default, is the program's.

    What "auto" stands for is the section's business.
    """
    return Field(
        default=None,
        description=meaning,
        json_schema_extra={"unit": unit, "parameter": parameter},
        **limits,
    )


def choice(default: Any, meaning: str, unit: str = "", **limits: Any) -> Any:
    """A key that becomes no single parameter, with its own default."""
    return Field(default=default, description=meaning, json_schema_extra={"unit": unit}, **limits)


def tables_of(field: FieldInfo) -> type[Section] | None:
    """The table that a key holds any number of, as [[injury.projectiles]]; None for other keys."""
    for inner in get_args(field.annotation):
        if isinstance(inner, type) and issubclass(inner, Section):
            return inner
    return None


def unit_of(field: FieldInfo) -> str:
    """The key's unit, empty where it has none."""
    return str(_extra(field).get("unit", ""))


def parameter_of(field: FieldInfo) -> str | None:
    """The name of the parameter that the key becomes, if it is exactly one."""
    name = _extra(field).get("parameter")
    return None if name is None else str(name)


def to_parameters(section: Section, kind: type[Parameters], **given: Any) -> Parameters:
    """`kind` in SI from the keys of `section`, and from `given` what is not one key."""
    values = {}
    for key, field in type(section).model_fields.items():
        name = parameter_of(field)
        if name is not None:
            values[name] = _in_si(getattr(section, key), UNITS[unit_of(field)])
    return kind(**(values | given))


def _extra(field: FieldInfo) -> Mapping[str, Any]:
    return cast(Mapping[str, Any], field.json_schema_extra or {})


def _default_of(owner: type, parameter: str) -> Any:
    for item in dataclasses.fields(owner):
        if item.name == parameter:
            if item.default_factory is not dataclasses.MISSING:
                return item.default_factory()
            return item.default
    raise AttributeError(f"{owner.__name__} has no {parameter}")


def _in_unit(value: Any, factor: float) -> Any:
    if isinstance(value, float):
        return float(f"{value / factor:.12g}")
    if isinstance(value, tuple):
        return [_in_unit(item, factor) for item in value]
    return str(value) if isinstance(value, Path) else value


def _in_si(value: Any, factor: float) -> Any:
    if isinstance(value, float):
        # 9 mm / 1000 is the double nearest to 0.009 m; 9 mm * 0.001 is not.
        inverse = round(1.0 / factor)
        return value / inverse if inverse > 1 and 1.0 / inverse == factor else value * factor
    if isinstance(value, list):
        return tuple(_in_si(item, factor) for item in value)
    return value
