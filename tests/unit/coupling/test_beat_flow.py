"""The flow of a beat as the solver receives it, and the instants at which the run stops."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.circulation import BeatSignals
from vulnus.coupling.beat_flow import BeatFlow
from vulnus.coupling.running_mean import RunningMean
from vulnus.coupling.schedule import Schedule


def beat(flow, start=0.0, period=0.8):
    flow = np.asarray(flow, dtype=float)
    time = np.arange(len(flow)) * (period / len(flow))
    signals = BeatSignals(
        time=time,
        pressure_aorta=1e4 + flow,
        pressure_artery=9e3 + flow,
        pressure_injury=0.0 * flow,
        flow_injury=flow,
        period=period,
    )
    return BeatFlow.starting(start, signals)


FREE = {"pressure_outside": 9e3, "resistance": 1e30}
"""Nothing that could hold the flow back."""


def test_beat_closes_on_its_first_sample():
    whole = beat([1.0, 3.0, 2.0, 5.0], start=4.0)
    assert whole.start == 4.0
    assert whole.end == pytest.approx(4.8)
    assert whole.aorta_at(4.1) == pytest.approx(1e4 + 2.0)
    given = whole.between(4.1, 4.8, **FREE)
    assert np.allclose(given.time, [4.1, 4.2, 4.4, 4.6, 4.8])
    assert np.allclose(given.flow, [2.0, 3.0, 2.0, 5.0, 1.0])
    assert given.pressure_artery == pytest.approx(9e3 + 1.0)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(
    flow=st.lists(st.floats(-1e-5, 1e-5), min_size=2, max_size=20),
    cuts=st.lists(st.floats(0.0, 1.0), max_size=6),
)
def test_slices_add_up_to_the_beat(flow, cuts):
    whole = beat(flow, start=2.4)
    stops = [2.4, *sorted(2.4 + 0.8 * cut for cut in cuts), whole.end]
    slices = [whole.between(a, b, **FREE).volume for a, b in pairwise(stops)]
    # the mean of even samples of a closed cycle is its integral over the period
    assert np.sum(slices) == pytest.approx(0.8 * np.mean(flow), abs=1e-19)


def test_pressure_below_the_stumps_leaves_the_flow_alone():
    whole = beat([1e-6, 4e-6, 2e-6])  # about 9 kPa inside the stump
    free = whole.between(0.1, 0.5, **FREE)
    filling = whole.between(0.1, 0.5, pressure_outside=8.9e3, resistance=1e9)
    assert np.array_equal(free.flow, filling.flow)


def test_excess_pressure_holds_the_flow_back_through_the_resistance():
    whole = beat([4e-6, 4e-6])
    given = whole.between(0.0, 0.4, pressure_outside=9e3 + 1e3, resistance=1e9)
    assert np.allclose(given.flow, 4e-6 - (1e3 - 4e-6) / 1e9, rtol=1e-12)
    # the stump then has the pressure of the blood around it
    assert given.pressure_artery == pytest.approx(1e4)


@pytest.mark.parametrize(("outside", "left"), [(1e6, np.minimum), (-1e6, np.maximum)])
def test_flow_against_the_pressure_stops_at_zero(outside, left):
    whole = beat([4e-6, -2e-6, 1e-6])
    given = whole.between(0.0, 0.8, pressure_outside=outside, resistance=1e9)
    assert np.array_equal(given.flow, left([4e-6, -2e-6, 1e-6, 4e-6], 0.0))


@settings(max_examples=60, derandomize=True, deadline=None)
@given(
    duration=st.floats(0.01, 6.0),
    frame_interval=st.floats(0.01, 2.0),
    sample_interval=st.floats(0.01, 0.5),
    period=st.floats(0.3, 1.5),
)
def test_every_frame_sample_and_beat_is_met_once(duration, frame_interval, sample_interval, period):
    schedule = Schedule(duration, frame_interval, sample_interval, period)
    frames = samples = 1
    beats, stops = 0, [0.0]
    while True:
        stop = schedule.stop_after(frames=frames, samples=samples, beats=beats)
        stops.append(stop.time)
        assert stop.frame or stop.sample or stop.beat or stop.end
        if stop.frame:
            assert stop.time == frames * frame_interval
        frames += stop.frame
        samples += stop.sample
        if stop.end:
            break
        beats += stop.beat
    assert np.all(np.diff(stops) > 0.0)
    assert stops[-1] == pytest.approx(duration, abs=1e-9)
    assert frames == int(np.floor((duration + 1e-9) / frame_interval)) + 1
    assert beats == int(np.ceil((duration - 1e-9) / period)) - 1


def test_running_mean_weighs_by_time_and_starts_anew():
    mean = RunningMean()
    assert mean.take(7.0) == 7.0
    mean.add(1.0, 3.0)
    mean.add(5.0, 1.0)
    assert RunningMean.of(np.array(mean.parts)).take(0.0) == 2.0
    assert mean.take(0.0) == 2.0
    assert mean.take(7.0) == 7.0
