"""The cut artery's port: Thevenin's source, exit loss, reversal, and a dense Newton twin."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.circulation import CirculationParameters, build_tree
from vulnus.circulation.aortic_signal import signal_of
from vulnus.circulation.injury_branch import InjuryPort
from vulnus.core.errors import CirculationError

SETTLED = 1e-8  # the port iterates its flow to 1e-10 of the largest


@pytest.fixture(scope="module")
def port(tree) -> InjuryPort:
    return tree.injury_port(*tree.locate("anterior_tibial", 0.5))


@pytest.fixture(scope="module")
def linear_port(tree) -> InjuryPort:
    place = tree.locate("anterior_tibial", 0.5)
    return tree.injury_port(*place, exit_loss_coefficient=0.0)


def newton_flow(port, pressure_injury):
    """The same flow by Newton's method on the samples with the impedance as a dense matrix."""
    samples = len(port.pressure_aorta)
    unit = np.zeros(samples)
    unit[0] = 1.0
    kernel = np.fft.irfft(np.fft.rfft(unit) * (port.impedance + port.branch_resistance), samples)
    circulant = np.array([np.roll(kernel, k) for k in range(samples)]).T
    driving = signal_of(port.open_pressure) - pressure_injury
    flow = np.zeros(samples)
    for _ in range(50):
        residual = circulant @ flow + port.loss * flow * np.abs(flow) - driving
        step = np.linalg.solve(circulant + np.diag(2.0 * port.loss * np.abs(flow)), residual)
        flow = flow - step
        if np.max(np.abs(step)) < 1e-13 * np.max(np.abs(flow)):
            return flow
    raise AssertionError("the twin did not converge")


@pytest.mark.parametrize("pressure", [0.0, 4e3, 1.2e4, 2e4])
def test_flow_is_newtons(port, pressure):
    beat = port.bleed(pressure)
    expected = newton_flow(port, pressure)
    assert np.allclose(beat.flow_injury, expected, rtol=0, atol=SETTLED * np.abs(expected).max())


@pytest.mark.parametrize("place", [("popliteal", 0.0), ("posterior_tibial", 0.1)])
def test_flow_of_a_wide_artery_is_newtons(tree, place):
    wide = tree.injury_port(*tree.locate(*place), lumen_radius=0.8e-3)
    expected = newton_flow(wide, 0.0)
    assert np.allclose(
        wide.bleed(0.0).flow_injury, expected, rtol=0, atol=SETTLED * np.abs(expected).max()
    )


def test_beat_obeys_the_law_of_the_branch(port):
    beat = port.bleed(2e3)
    loss = port.loss * beat.flow_injury * np.abs(beat.flow_injury)
    across = beat.pressure_artery - beat.pressure_injury
    assert np.allclose(across, loss, rtol=0, atol=1e-6 * np.max(np.abs(across)))


def test_exit_loss_is_k_times_the_dynamic_head(tree):
    port = tree.injury_port(85, 0.075, lumen_radius=1e-3, exit_loss_coefficient=1.5)
    speed = 2.0
    flow = np.pi * 1e-6 * speed
    assert port.loss * flow**2 == pytest.approx(1.5 * 0.5 * 1060.0 * speed**2, rel=1e-12)


def test_linear_port_superposes(linear_port):
    first = linear_port.bleed(1000.0).flow_injury
    none = linear_port.bleed(0.0).flow_injury
    thrice = linear_port.bleed(3000.0).flow_injury
    assert np.allclose(thrice - none, 3.0 * (first - none), rtol=0, atol=1e-14)
    assert np.mean(none - first) == pytest.approx(1000.0 / linear_port.impedance[0].real, rel=1e-9)


def test_open_port_has_the_open_pressure_and_no_flow(port):
    still = signal_of(port.open_pressure)
    beat = port.bleed(still)
    assert np.max(np.abs(beat.flow_injury)) < 1e-15
    assert np.allclose(beat.pressure_artery, still, rtol=1e-12, atol=0)


def test_pressure_above_the_artery_drives_blood_back(port):
    assert np.all(port.bleed(0.0).flow_injury > 0.0)
    assert np.all(port.bleed(3e4).flow_injury < 0.0)
    mixed = port.bleed(float(port.open_pressure[0].real)).flow_injury
    assert mixed.min() < 0.0 < mixed.max()


@settings(max_examples=25, derandomize=True, deadline=None)
@given(lower=st.floats(-5e3, 4e4), rise=st.floats(1.0, 2e4))
def test_mean_flow_falls_as_the_wound_fills(port, lower, rise):
    """dQ/dp < 0 and nothing is ever not a number."""
    before, after = port.bleed(lower), port.bleed(lower + rise)
    assert np.all(np.isfinite(before.flow_injury))
    assert after.mean_flow < before.mean_flow


