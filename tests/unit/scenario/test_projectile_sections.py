"""What a scenario says about projectiles becomes exactly that, or is refused by name."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import InputFileError, ScenarioError
from vulnus.injury import PROJECTILES
from vulnus.injury.parameters import InjuryParameters
from vulnus.scenario import (
    load_scenario,
    preset_purposes,
    scenario_from_text,
    scenario_text,
)
from vulnus.scenario.projectile_sections import ProjectileSection
from vulnus.scenario.toml_text import value_as_toml


def injury(text: str) -> InjuryParameters:
    return scenario_from_text(text, file="mine.toml").injury


@pytest.mark.parametrize("name", sorted(PROJECTILES))
def test_a_name_stands_for_the_values_of_the_table(name: str) -> None:
    row, made = PROJECTILES[name], injury(f'[injury.projectile]\nname = "{name}"').projectile
    assert made.name == name
    assert made.shape == row.shape
    for key in ("mass", "speed", "length", "nose_length", "width", "thickness", "depth"):
        assert getattr(made, key) == pytest.approx(getattr(row, key), rel=1e-9), key
    assert made.diameter == pytest.approx(row.diameter or row.width)
    assert made.spin == pytest.approx(row.spin, rel=1e-9)
    assert made.motion == ("kinematic" if row.shape == "blade" else "dynamic")


def test_a_key_goes_before_the_table() -> None:
    made = injury('[injury.projectile]\nname = "9x19_fmj"\nmass_g = 7.45\nspeed_m_per_s = 250')
    assert made.projectile.mass == 0.00745
    assert made.projectile.spin == pytest.approx(2 * math.pi * 250 / PROJECTILES["9x19_fmj"].twist)
    assert made.projectile.diameter == 0.009


def test_in_the_paper_mode_what_flies_keeps_its_velocity() -> None:
    paper = '[injury]\nmode = "paper"\n[injury.projectile]\nname = "9x19_fmj"\n'
    assert injury(paper).projectile.motion == "kinematic"
    assert injury("[injury.projectile]\ndiameter_mm = 7").projectile.motion == "kinematic"
    assert injury("[injury.projectile]\nmass_g = 3").projectile.motion == "dynamic"


def test_several_projectiles_have_their_own_lines() -> None:
    made = injury(
        '[[injury.projectiles]]\nname = "fsp_1.10g"\n[injury.projectiles.aim]\nazimuth_deg = 90\n'
        "[[injury.projectiles]]\ndiameter_mm = 6\n[injury.projectiles.aim]\nfraction = 0.2\n"
    )
    assert made.projectile.shape == "cylinder"
    assert made.aim.azimuth == pytest.approx(math.pi / 2)
    (other,) = made.other_shots
    assert other.projectile.diameter == 0.006
    assert other.aim.fraction == 0.2


def test_several_projectiles_survive_the_printed_scenario(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(
        'preset = "demo"\n[[injury.projectiles]]\nname = "22lr"\n[[injury.projectiles]]\n'
        "diameter_mm = 5\n[injury.projectiles.aim]\nazimuth_deg = 12\n"
    )
    (tmp_path / "b.toml").write_text(scenario_text(tmp_path / "a.toml"))
    first, second = load_scenario(tmp_path / "a.toml"), load_scenario(tmp_path / "b.toml")
    assert first == second
    assert len(first.injury.other_shots) == 1
    assert first.injury.projectile.name == "22lr"  # the demo's ball is replaced, not joined


def test_an_stl_file_lies_beside_the_scenario_and_must_be_there(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('[injury.projectile]\nstl = "nail.stl"\nmass_g = 2\n')
    with pytest.raises(InputFileError, match=r"nail\.stl.*no such file"):
        load_scenario(tmp_path / "a.toml")
    (tmp_path / "nail.stl").write_text("solid nail\nendsolid\n")
    scenario = load_scenario(tmp_path / "a.toml")
    assert scenario.injury.projectile.mesh == tmp_path / "nail.stl"
    assert scenario.injury.projectile.mesh_scale == 0.001
    assert tmp_path / "nail.stl" in scenario.inputs


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ('name = "9x19"', ("line 2", "did you mean 9x19_fmj")),
        ('shape = "cylinder"\ndiameter_mm = 5', ("a cylinder needs length_mm",)),
        ('shape = "stl"', ("a stl needs stl",)),
        ('shape = "blade"', ("a blade needs length_mm",)),
        ("length_mm = 5", ("length_mm has no meaning for a sphere",)),
        ('motion = "dynamic"', ("needs mass_g",)),
        ('name = "knife"\nmotion = "dynamic"', ("guided by a hand",)),
        ('name = "22lr"\nnose_length_mm = 50', ("nose_length_mm must not exceed length_mm",)),
        ('name = "knife"\nshape = "sphere"', ("knife is a blade, not a sphere",)),
        ('name = "knife"\ndepth_mm = 130', ("depth_mm is 130 mm, must not exceed length_mm",)),
        ('name = "knife"\nthickness_mm = 20\nwidth_mm = 10', ("thickness_mm is 20 mm",)),
        ('name = "knife"\nspin_rev_per_s = 2', ("does not turn",)),
        ("yaw_deg = 200", ("at most 180", "deg")),
        ("spin = 20", ("Did you mean injury.projectile.spin_rev_per_s",)),
        ('shape = "dart"', ("must be 'sphere'",)),
    ],
)
def test_what_cannot_fly_is_refused(text: str, parts: tuple[str, ...]) -> None:
    with pytest.raises(ScenarioError) as error:
        injury(f"[injury.projectile]\n{text}")
    for part in parts:
        assert part in str(error.value), str(error.value)


def test_a_complaint_about_one_of_several_names_it_and_its_line() -> None:
    text = '[[injury.projectiles]]\nname = "22lr"\n[[injury.projectiles]]\n\nmass_g = -1\n'
    with pytest.raises(ScenarioError, match=r"line 5: injury\.projectiles\[1\]\.mass_g = -1"):
        injury(text)
    with pytest.raises(ScenarioError, match="not both"):
        injury(text.replace("-1", "1") + "[injury.projectile]\ndiameter_mm = 5\n")


PRESETS = sorted(preset_purposes())


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("name", ["knife", "bb_4.5mm", "7.62x39"])
def test_a_name_over_any_preset_brings_all_of_the_table_s_values(preset: str, name: str) -> None:
    alone = injury(f'[injury.projectile]\nname = "{name}"').projectile
    mode = 'mode = "full"\n'
    over = f'preset = "{preset}"\n[injury]\n{mode}[injury.projectile]\nname = "{name}"\n'
    assert injury(over).projectile == alone
    assert injury(over.replace(mode, "")).duration is None  # or a knife would not be out again
    mine = injury(over + "speed_m_per_s = 5.5\n").projectile
    assert mine.speed == 5.5
    assert mine.mass == alone.mass


def test_a_shape_over_a_preset_drops_its_name_and_a_size_alone_keeps_it() -> None:
    bullet = 'preset = "gunshot_9mm"\n[injury.projectile]\n'
    ball = injury(bullet + 'shape = "sphere"\ndiameter_mm = 6.0\n').projectile
    assert (ball.name, ball.mass, ball.yaw) == (None, None, 0.0)
    wider = injury(bullet + "diameter_mm = 9.2\n").projectile
    assert (wider.name, wider.diameter) == ("9x19_fmj", 0.0092)
    assert wider.yaw == pytest.approx(math.radians(2.0))


KNIFE = '[injury.projectile]\nname = "knife"\n'


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("[injury]\nlaceration_threshold = 0.95", "laceration_threshold is 0.95, must not exceed"),
        ('[injury]\nmode = "paper"\nbleeds_from = "temporary"', 'bleeds_from = "temporary" has no'),
        (
            '[injury]\nmode = "paper"\n[injury.projectile]\nmass_g = 5\nmotion = "dynamic"',
            'motion = "dynamic" has no meaning in the mode "paper"',
        ),
        (
            '[injury]\nmode = "paper"\n[[injury.projectiles]]\nname = "22lr"\nmotion = "dynamic"',
            'motion = "dynamic" has no meaning in the mode "paper"',
        ),
        ("[injury]\nwindow_length_mm = 40", "window_length_mm is 40 mm, must exceed"),
        ("[injury]\nduration_ms = 15\n" + KNIFE, "the blade needs 17.14 ms in and out"),
        ("[injury]\ngrid_spacing_mm = 2\n[anatomy]\nparticle_spacing_mm = 3", "less than anatomy"),
        ("[injury.aim]\nstart_mm = [0, 0, 0]\ndirection = [0, 1, 0]", "start_mm or direction"),
    ],
)
def test_what_contradicts_itself_is_refused(text: str, part: str) -> None:
    with pytest.raises(ScenarioError) as error:
        injury(text)
    assert part in str(error.value), str(error.value)


NUMBERS = st.one_of(
    st.floats(-10, 1e4), st.sampled_from([0, 1, -1, math.nan, math.inf, 1e300, "9", True, "auto"])
)
WORDS = st.sampled_from(["sphere", "ogive", "blade", "stl", "dynamic", "22lr", "knife", "", 3])
TABLES = st.dictionaries(
    st.sampled_from([*ProjectileSection.model_fields, "diametre_mm"]), st.one_of(NUMBERS, WORDS)
)


@settings(derandomize=True, max_examples=150, deadline=None)
@given(tables=st.lists(TABLES, max_size=3), single=st.booleans())
def test_any_projectile_becomes_parameters_or_is_refused(
    tables: list[dict[str, Any]], *, single: bool
) -> None:
    heading = "[injury.projectile]" if single else "[[injury.projectiles]]"
    text = "".join(
        f"{heading}\n"
        + "".join(f"{key} = {value_as_toml(value)}\n" for key, value in table.items())
        for table in (tables[:1] if single else tables)
    )
    try:
        made = injury(text)
    except ScenarioError:
        return
    for one in (made.projectile, *(shot.projectile for shot in made.other_shots)):
        sizes = (one.diameter, one.length, one.nose_length, one.width, one.thickness, one.speed)
        assert all(math.isfinite(size) and size >= 0.0 for size in sizes)
        assert one.speed > 0.0
        assert one.diameter > 0.0
        assert one.motion == "kinematic" or one.mass is not None
