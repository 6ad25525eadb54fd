"""Whatever an experiment is made of: it runs, or it is refused; it never breaks the process."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import VulnusError
from vulnus.injury import MATERIALS, Ball, Block, Experiment, PointSensor, RigidBody, Rod, Sphere

lengths = st.sampled_from([0.0, -1e-2, 1e-3, 4e-3, 1e-2, np.nan]) | st.floats(2e-3, 2e-2)
numbers = st.sampled_from([0.0, np.nan, np.inf, -1e300]) | st.floats(-500.0, 500.0)
places = st.tuples(*[st.floats(-0.02, 0.02)] * 3)
solids = st.one_of(
    st.builds(lambda s, c: lambda: Block(size=s, centre=c), st.tuples(*[lengths] * 3), places),
    st.builds(lambda r, c: lambda: Ball(radius=r, centre=c), lengths, places),
    st.builds(lambda r, n, a: lambda: Rod(radius=r, length=n, axis=a), lengths, lengths, places),
)


@settings(deadline=None, derandomize=True, max_examples=60)
@given(
    parts=st.lists(st.tuples(solids, st.sampled_from([*MATERIALS, "butter"])), max_size=3),
    velocity=st.tuples(numbers, st.floats(-50.0, 50.0), st.just(0.0)),
    spacing=st.sampled_from([2e-3, 3e-3, -1.0, np.nan]),
    ball=st.tuples(lengths, places, numbers, lengths),
    interval=numbers,
    arrangement=st.sampled_from(["lattice", "poisson"]),
)
def test_anything_runs_or_is_refused(  # noqa: PLR0917  hypothesis gives them by name
    parts, velocity, spacing, ball, interval, arrangement
) -> None:
    radius, place, speed, mass = ball
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            experiment = Experiment(grid_spacing=spacing)
            for make, material in parts:
                experiment.add_body(
                    make(), material=material, velocity=velocity, arrangement=arrangement
                )
            experiment.add_rigid_body(
                RigidBody(
                    shape=Sphere(radius), centre=place, velocity=(speed, 0, 0), mass=mass,
                    motion="dynamic",
                )
            )  # fmt: skip
            experiment.add_sensor(PointSensor(position=place))
            result = experiment.run(until=1e-6, sample_interval=abs(interval) * 1e-8)
    except VulnusError:
        return
    assert np.isfinite(result.final.position).all()
    assert result.time[-1] == pytest.approx(1e-6)