@settings(max_examples=15, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**31), count=st.integers(0, 10), place=st.floats(0.0, 1.0))
def test_port_of_any_place_is_passive_and_bleeds(tree_of, random_rows, seed, count, place):
    rows = random_rows(seed, count)
    for mode in ("transection", "shunt"):
        tree = tree_of(rows, injury_mode=mode)
        row = seed % len(rows)
        segment = int(tree.table.ids[row])
        # not at the root's inlet: an ideal pressure source has no impedance there
        position = max(place, 0.05) * float(tree.table.length[row])
        port = tree.injury_port(segment, position)
        assert np.all(port.impedance.real >= -1e-9 * np.abs(port.impedance))
        beat = port.bleed(500.0)
        assert np.all(np.isfinite(beat.flow_injury))


def test_open_pressure_of_a_shunt_is_the_uninjured_pressure(tree):
    shunt = build_tree(CirculationParameters(injury_mode="shunt"))
    for artery, fraction in (("anterior_tibial", 0.5), ("popliteal", 0.3), ("popliteal", 1.0)):
        segment, position = shunt.locate(artery, fraction)
        port = shunt.injury_port(segment, position)
        expected = tree.pressure(segment, position)
        assert np.allclose(signal_of(port.open_pressure), expected, rtol=1e-10, atol=0)


def test_transection_at_an_end_of_the_tree_leaves_nothing_behind(tree):
    """Behind the last segment both modes differ by the bed alone."""
    segment = tree.table.id_of["left anterior tibial 3"]
    cut = tree.injury_port(segment, 0.15)
    shunted = build_tree(CirculationParameters(injury_mode="shunt")).injury_port(segment, 0.15)
    bed = tree.table.terminal_resistance[tree.table.row(segment)]
    z = cut.impedance[0].real
    assert shunted.impedance[0].real == pytest.approx(z * bed / (z + bed), rel=1e-12)


def test_impedance_is_poiseuilles_resistance_of_the_way_from_the_heart(tree_of, one_segment):
    rows = [
        one_segment(1, 0, length=0.2, radius=3e-3),
        one_segment(2, 1, length=0.3, radius=1e-3, resistance=5e9),
    ]
    tree = tree_of(rows)
    port = tree.injury_port(2, 0.1)
    tube = [8.0 * 4e-3 * 0.2 / (np.pi * 3e-3**4), 8.0 * 4e-3 * 0.1 / (np.pi * 1e-3**4)]
    assert port.impedance[0].real == pytest.approx(sum(tube), rel=1e-12)
    assert port.open_pressure[0].real == pytest.approx(12e3, rel=1e-12)


def test_wound_pressure_may_be_a_waveform(port):
    wave = 3e3 + 1e3 * np.sin(2.0 * np.pi * port.time / port.period)
    beat = port.bleed(wave)
    assert np.allclose(beat.flow_injury, newton_flow(port, wave), rtol=0, atol=1e-13)
    assert np.array_equal(beat.pressure_injury, wave)


@pytest.mark.parametrize("pressure", [np.nan, np.inf, np.zeros(3), np.zeros((2, 256))])
def test_wound_pressure_that_is_no_beat_is_refused(port, pressure):
    with pytest.raises(CirculationError, match="256 samples"):
        port.bleed(pressure)


@pytest.mark.parametrize("radius", [0.0, -1e-3, np.nan])
def test_lumen_must_be_positive(tree, radius):
    with pytest.raises(CirculationError, match="lumen_radius"):
        tree.injury_port(85, 0.05, lumen_radius=radius)


def test_injury_of_an_ideal_source_is_refused(tree_of, one_segment):
    flow_driven = tree_of([one_segment(1, 0, resistance=1e9)], source="flow")
    with pytest.raises(CirculationError, match="source"):
        flow_driven.injury_port(1, 0.05)


def test_heart_rate_stretches_the_beat():
    period = build_tree(CirculationParameters()).period
    fast = build_tree(CirculationParameters(heart_rate=2.0))
    assert fast.period == 0.5
    assert period == pytest.approx(0.8288, abs=1e-4)
    assert np.allclose(
        fast.pressure_aorta(), build_tree(CirculationParameters()).pressure_aorta(), rtol=1e-12
    )
    port = fast.injury_port(*fast.locate("anterior_tibial", 0.5))
    assert port.bleed(0.0).period == 0.5
    # the mean hardly depends on the rate: it is set by resistances and the mean pressure
    slow = build_tree(CirculationParameters(heart_rate=1.0))
    mean = slow.injury_port(*slow.locate("anterior_tibial", 0.5)).bleed(0.0).mean_flow
    assert port.bleed(0.0).mean_flow == pytest.approx(mean, rel=0.02)


def test_aortic_signal_is_scaled_to_mean_and_pulse():
    parameters = CirculationParameters(aortic_mean_pressure=14e3, aortic_pulse_pressure=8e3)
    pressure = build_tree(parameters).pressure_aorta()
    assert np.mean(pressure) == pytest.approx(14e3, rel=1e-12)
    assert np.ptp(pressure) == pytest.approx(8e3, rel=1e-12)


def test_same_bits_every_time():
    flows = []
    for _ in range(2):
        tree = build_tree(dataclasses.replace(CirculationParameters()))
        port = tree.injury_port(*tree.locate("posterior_tibial", 0.4))
        flows.append(port.bleed(1234.5).flow_injury)
    assert np.array_equal(*flows)
