"""The real legs run end to end: one shot cuts the anterior tibial artery, one cuts nothing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vulnus.cli import main
from vulnus.core.handoff import LabelVolume
from vulnus.imaging import ImagingParameters, load_labels

pytestmark = [pytest.mark.regression, pytest.mark.slow]

TINY = Path(__file__).with_name("tiny.toml").read_text()
LEGS = {
    "vhf": "vhf_left_lower_leg/vhf_left_lower_leg_labels5_0p75mm.seg.nrrd",
    "bp3d": "bp3d_left_lower_leg/bp3d_left_lower_leg_labels5_1mm.nrrd",
}


@pytest.fixture(scope="module", params=sorted(LEGS))
def volume(request: pytest.FixtureRequest, shared_data: Path) -> Path:
    return shared_data / LEGS[request.param]


def run(folder: Path, volume: Path, aim: str) -> tuple[int, dict[str, Any]]:
    text = TINY.replace("voxel_mm = 4.0", f'source = "{volume}"', 1).replace(
        "[injury.aim]\nazimuth_deg = 15.0", f"[injury.aim]\n{aim}"
    )
    text = text.replace("duration_s = 1.0", "duration_s = 0.2").replace(
        "checkpoint_interval_s = 0.0", "checkpoint_interval_s = 20.0"
    )
    assert aim in text
    assert str(volume) in text
    (folder / "mine.toml").write_text(text)
    code = main(["run", str(folder / "mine.toml"), "-o", str(folder / "run")])
    return code, json.loads((folder / "run" / "summary.json").read_text())


def medial_edge(labels: LabelVolume) -> list[float]:
    """A point [mm] 8 mm inside the medial skin, half way down the anterior tibial artery."""
    artery = next(one for one in labels.arteries if one.name == "anterior_tibial")
    height = float(np.median(artery.points[:, 2]))
    place = np.argwhere(labels.labels > 0) * labels.spacing @ labels.direction.T + labels.origin
    slab = place[np.abs(place[:, 2] - height) < 2e-3]
    medial = slab[:, 0].min() + 8e-3  # x points to the patient's left, which is lateral here
    edge = slab[np.abs(slab[:, 0] - medial) < 1e-3]
    return (1e3 * edge.mean(axis=0)).round(1).tolist()


def test_a_shot_through_the_anterior_compartment_cuts_its_artery(
    tmp_path: Path, volume: Path
) -> None:
    code, summary = run(tmp_path, volume, 'artery = "anterior_tibial"\nazimuth_deg = 40.0')
    assert code == 0
    assert summary["wound"]["severed_segment"] == "anterior_tibial"
    assert summary["bleeding"]["injected_ml"] > 0.5
    assert summary["bleeding"]["volume_error_fraction"] <= 0.005
    assert summary["bleeding"]["barrier_crossings"] == 0


def test_a_shot_through_the_medial_edge_cuts_nothing(
    tmp_path: Path, shared_data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    volume = shared_data / LEGS["bp3d"]  # the finer leg gives the same at three times the cost
    target = medial_edge(load_labels(ImagingParameters(source=volume)))
    code, summary = run(tmp_path, volume, f"target_mm = {target}\nazimuth_deg = 180.0")
    assert code == 0
    assert summary["wound"]["severed_segment"] is None
    assert "cut no artery" in capsys.readouterr().err
