"""The exchange of flow and pressure once per beat, its ledger, its frames and its resumption."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import ScenarioError
from vulnus.coupling import CouplingParameters

COMPLIANCE = 1e-6 / 133.322387415  # [m³/Pa], 1 ml/mmHg: the low end of PHYSICS.md 4.5
LEAK = 1e9  # [Pa s/m³], a drain comparable with the artery's own resistance
ROUND_OFF = 1e-12  # of volumes that the fake solver adds up in another order than the ledger


def parameters(**changed):
    default = {"duration": 2.0, "frame_interval": 0.1, "sample_interval": 0.02}
    return CouplingParameters(**(default | changed))


def test_ledger_balances_and_equals_the_integral_of_the_flow(run_bleeding, pocket):
    solver = pocket(COMPLIANCE, LEAK)
    outcome, _ = run_bleeding(solver, parameters(sample_interval=0.001))
    ledger, waves = outcome.ledger, outcome.waveforms
    # the fake takes each slice's midpoint, exact for a linear flow
    assert ledger.volume_error_fraction < ROUND_OFF * len(ledger.time)
    assert ledger.injected[-1] == pytest.approx(solver.injected, rel=1e-12)
    slices = 0.5 * (waves.flow_injury[1:] + waves.flow_injury[:-1]) * np.diff(waves.time)
    # trapezia over 1 ms rows; the flow jumps at an exchange within one row
    assert np.sum(slices) == pytest.approx(ledger.injected[-1], rel=2e-3)


@pytest.mark.parametrize(("duration", "beats"), [(2.0, 2), (0.5, 1)])
def test_mean_flows_are_those_of_the_whole_beats(run_bleeding, pocket, duration, beats):
    outcome, _ = run_bleeding(pocket(COMPLIANCE, LEAK), parameters(duration=duration))
    assert len(outcome.mean_flow_per_beat) == beats  # 2 s hold two beats of 0.829 s and a part
    ledger = outcome.ledger
    span = min(outcome.period, duration)
    injected = np.interp(span * np.arange(1, beats + 1), ledger.time, ledger.injected)
    # the ledger's samples are 1 ms apart, so its volume at a beat's end is interpolated
    assert outcome.mean_flow_per_beat * span == pytest.approx(
        np.diff(injected, prepend=0.0), rel=1e-4
    )


def test_frames_and_samples_lie_on_exact_multiples(run_bleeding, pocket):
    outcome, frames = run_bleeding(
        pocket(COMPLIANCE), parameters(duration=1.05, frame_interval=0.07, sample_interval=0.035)
    )
    assert [frame.index for frame in frames] == list(range(16))
    assert [frame.time for frame in frames] == [0.07 * k for k in range(16)]
    assert np.allclose(outcome.waveforms.time, 0.035 * np.arange(31), rtol=0, atol=1e-9)


@pytest.mark.parametrize("duration", [0.013, 0.4, 0.8288, 1.0])
def test_any_duration_ends_exactly_there(run_bleeding, pocket, duration):
    outcome, frames = run_bleeding(pocket(COMPLIANCE), parameters(duration=duration))
    assert outcome.ledger.time[-1] == pytest.approx(duration, abs=1e-9)
    assert np.all(np.diff(outcome.ledger.time) > 0)
    assert np.all(np.isfinite(outcome.mean_flow_per_beat))
    assert len(frames) == int(np.floor(duration / 0.1 + 1e-9)) + 1


def test_closed_pocket_stops_at_the_mean_arterial_pressure(run_bleeding, pocket, tibial_port):
    """S23 of PHYSICS.md: a pocket without a way out fills until nothing more flows."""
    solver = pocket(0.3 * COMPLIANCE)  # filled with a time constant of 5 s
    duration = 72 * tibial_port.period
    outcome, _ = run_bleeding(solver, parameters(duration=duration, frame_interval=1.0))
    open_pressure = tibial_port.open_pressure[0].real
    late = outcome.waveforms.time > duration - outcome.period
    assert abs(outcome.mean_flow_per_beat[-1]) < 1e-3 * outcome.mean_flow_per_beat[0]
    # 1 %: the mean of Q|Q| over a pulsing beat is not exactly that of zero mean flow
    assert np.mean(outcome.waveforms.pressure_injury[late]) == pytest.approx(
        open_pressure, rel=0.01
    )


def test_stiff_pocket_is_not_filled_beyond_the_arterys_pressure(run_bleeding, pocket, tibial_port):
    """A pocket so stiff that it would be full within a tenth of a beat.

    Exchanged once per beat alone, it would take in a whole beat's 5 ml: 1500 mmHg.
    """
    solver = pocket(0.003 * COMPLIANCE)
    outcome, _ = run_bleeding(
        solver, parameters(duration=4 * tibial_port.period, sample_interval=0.005)
    )
    systolic = np.max(np.fft.irfft(tibial_port.open_pressure * 256, 256))
    assert np.max(outcome.waveforms.pressure_injury) < 1.1 * systolic
    assert np.max(outcome.waveforms.pressure_injury) > tibial_port.open_pressure[0].real
    assert outcome.ledger.volume_error_fraction < 1e-9


def test_pressure_of_a_filling_pocket_lowers_each_beat_below_the_last(run_bleeding, pocket):
    outcome, _ = run_bleeding(pocket(COMPLIANCE), parameters(duration=5.0))
    assert np.all(np.diff(outcome.mean_flow_per_beat[:-1]) < 0.0)


def test_first_beat_bleeds_against_the_initial_pressure(run_bleeding, pocket, tibial_port):
    outcome, _ = run_bleeding(pocket(COMPLIANCE), parameters(initial_pressure=3000.0))
    expected = tibial_port.bleed(3000.0).mean_flow
    assert outcome.mean_flow_per_beat[0] == pytest.approx(expected, rel=1e-12)


def test_relaxation_scales_the_exchanged_pressure(run_bleeding, pocket, tibial_port):
    solver = pocket(COMPLIANCE)
    period = tibial_port.period
    quick, _ = run_bleeding(solver, parameters(duration=2 * period, relaxation=1.0))
    held = quick.waveforms.time <= period + 1e-9
    times, pressures = quick.waveforms.time[held], quick.waveforms.pressure_injury[held]
    weights = np.diff(times)  # rows carry the mean since the row before
    measured = np.dot(pressures[1:], weights) / np.sum(weights)
    expected = tibial_port.bleed(measured).mean_flow
    # 1 %: the beat does not end on a row
    assert quick.mean_flow_per_beat[1] == pytest.approx(expected, rel=0.01)
    slow, _ = run_bleeding(pocket(COMPLIANCE), parameters(duration=2 * period, relaxation=0.5))
    half = tibial_port.bleed(0.5 * measured).mean_flow
    assert slow.mean_flow_per_beat[1] == pytest.approx(half, rel=0.01)


@pytest.mark.parametrize("interrupted_at", [0.05, 0.83, 1.33])
def test_resumed_run_has_the_same_bits(run_bleeding, pocket, memory_checkpoint, interrupted_at):
    straight, frames = run_bleeding(pocket(COMPLIANCE, LEAK), parameters())
    checkpoint = memory_checkpoint(every=3)
    solver = pocket(COMPLIANCE, LEAK)
    solver.fail_after = interrupted_at
    with pytest.raises(KeyboardInterrupt):
        run_bleeding(solver, parameters(), checkpoint=checkpoint)
    resumed, late = run_bleeding(pocket(COMPLIANCE, LEAK), parameters(), checkpoint=checkpoint)
    for name in ("time", "pressure_aorta", "pressure_artery", "pressure_injury", "flow_injury"):
        assert np.array_equal(getattr(resumed.waveforms, name), getattr(straight.waveforms, name))
    for name in ("time", "injected", "in_limb", "out_of_limb", "removed", "pending"):
        assert np.array_equal(getattr(resumed.ledger, name), getattr(straight.ledger, name))
    assert np.array_equal(resumed.mean_flow_per_beat, straight.mean_flow_per_beat)
    assert resumed.steps == straight.steps
    for frame in late:
        assert frame.time == frames[frame.index].time
        assert frame.point_data == frames[frame.index].point_data


def test_resuming_a_finished_run_changes_nothing(run_bleeding, pocket, memory_checkpoint):
    checkpoint = memory_checkpoint()
    first, _ = run_bleeding(pocket(COMPLIANCE), parameters(), checkpoint=checkpoint)
    again, frames = run_bleeding(pocket(COMPLIANCE), parameters(), checkpoint=checkpoint)
    assert np.array_equal(first.ledger.injected, again.ledger.injected)
    assert frames == []


def test_interrupt_passes_through(run_bleeding, pocket):
    solver = pocket(COMPLIANCE)
    solver.fail_after = 0.5
    with pytest.raises(KeyboardInterrupt):
        run_bleeding(solver, parameters())


def test_progress_counts_simulated_seconds(run_bleeding, pocket):
    class Bar:
        calls: list

        def __init__(self):
            self.calls = []

        def begin(self, stage, total, unit):
            self.calls.append((stage, total, unit))

        def update(self, completed, note=""):
            self.calls.append((completed, note))

        def end(self):
            self.calls.append("end")

    bar = Bar()
    run_bleeding(pocket(COMPLIANCE), parameters(duration=0.2), progress=bar)
    assert bar.calls[0] == ("bleeding", 0.2, "s")
    assert bar.calls[-1] == "end"
    assert bar.calls[-2][0] == pytest.approx(0.2)
    assert "ml" in bar.calls[-2][1]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("duration", 0.0),
        ("duration", float("nan")),
        ("frame_interval", -0.1),
        ("sample_interval", 0.0),
        ("relaxation", 0.0),
        ("relaxation", 1.5),
        ("initial_pressure", float("inf")),
    ],
)
def test_values_outside_their_range_are_refused(run_bleeding, pocket, name, value):
    with pytest.raises(ScenarioError, match=name):
        run_bleeding(pocket(COMPLIANCE), parameters(**{name: value}))
