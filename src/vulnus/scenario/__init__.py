"""Scenarios: TOML with units in its keys at the border, frozen SI parameters inside."""

from __future__ import annotations

from .scenario import (
    Scenario,
    differences,
    load_scenario,
    preset_purposes,
    scenario_from_text,
    scenario_text,
)

__all__ = [
    "Scenario",
    "differences",
    "load_scenario",
    "preset_purposes",
    "scenario_from_text",
    "scenario_text",
]
