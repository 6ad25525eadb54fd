"""The scenarios that the handbook shows are scenarios."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from vulnus.cli import main
from vulnus.scenario import preset_purposes, scenario_from_text

GUIDES = Path(__file__).parents[3] / "docs"
BLOCK = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)
SCENARIOS = [
    pytest.param(text, id=f"{guide.stem}-{number}")
    for guide in sorted(GUIDES.rglob("*.md"))
    for number, text in enumerate(BLOCK.findall(guide.read_text(encoding="utf-8")))
]


@pytest.mark.parametrize("text", SCENARIOS)
def test_a_scenario_of_the_handbook_can_be_used(text: str) -> None:
    scenario_from_text(text, file="the handbook", folder=GUIDES)


def test_presets_that_the_handbook_runs_are_there() -> None:
    told = {
        name
        for guide in GUIDES.rglob("*.md")
        for name in re.findall(r"^vulnus run ([a-z0-9_]+) -o", guide.read_text(), re.MULTILINE)
    }
    assert told <= set(preset_purposes())
    assert {"gunshot_9mm", "knife_stab"} <= told


def test_the_table_of_projectiles_names_every_source(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["projectiles"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:2] == ["name", "shape"]
    (bullet,) = [line for line in lines if line.startswith("9x19_fmj ")]
    for part in ("ogive", " 8 ", "9 x 15.5", "360 (350-380)", "9x19 mm Parabellum"):
        assert part in bullet
    assert all("[" in line for line in lines[1:])  # a mark of the source
