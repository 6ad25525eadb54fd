"""The flow of a beat as the solver receives it, and the instants at which the run stops."""

from __future__ import annotations

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


def test_beat_closes_on_its_first_sample():
    whole = beat([1.0, 3.0, 2.0, 5.0], start=4.0)
    assert whole.start == 4.0
    assert whole.end == pytest.approx(4.8)
    assert whole.at(4.8) == pytest.approx((1e4 + 1.0, 9e3 + 1.0, 1.0))
    assert whole.at(4.1) == pytest.approx((1e4 + 2.0, 9e3 + 2.0, 2.0))


@settings(max_examples=40, derandomize=True, deadline=None)
@given(
    flow=st.lists(st.floats(-1e-5, 1e-5), min_size=2, max_size=20),
    first=st.floats(0.0, 1.0),
    second=st.floats(0.0, 1.0),
)
def test_volume_is_the_integral_of_the_linear_flow(flow, first, second):
    whole = beat(flow, start=2.4)
    early, late = (2.4 + 0.8 * share for share in sorted((first, second)))
    # the mean of a linear flow between two instants is exact in its nodes' trapezia
    nodes = whole.time[(whole.time > early) & (whole.time < late)]
    points = np.concatenate(([early], nodes, [late]))
    values = np.interp(points, whole.time, whole.flow_injury)
    expected = np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(points))
    assert whole.volume(late) - whole.volume(early) == pytest.approx(expected, abs=1e-19)


def test_volume_of_the_whole_beat_is_the_mean_flow_times_the_period():
    flow = np.random.default_rng(3).normal(size=64)
    assert beat(flow).volume(0.8) == pytest.approx(0.8 * flow.mean(), abs=1e-14)


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
