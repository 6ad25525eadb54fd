"""Bullets, fragments and a knife run from the scenario to the summary and the frames."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vulnus.cli import main
from vulnus.core.handoff import InjuryOutcome
from vulnus.storage import RunStore
from vulnus.visualization.wound_figures import wound_caption, wound_figure

pytestmark = pytest.mark.regression

LIMB = """
[run]
seed = 7
[imaging]
voxel_mm = 4.0
[anatomy]
particle_spacing_mm = 4.0
level_set_voxel_mm = 2.0
[injury]
grid_spacing_mm = 8.0
window_length_mm = 80.0
"""
SHOTS = """
duration_ms = 1.5
relaxation_frame_interval_ms = 0.25
[[injury.projectiles]]
name = "9x19_fmj"
yaw_deg = 3.0
[injury.projectiles.aim]
artery = "posterior_tibial"
azimuth_deg = 150.0
[[injury.projectiles]]
name = "fsp_2.84g"
[injury.projectiles.aim]
artery = "anterior_tibial"
azimuth_deg = 225.0
"""
STAB = """
duration_ms = 1.5
relaxation_frame_interval_ms = 0.25
[injury.projectile]
name = "knife"
speed_m_per_s = 80.0
depth_mm = 45.0
roll_deg = 90.0
[injury.aim]
artery = "anterior_tibial"
azimuth_deg = 40.0
"""


@pytest.fixture(scope="module")
def shot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("shot"), SHOTS)


@pytest.fixture(scope="module")
def stab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("stab"), STAB)


def run(folder: Path, injury: str) -> Path:
    (folder / "mine.toml").write_text(LIMB + injury)
    where = folder / "run"
    assert main(["run", str(folder / "mine.toml"), "-o", str(where), "--until", "injury"]) == 0
    return where


def report_of(where: Path) -> dict[str, Any]:
    summary = json.loads((where / "summary.json").read_text())
    found: dict[str, Any] = summary["wound"]["report"]
    return found


def test_each_projectile_is_slowed_by_what_it_leaves_in_the_limb(shot: Path) -> None:
    bullet, fragment = report_of(shot)["projectiles"]
    assert (bullet["name"], fragment["name"]) == ("9x19_fmj", "fsp_2.84g")
    for one, speed in ((bullet, 360.0), (fragment, 500.0)):
        assert one["speed_before_m_per_s"] == pytest.approx(speed, rel=1e-3)
        assert one["speed_after_m_per_s"] < 0.98 * speed
        lost = one["energy_before_j"] - one["energy_after_j"]
        # The rest turned into spin and tumbling, or was taken back from it.
        assert one["energy_left_j"] == pytest.approx(lost, rel=0.1)


def test_frames_say_where_each_projectile_is_and_how_it_lies(shot: Path) -> None:
    with RunStore.open(shot) as store:
        frames = list(store.wound_frames)
    path = np.array([frame.frame_data["projectile_position_m"] for frame in frames])
    assert path.shape[1:] == (2, 3)
    way = np.linalg.norm(np.diff(path[:10], axis=0), axis=2)
    assert np.all(way > 0.0)
    for frame in frames:
        turn = frame.frame_data["projectile_rotation"].reshape(2, 3, 3)
        assert np.allclose(turn @ turn.transpose(0, 2, 1), np.eye(3), atol=1e-9)


def test_a_knife_goes_in_and_out_and_leaves_one_hole(stab: Path) -> None:
    (knife,) = report_of(stab)["projectiles"]
    assert knife["fate"] == "left"
    assert knife["exit"] is None
    assert knife["speed_before_m_per_s"] == 80.0
    assert knife["energy_left_j"] > 0.1
    # The way of its tip from the first point of the limb, which lies half a spacing before the
    # skin's surface, to 45 mm behind that: a spacing of 4 mm at most.
    assert report_of(stab)["tract_length_mm"] == pytest.approx(45.0, abs=4.0)
    with RunStore.open(stab) as store:
        outcome = store.load_stage("injury", InjuryOutcome)
    assert outcome is not None
    assert outcome.wound.exit_area is None
    assert "knife: 80 → 0 m/s, left the limb" in wound_caption(outcome.report)
    assert len(wound_figure(outcome.report).axes) == 3
