"""Trees for the tests: the paper's, and small ones made by hand or at random."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.circulation import ArterialTree, CirculationParameters, build_tree
from vulnus.circulation.aortic_signal import AorticSignal
from vulnus.circulation.segments import Segment, build_table


def segment(identity, parent, *, length=0.1, radius=2e-3, resistance=0.0, **changed):
    """A segment with the wall of a limb artery."""
    default = {
        "name": f"vessel {identity}",
        "thickness": 0.2 * radius,
        "youngs_modulus": 8e5,
        "quarter_wave_frequency": 0.0,
        "pair_member": "",
    }
    return Segment(
        id=identity,
        parent=parent,
        length=length,
        radius=radius,
        terminal_resistance=resistance,
        **(default | changed),
    )


def small_tree(segments, *, side="left", **parameters):
    """A tree of the given segments under a pressure of mean 12 kPa and two harmonics."""
    chosen = CirculationParameters(**({"harmonics": 32, "venous_pressure": 0.0} | parameters))
    phase = 2.0 * np.pi * np.arange(64) / 64
    pressure = 12e3 + 3e3 * np.sin(phase) + 1e3 * np.cos(3.0 * phase)
    flow = 1e-5 * (1.0 + 0.8 * np.sin(phase))
    period = 0.8 if chosen.heart_rate is None else 1.0 / chosen.heart_rate
    signal = AorticSignal(period=period, pressure=pressure, flow=flow)
    return ArterialTree(build_table(segments, subject="test tree"), signal, chosen, side=side)


def random_segments(seed, count):
    """A random binary tree of `count` inner segments with random walls, lengths and ends."""
    random = np.random.default_rng(seed)
    rows, open_ends, following = [], [0], 1
    while open_ends:
        parent = open_ends.pop(0)
        inner = following <= count
        rows.append(
            segment(
                following,
                parent,
                length=random.uniform(0.01, 0.4),
                radius=random.uniform(0.5e-3, 8e-3),
                resistance=10.0 ** random.uniform(8.0, 11.0),
                youngs_modulus=random.uniform(2e5, 2e6),
            )
        )
        if inner:
            open_ends += [following] * random.integers(1, 4)
        following += 1
    return rows


@pytest.fixture(scope="session")
def one_segment():
    return segment


@pytest.fixture(scope="session")
def tree_of():
    return small_tree


@pytest.fixture(scope="session")
def random_rows():
    return random_segments


@pytest.fixture(scope="session")
def tree() -> ArterialTree:
    """The paper's tree with the default parameters, left limb."""
    return build_tree(CirculationParameters())
