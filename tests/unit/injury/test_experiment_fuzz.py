"""Whatever an experiment is made of: it runs, or it is refused; it never breaks the process."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import VulnusError
from vulnus.injury import (
    MATERIALS,
    Ball,
    Block,
    Experiment,
    ExperimentResult,
    PointSensor,
    RigidBody,
    Rod,
    Sphere,
)

EXAMPLES = 60


def mostly(good: st.SearchStrategy, *bad: object) -> st.SearchStrategy:
    """Twenty-nine good values to one of the bad ones."""
    return st.integers(0, 29).flatmap(lambda n: st.sampled_from(bad) if n == 0 else good)


lengths = mostly(st.floats(4e-3, 1.5e-2), 0.0, -1e-2, 1e-3, np.nan)
numbers = mostly(st.floats(-100.0, 100.0), np.nan, np.inf, -1e300)
solids = st.one_of(
    st.builds(lambda x, y, z: lambda: Block(size=(x, y, z)), lengths, lengths, lengths),
    st.builds(lambda r: lambda: Ball(radius=r), lengths),
    st.builds(lambda r, n: lambda: Rod(radius=r, length=n, axis=(1.0, 1.0, 0.0)), lengths, lengths),
)
parts = st.tuples(solids, mostly(st.sampled_from(sorted(MATERIALS)), "butter"))


def experiment_of(case) -> ExperimentResult:
    """Bodies beside one another, a ball somewhere, a sensor in the first body."""
    experiment = Experiment(grid_spacing=case["spacing"])
    for index, (make, material) in enumerate(case["parts"]):
        experiment.add_body(
            make().moved((case["gap"] * index, 0.0, 0.0)),
            material=material,
            velocity=case["velocity"],
            arrangement=case["arrangement"],
        )
    ball = RigidBody(
        shape=Sphere(case["radius"]), centre=case["place"], velocity=(case["speed"], 0, 0),
        mass=case["mass"], motion="dynamic",
    )  # fmt: skip
    experiment.add_rigid_body(ball)
    experiment.add_sensor(PointSensor(position=(0.0, 0.0, 0.0)))
    return experiment.run(until=4e-7, sample_interval=case["interval"])


cases = st.fixed_dictionaries(
    {
        "parts": st.lists(parts, min_size=0, max_size=2),
        "gap": mostly(st.just(0.04), 0.01),
        "velocity": st.tuples(numbers, st.floats(-50.0, 50.0), st.just(0.0)),
        "spacing": mostly(st.sampled_from([1.8e-3, 2e-3]), -1.0, np.nan, 2e-2),
        "radius": lengths,
        "place": mostly(st.tuples(*[st.floats(0.05, 0.1)] * 3), (0.0, 0.0, 0.0)),
        "speed": numbers,
        "mass": mostly(st.floats(1e-4, 1e-2), 0.0, np.nan),
        "interval": mostly(st.floats(1e-7, 1e-6), 0.0, np.nan),
        "arrangement": st.sampled_from(["lattice", "poisson"]),
    }
)


def test_anything_runs_or_is_refused() -> None:
    ran = []

    @settings(deadline=None, derandomize=True, max_examples=EXAMPLES)
    @given(case=cases)
    def attempt(case) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            try:
                result = experiment_of(case)
            except VulnusError:
                return
        ran.append(case)
        assert np.isfinite(result.final.position).all()
        assert result.time[-1] == pytest.approx(4e-7)

    attempt()
    assert 3 <= len(ran) < EXAMPLES  # both outcomes are met
