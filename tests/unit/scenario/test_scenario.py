"""What is printed is what runs: text, tables and SI parameters say the same."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from vulnus.anatomy.parameters import AnatomyParameters
from vulnus.circulation.parameters import CirculationParameters
from vulnus.coupling.parameters import CouplingParameters
from vulnus.hemorrhage.parameters import HemorrhageParameters, PlatformParameters
from vulnus.imaging.parameters import ImagingParameters
from vulnus.injury.parameters import AimParameters, InjuryParameters, ProjectileParameters
from vulnus.scenario import (
    differences,
    load_scenario,
    preset_purposes,
    scenario_from_text,
    scenario_text,
)
from vulnus.scenario.config import ScenarioConfig
from vulnus.scenario.quantity import UNITS, Section, tables_of, unit_of
from vulnus.scenario.toml_text import as_toml, value_as_toml
from vulnus.visualization.parameters import VisualizationParameters

PRESETS = (
    "demo",
    "demo_short",
    "gunshot_9mm",
    "knife_stab",
    "tibial_horizontal_platform",
    "tibial_impact",
    "tibial_vertical",
)


def test_the_presets_are_these_and_say_what_they_are_for() -> None:
    purposes = preset_purposes()
    assert tuple(purposes) == PRESETS
    assert all(len(purpose) > 40 for purpose in purposes.values())


@pytest.mark.parametrize("name", PRESETS)
def test_the_text_of_a_preset_gives_the_preset(tmp_path: Path, name: str) -> None:
    text = scenario_text(name)
    (tmp_path / "x.toml").write_text(text, encoding="utf-8")
    assert load_scenario(tmp_path / "x.toml") == load_scenario(name)
    assert scenario_text(tmp_path / "x.toml") == text


def test_every_default_is_visible() -> None:
    shown = tomllib.loads(as_toml(ScenarioConfig()))

    def missing(config: type[Section], table: dict[str, Any]) -> Iterator[str]:
        for key, field in config.model_fields.items():
            if key not in table:
                yield key
            elif isinstance(field.annotation, type) and issubclass(field.annotation, Section):
                yield from missing(field.annotation, table[key])

    assert list(missing(ScenarioConfig, shown)) == []


def test_every_key_has_a_meaning_and_a_known_unit_that_its_name_ends_with() -> None:
    suffixes = {
        "mm": "_mm",
        "ms": "_ms",
        "s": "_s",
        "g": "_g",
        "rev/s": "_rev_per_s",
        "deg": "_deg",
        "m/s": "_m_per_s",
        "mPa s": "_mpa_s",
        "kg/m³": "_kg_per_m3",
        "m²": "_m2",
        "mmHg": "_mmhg",
        "ml/mmHg": "_ml_per_mmhg",
        "Pa s/m³": "_pa_s_per_m3",
        "1/min": "_per_min",
        "1/s": "_per_second",
        "px": "_px",
    }

    def check(config: type[Section]) -> None:
        for key, field in config.model_fields.items():
            if isinstance(field.annotation, type) and issubclass(field.annotation, Section):
                check(field.annotation)
                continue
            if inner := tables_of(field):
                check(inner)
            unit = unit_of(field)
            assert field.description, key
            assert unit in UNITS
            assert key.endswith(suffixes[unit]) if unit else True, key

    check(ScenarioConfig)


def test_an_empty_scenario_is_the_stages_own_defaults(tmp_path: Path) -> None:
    (tmp_path / "empty.toml").write_text("")
    scenario = load_scenario(tmp_path / "empty.toml")
    given = {"seed": scenario.seed, "threads": scenario.threads}
    pairs = (
        (scenario.imaging.leg, ImagingParameters().leg),
        (scenario.anatomy, AnatomyParameters(seed=1)),
        (scenario.injury.projectile, InjuryParameters().projectile),
        (scenario.injury.aim, InjuryParameters().aim),
        (scenario.injury, InjuryParameters(**given)),
        (scenario.circulation, CirculationParameters()),
        (scenario.hemorrhage, HemorrhageParameters(**given)),
        (scenario.coupling, CouplingParameters()),
        (scenario.visualization.film, VisualizationParameters().film),
        (scenario.visualization.blood_surface, VisualizationParameters().blood_surface),
        (scenario.visualization, VisualizationParameters(seed=1)),
    )
    for mine, own in pairs:
        for item in dataclasses.fields(own):
            value, default = getattr(mine, item.name), getattr(own, item.name)
            if isinstance(default, float):
                # Twelve digits go through the text; a factor may cost the last bit.
                assert math.isclose(value, default, rel_tol=1e-11), item.name
            elif not dataclasses.is_dataclass(default):
                assert value == default, item.name


def test_every_parameter_of_every_stage_has_a_key() -> None:
    """A new parameter that no scenario can set shows here."""
    elsewhere = {
        AnatomyParameters: {"seed"},
        ImagingParameters: {"source", "centrelines", "label_map", "leg"},
        InjuryParameters: {
            "projectile",
            "aim",
            "other_shots",
            "window_length",
            "gravity",
            "seed",
            "threads",
        },
        ProjectileParameters: {"name", "shape", "motion", "mesh"},
        AimParameters: {"artery"},
        HemorrhageParameters: {"gravity", "platform", "as_printed", "seed", "threads"},
        PlatformParameters: {"point", "normal"},
        VisualizationParameters: {"blood_surface", "film", "seed"},
        CirculationParameters: set(),
        CouplingParameters: set(),
    }
    config = ScenarioConfig()
    sections = (
        (AnatomyParameters, config.anatomy),
        (ImagingParameters, config.imaging),
        (InjuryParameters, config.injury),
        (ProjectileParameters, config.injury.projectile),
        (AimParameters, config.injury.aim),
        (HemorrhageParameters, config.hemorrhage),
        (PlatformParameters, config.hemorrhage.platform),
        (VisualizationParameters, config.visualization),
        (CirculationParameters, config.circulation),
        (CouplingParameters, config.coupling),
    )
    for kind, section in sections:
        keyed = {
            (field.json_schema_extra or {}).get("parameter")
            for field in type(section).model_fields.values()
        }
        names = {item.name for item in dataclasses.fields(kind)}
        assert names - elsewhere[kind] <= keyed, kind.__name__


def test_units_become_si() -> None:
    scenario = scenario_from_text(
        "[injury.projectile]\ndiameter_mm = 9\n[injury.aim]\nazimuth_deg = 180\n"
        "[injury]\nduration_ms = 2\nwindow_length_mm = 0\n"
        '[circulation]\nheart_rate_per_min = 60\nvenous_pressure_mmhg = "5"\n'.replace('"5"', "5")
        + '[hemorrhage]\ngravity_direction = "posterior"\nviscosity_mpa_s = 3.5\n'
        '[hemorrhage.platform]\nenabled = true\ngap_mm = 4\n[imaging]\ncentrelines = "auto"\n',
        file="text",
    )
    assert scenario.injury.projectile.diameter == 0.009
    assert scenario.injury.aim.azimuth == pytest.approx(math.pi, rel=1e-15)
    assert scenario.injury.duration == 0.002
    assert scenario.injury.window_length is None
    assert scenario.circulation.heart_rate == pytest.approx(1.0, rel=1e-15)
    assert scenario.circulation.venous_pressure == 5 * 133.322387415
    assert scenario.hemorrhage.gravity == scenario.injury.gravity == (0.0, 9.80665, 0.0)
    assert scenario.hemorrhage.viscosity == 0.0035
    assert scenario.hemorrhage.platform == PlatformParameters(gap=0.004)
    assert scenario.imaging.centrelines is None


def test_gravity_as_a_vector_has_the_standard_strength() -> None:
    scenario = scenario_from_text("[hemorrhage]\ngravity_direction = [0, 3, -4]", file="text")
    assert scenario.hemorrhage.gravity == pytest.approx((0.0, 0.6 * 9.80665, -0.8 * 9.80665))


def test_differences_name_the_keys_that_change_a_number() -> None:
    demo = scenario_text("demo")
    other = demo.replace("duration_s = 3.0", "duration_s = 4.5", 1).replace(
        "threads = 0", "threads = 1"
    )
    assert other != demo
    assert differences(demo, other) == ["coupling.duration_s was 3.0, now 4.5"]
    assert differences(demo, demo.replace('title = "', 'title = "My ')) == []


@pytest.mark.parametrize(
    "value",
    ["", 'a "quoted" \\ path\n\ttab', "\x7f\x01", "ü 😀", True, -7, 1e-300, 1e16, 0.1, [1.5, [2]]],
)
def test_values_survive_toml(value: Any) -> None:
    assert tomllib.loads(f"x = {value_as_toml(value)}")["x"] == value


def test_a_table_with_odd_names_survives_toml() -> None:
    table = {"a b": 1, "plain": 2, 'q"': 3}
    assert tomllib.loads(f"x = {value_as_toml(table)}")["x"] == table
