"""Debris that flies far: the box of an experiment leaves it room where none is given."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury import Block, Experiment, elastic


def test_debris_flies_on_for_longer_than_a_cavity_takes_to_collapse() -> None:
    """A piece beside a block at rest; 300 m/s for 10 ms, splash of a fast shot, is 3 m."""
    experiment = Experiment(grid_spacing=4e-3)
    soft = elastic(1000.0, 1e5, 0.3)
    experiment.add_body(Block(size=(0.04,) * 3), material=soft, name="block")
    debris = Block(size=(0.012,) * 3, centre=(0.06, 0.0, 0.0))
    experiment.add_body(debris, material=soft, velocity=(300.0, 0.0, 0.0), name="debris")
    fields = experiment.run(until=10e-3, sample_interval=5e-3).final
    moved = fields.of("debris").displacement[:, 0]
    assert np.mean(moved) == pytest.approx(3.0, rel=1e-4)  # round-off of float32
    assert np.abs(fields.of("block").displacement).max() < 1e-6
