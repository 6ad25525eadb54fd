"""Each wrong scenario gets one clear answer: file, line, key, value, limit, what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from vulnus.core.errors import InputFileError, ScenarioError
from vulnus.scenario import load_scenario, scenario_text


def refusal(tmp_path: Path, text: str) -> ScenarioError:
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert "mine.toml" in caught.value.subject
    return caught.value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "[injury.projectile]\ndiameter_mm = -9",
            ("line 2", "injury.projectile.diameter_mm = -9", "greater than 0", "≤ 40 mm"),
        ),
        ("[injury.projectile]\ndiameter_mm = 900", ("at most 40", "mm")),
        ("[injury.projectile]\ndiameter_mm = nan", ("nan", "finite")),
        ("[injury.projectile]\nspeed_m_per_s = inf", ("inf", "finite")),
        ('[injury.projectile]\ndiameter_mm = "9"', ("'9'", "number")),
        ("[injury.projectile]\ndiameter_mm = true", ("True", "number")),
        ("[run]\nseed = 1.5", ("run.seed = 1.5", "whole number")),
        ("[run]\nseed = -1", ("at least 0",)),
        ("[run]\nseed = 1979-05-27", ("whole number",)),
        ("[visualization]\nenabled = 1", ("true or false",)),
        ("[visualization.film]\nwidth_px = 641", ("multiple of 2",)),
        ("title = 5", ("text in quotes",)),
        ("[anatomy]\nsmoothing_iterations = [1]", ("whole number",)),
        ("injury = 5", ("must be a table",)),
        ("[injury.aim]\ntarget_mm = [1, 2]", ("3 entries, has 2",)),
        ('[injury.aim]\ntarget_mm = [1, 2, "x"]', ("target_mm[2] = 'x'",)),
        ("[injury.aim]\ndirection = [0, 0, 0]", ("not be [0, 0, 0]",)),
        ('[injury.aim]\nartery = "fibular"\ntarget_mm = [0, 0, 0]', ("not both",)),
        ("[injury.aim]\nfraction = 1.2", ("fraction = 1.2", "at most 1")),
        ('[hemorrhage]\ngravity_direction = "down"', ("'down'", "distal")),
        ("[hemorrhage]\ngravity_direction = [0, 0, 0]", ("not all zero",)),
        ("[hemorrhage]\ngravity_direction = [0, inf, 0]", ("three numbers",)),
        ('[hemorrhage]\nequations = "mine"', ("'corrected' or 'as_printed'",)),
        ("[coupling]\nduration_s = 0.1\nframe_interval_s = 1", ("must not be longer",)),
        ("[imaging.labels]\nbones = 3", ("'bones'", "bone")),
        ("[imaging.labels]\nbone = 300", ("at most 255",)),
        ("[imaging]\nsource = ''", ("must not be empty",)),
        ('preset = "dmeo"', ("dmeo", "Did you mean demo?")),
        ("preset = 3", ("no such preset",)),
    ],
)
def test_a_wrong_value_is_named_with_its_limit(
    tmp_path: Path, text: str, words: tuple[str, ...]
) -> None:
    said = str(refusal(tmp_path, text))
    for word in words:
        assert word in said


@pytest.mark.parametrize(
    ("text", "nearest"),
    [
        ("[injury.projectile]\ndiametre_mm = 9", "injury.projectile.diameter_mm"),
        ("[injury.projectile]\ndiameter_m = 9", "injury.projectile.diameter_mm"),
        ("[injury.projectile]\nspeed = 9", "injury.projectile.speed_m_per_s"),
        ("[injury]\ndiameter_mm = 9", "injury.projectile.diameter_mm"),
        ("[injuri]\nduration_ms = 9", "injury"),
        ("[hemorrhage]\nporosity = 0.1", "hemorrhage.porosity_intact"),
        ("titel = 'x'", "title"),
        ("[visualization.movie]\nfilm = true", "visualization"),
        ("[circulation]\nheart_rate = 70", "circulation.heart_rate_per_min"),
    ],
)
def test_an_unknown_key_is_refused_with_the_nearest_known_name(
    tmp_path: Path, text: str, nearest: str
) -> None:
    error = refusal(tmp_path, text)
    assert "not known" in error.problem
    assert f"Did you mean {nearest}" in error.advice


def test_several_errors_are_told_together(tmp_path: Path) -> None:
    said = str(
        refusal(
            tmp_path, "[run]\nsed = 1\n[injury.projectile]\ndiameter_mm = -9\nspeed_m_per_s = 0"
        )
    )
    for word in ("3 keys", "line 2: run.sed", "run.seed", "line 4", "line 5", "diameter_mm = -9"):
        assert word in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[injury\nx = 1", "line 1"),
        ("a = 1\na = 2", "line 2"),
        ("a = ", "line 1"),
        ("[x]\n[x]\n", "line 2"),
        ("a = " + "9" * 5000, "absurdly long"),
        ("a = " + "[" * 5000, "absurdly long"),
    ],
)
def test_broken_toml_is_told_with_its_line(tmp_path: Path, text: str, words: str) -> None:
    assert words in str(refusal(tmp_path, text))


def test_what_is_no_text_file_is_told(tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "big.toml").write_bytes(b"#" * (1 << 21))
    for source, words in (
        (tmp_path / "x.toml", "UTF-8"),
        (tmp_path / "big.toml", "1 MiB"),
        (tmp_path, "directory"),
        ("bad\0name", "cannot be read"),
    ):
        with pytest.raises(ScenarioError, match=words):
            load_scenario(source)


def test_a_missing_scenario_names_the_nearest_file_or_the_presets(tmp_path: Path) -> None:
    (tmp_path / "vertical.toml").write_text("")
    with pytest.raises(ScenarioError, match=r"Did you mean .*vertical\.toml"):
        load_scenario(tmp_path / "vertcal.toml")
    with pytest.raises(ScenarioError, match=r"tibial_vertical\? Presets: demo, demo_short"):
        load_scenario("tibial_vertica")


def test_paths_are_relative_to_the_scenario_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "legs").mkdir()
    (tmp_path / "legs" / "leg.nrrd").write_bytes(b"x")
    (tmp_path / "mine.toml").write_text('[imaging]\nsource = "legs/leg.nrrd"')
    monkeypatch.chdir("/")
    scenario = load_scenario(tmp_path / "mine.toml")
    assert scenario.inputs == (tmp_path / "legs" / "leg.nrrd",)
    again = tmp_path / "elsewhere" / "scenario.toml"
    again.parent.mkdir()
    again.write_text(scenario.text)
    assert load_scenario(again) == scenario


def test_a_missing_volume_is_told_before_anything_runs(tmp_path: Path) -> None:
    (tmp_path / "leg_left.nrrd").write_bytes(b"x")
    (tmp_path / "mine.toml").write_text('[imaging]\nsource = "leg_lefd.nrrd"')
    with pytest.raises(InputFileError, match=r"leg_lefd.*Did you mean .*leg_left\.nrrd"):
        load_scenario(tmp_path / "mine.toml")
    assert "leg_lefd" in scenario_text(tmp_path / "mine.toml")  # it can still be shown


def test_a_directory_in_the_place_of_a_volume_is_told(tmp_path: Path) -> None:
    (tmp_path / "legs").mkdir()
    (tmp_path / "mine.toml").write_text('[imaging]\nsource = "legs"')
    with pytest.raises(InputFileError, match=r"legs: it is a directory"):
        load_scenario(tmp_path / "mine.toml")


def test_a_mark_in_front_of_the_text_is_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "marked.toml").write_bytes(b'\xef\xbb\xbftitle = "from another editor"')
    assert load_scenario(tmp_path / "marked.toml").title == "from another editor"


def test_a_preset_as_the_base_gives_all_that_is_not_said(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('preset = "demo"\n[injury.aim]\ntarget_mm = [1, 2, 3]\nazimuth_deg = 200')
    mine, demo = load_scenario(path), load_scenario("demo")
    assert mine.anatomy == demo.anatomy
    assert mine.injury.grid_spacing == demo.injury.grid_spacing
    assert mine.injury.aim.target == (0.001, 0.002, 0.003)
    assert mine.injury.aim.artery is None
