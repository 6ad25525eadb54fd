"""The coarsest run's numbers stay what they are; laws and balances are pinned elsewhere."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vulnus.cli import main

pytestmark = pytest.mark.regression

TINY = Path(__file__).with_name("tiny.toml")

# Name: (value, relative tolerance). The tree is solved in double precision: its flow moves only
# with the place of the cut, which is resolved to a particle in a hundred. Areas are counts of holes
# between particles 4 mm apart on a grid of 8 mm; a few particles more or less are a third of them.
GOLDEN = {
    "bleeding.duration_s": (1.0, 1e-9),
    "bleeding.injected_ml": (6.53, 0.02),
    "bleeding.in_limb_ml": (6.53, 0.05),
    "bleeding.mean_flow_first_beat_ml_per_min": (405.0, 0.02),
    "bleeding.beat_period_s": (0.82876, 1e-4),
    "wound.exit_area_mm2": (1014.0, 0.35),
    "wound.particles": (29533, 0.02),
}


def test_the_tiny_run_gives_its_numbers(tmp_path: Path) -> None:
    text = TINY.read_text().replace("checkpoint_interval_s = 0.0", "checkpoint_interval_s = 20.0")
    (tmp_path / "tiny.toml").write_text(text)
    assert main(["run", str(tmp_path / "tiny.toml"), "-o", str(tmp_path / "run")]) == 0
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["wound"]["severed_segment"] == "anterior_tibial"
    assert summary["bleeding"]["volume_error_fraction"] <= 0.005
    assert summary["bleeding"]["barrier_crossings"] == 0
    found = {}
    for name in GOLDEN:
        table, key = name.split(".")
        found[name] = summary[table][key]
    wrong = {
        name: (found[name], value)
        for name, (value, tolerance) in GOLDEN.items()
        if found[name] != pytest.approx(value, rel=tolerance)
    }
    assert wrong == {}
