"""The code of the guide to experiments runs as it stands."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

GUIDE = Path(__file__).parents[2] / "docs" / "guide" / "injury_experiments.md"


def test_every_block_of_the_guide_runs_in_its_order() -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(encoding="utf-8"), re.S | re.M)
    assert len(blocks) >= 8
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number, block in enumerate(blocks):
            exec(compile(block, f"{GUIDE.name}, block {number}", "exec"), names)
    assert names["names"] == {3: "bone", 5: "label 5"}
    assert names["result"].rigid_body("ball").residual_speed < 150.0
    # E A of a bar of 12 mm edge and 1 MPa, 20 %: a wave runs to and fro while it is pulled.
    assert abs(names["force"][-1] / names["strain"][-1] / 144.0 - 1.0) < 0.2
