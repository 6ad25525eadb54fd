"""A run ends when its cavity has collapsed, not before its blade is out, or as it was told."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import CavityHistory
from vulnus.injury import InjuryParameters
from vulnus.injury.shot.run_end import collapse_time, schedule


def history(volume, step=5e-4):
    values = np.asarray(volume, np.float64)
    return CavityHistory(time=step * np.arange(len(values)), volume=values)


def pulse(largest=3e-5, rest=0.0, width=8, count=40):
    """A cavity that opens and closes in 2 `width` frames of 0.5 ms, down to `rest`."""
    frames = np.arange(count)
    arch = np.where(frames < 2 * width, np.sin(np.pi * frames / (2 * width)), 0.0)
    return np.maximum(largest * arch, np.where(frames > width, rest, 0.0))


def test_frames_are_dense_in_the_first_phase_and_bounded_after_it():
    times = schedule(InjuryParameters()).times
    assert times[19] == pytest.approx(1e-3)
    assert times[-1] == 20e-3
    assert np.diff(times) == pytest.approx([5e-5] * 19 + [5e-4] * 38)
    paper = schedule(InjuryParameters(mode="paper"))
    assert (paper.earliest, paper.latest) == (1e-3, 1e-3)
    assert np.diff(paper.times) == pytest.approx([5e-5] * 19)
    short = schedule(InjuryParameters(duration=1.2e-4))
    assert short.times == pytest.approx([5e-5, 1e-4, 1.2e-4])
    assert short.earliest == short.latest == 1.2e-4


def test_no_run_ends_before_its_blade_is_out():
    for mode in ("full", "paper"):
        plan = schedule(InjuryParameters(mode=mode), thrust_end=31e-3)
        assert plan.latest >= plan.earliest >= 31e-3
        # Dense in the first millisecond alone: a thrust is slow.
        assert len(plan.times) == pytest.approx(20 + 62, abs=8)
    with pytest.raises(ScenarioError, match=r"is 15 ms, but the blade is out .* at 17\.22 ms"):
        schedule(InjuryParameters(duration=15e-3), thrust_end=17.22e-3)
    with pytest.raises(ScenarioError, match=r"Give at least 17\.24"):
        schedule(InjuryParameters(duration=15e-3), thrust_end=17.22e-3)
    assert schedule(InjuryParameters(duration=18e-3), thrust_end=17.22e-3).latest == 18e-3


def test_a_cavity_has_collapsed_at_a_tenth_of_its_largest_volume():
    """The arch is below a tenth from its last frame but one on: sin(15/16 pi) is 0.195."""
    assert collapse_time(history(pulse())) == pytest.approx(16 * 5e-4)
    assert collapse_time(history(pulse()[:16])) is None


def test_a_cavity_that_stays_open_has_collapsed_when_it_is_steady():
    """A third stays: it is reached in the 15th frame, and 3 ms, six frames, later it is steady."""
    found = collapse_time(history(pulse(rest=1e-5)))
    assert found == pytest.approx((15 + 6) * 5e-4)


def test_a_second_pulse_counts():
    volume = pulse()
    volume[25:30] = 1e-5
    assert collapse_time(history(volume)) == pytest.approx(30 * 5e-4)
    assert collapse_time(history(volume[:29])) is None


@pytest.mark.parametrize("period", [10e-3, 20e-3])
def test_the_turn_at_the_largest_volume_is_not_steady(period):
    time = 2.5e-4 * np.arange(200)
    volume = 2e-5 + 1e-5 * np.cos(2 * np.pi * time / period)
    assert collapse_time(CavityHistory(time, volume)) is None


def test_without_a_cavity_there_is_nothing_to_wait_for():
    assert collapse_time(history(np.zeros(20))) == 0.0
    assert collapse_time(history([])) is None


@settings(derandomize=True, max_examples=60, deadline=None)
@given(
    volume=st.lists(st.floats(0.0, 1e-3), min_size=1, max_size=50),
    factor=st.floats(1e-3, 1e3),
)
def test_the_time_does_not_depend_on_the_unit_of_volume(volume, factor):
    """Volumes on the threshold itself may fall to either side by rounding; they are left out."""
    small = np.round(np.asarray(volume), 5)
    near = np.abs(small[:, None] - 0.1 * small[None, :]) < 1e-12
    if near[small > 0].any():
        return
    assert (collapse_time(history(small)) is None) == (
        collapse_time(history(factor * small)) is None
    )


@settings(derandomize=True, max_examples=200, deadline=None)
@given(
    duration=st.none() | st.floats(1e-5, 0.2),
    phase_one=st.floats(0.0, 0.2),
    dense=st.floats(1e-5, 0.1),
    sparse=st.floats(1e-5, 0.1),
    thrust=st.floats(0.0, 0.1),
    mode=st.sampled_from(["full", "paper"]),
)
def test_frames_follow_one_another_to_the_end(*, duration, phase_one, dense, sparse, thrust, mode):
    parameters = InjuryParameters(
        mode=mode, duration=duration, phase_one=phase_one, frame_interval=dense,
        relaxation_frame_interval=sparse,
    )  # fmt: skip
    if duration is not None and duration < thrust:
        with pytest.raises(ScenarioError, match="the blade is out"):
            schedule(parameters, thrust)
        return
    plan = schedule(parameters, thrust)
    times = np.array([0.0, *plan.times])
    assert np.all(np.diff(times) > 0.0)
    assert np.all(np.diff(times) <= max(dense, sparse) * (1.0 + 1e-6))
    assert thrust <= plan.earliest <= plan.latest
    assert duration in (None, plan.latest)
