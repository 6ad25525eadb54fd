"""Waves in small trees by hand, and in random ones against one linear system per harmonic."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.circulation.terminals import terminal_admittance

ROUND_OFF = 1e-10  # a few hundred operations on numbers that cancel to a thousandth


@pytest.fixture(scope="module")
def bench():
    """The benchmark, whose peer is the reference twin."""
    path = Path(__file__).parents[3] / "benchmarks" / "bench_circulation.py"
    spec = importlib.util.spec_from_file_location("bench_circulation", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_single_tube_by_hand(tree_of, one_segment):
    resistance = 3e9
    tree = tree_of([one_segment(1, 0, length=0.3, resistance=resistance)], terminal_compliance=0.0)
    gamma, impedance = tree.lines.propagation[0], tree.lines.impedance[0]
    wave = gamma * 0.3
    inlet = impedance * (resistance * np.cosh(wave) + impedance * np.sinh(wave))
    inlet /= impedance * np.cosh(wave) + resistance * np.sinh(wave)
    pressure = tree.pressure_spectrum(1, 0.0)[1:]
    assert np.allclose(tree.flow_spectrum(1, 0.0)[1:], pressure / inlet, rtol=ROUND_OFF, atol=0)
    out = pressure / (np.cosh(wave) + impedance / resistance * np.sinh(wave))
    assert np.allclose(tree.pressure_spectrum(1, 0.3)[1:], out, rtol=ROUND_OFF, atol=1e-12)


def test_steady_flow_is_poiseuille_in_series_and_parallel(tree_of, one_segment):
    rows = [
        one_segment(1, 0, length=0.2, radius=3e-3),
        one_segment(2, 1, length=0.1, radius=2e-3, resistance=2e9),
        one_segment(3, 1, length=0.3, radius=1e-3, resistance=5e9),
    ]
    tree = tree_of(rows, venous_pressure=500.0)
    tube = [8.0 * 4e-3 * row.length / (np.pi * row.radius**4) for row in rows]
    left, right = tube[1] + 2e9, tube[2] + 5e9
    whole = tube[0] + 1.0 / (1.0 / left + 1.0 / right)
    assert tree.mean_flow(1) == pytest.approx((12e3 - 500.0) / whole, rel=1e-12)
    assert tree.mean_flow(2) / tree.mean_flow(3) == pytest.approx(right / left, rel=1e-12)
    drop = tree.pressure_spectrum(3, 0.0)[0] - tree.pressure_spectrum(3, 0.3)[0]
    assert drop.real == pytest.approx(tube[2] * tree.mean_flow(3), rel=1e-12)


def test_matched_end_reflects_nothing_and_mismatch_by_the_ratio(tree_of, one_segment):
    """A step in the wall reflects (Z2 - Z1)/(Z2 + Z1) of a wave; a continued tube nothing."""
    whole = tree_of([one_segment(1, 0, length=0.4, resistance=1e9)])
    cut = tree_of([one_segment(1, 0, length=0.15), one_segment(2, 1, length=0.25, resistance=1e9)])
    assert np.allclose(
        whole.pressure_spectrum(1, 0.2), cut.pressure_spectrum(2, 0.05), rtol=ROUND_OFF, atol=1e-9
    )
    stiff = tree_of(
        [
            one_segment(1, 0, length=0.2),
            # so long that no echo returns from its end: seen from the step it is its own Zc
            one_segment(2, 1, length=300.0, youngs_modulus=3.2e6, resistance=1e9),
        ],
        wall_phase=0.2,
    )
    z1, z2 = stiff.lines.impedance
    seen = z1 * stiff.solve().admittance_load[0]
    assert np.allclose((1.0 - seen) / (1.0 + seen), (z2 - z1) / (z2 + z1), rtol=1e-6, atol=0)


def test_long_lossy_line_stays_finite(tree_of, one_segment):
    tree = tree_of([one_segment(1, 0, length=1e4, radius=0.5e-3, resistance=1e10)])
    for position in (0.0, 1.0, 5e3, 1e4):
        assert np.all(np.isfinite(tree.pressure(1, position)))
    assert np.ptp(tree.pressure(1, 1e4)) < 1e-6


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**31), count=st.integers(0, 12))
def test_random_trees_agree_with_one_linear_system(tree_of, random_rows, bench, seed, count):
    tree = tree_of(random_rows(seed, count), venous_pressure=700.0)
    expected = bench.matrix_pressures(tree)
    state = tree.solve()
    got = np.column_stack((state.steady.pressure_out, state.pressure_out))
    # 1e-8: the twin's sparse system is the worse conditioned of the two (coth of short lines)
    assert np.max(np.abs(got - expected)) < 1e-8 * np.max(np.abs(expected))


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**31), count=st.integers(1, 15))
def test_flow_is_conserved_at_every_junction(tree_of, random_rows, seed, count):
    tree = tree_of(random_rows(seed, count))
    assert_junctions_conserve(tree)


def test_flow_is_conserved_at_every_junction_of_the_paper_tree(tree):
    assert_junctions_conserve(tree)


def assert_junctions_conserve(tree):
    """Round-off of the largest flow that meets at the junction."""
    table = tree.table
    for row in range(len(table.ids)):
        children = np.flatnonzero(table.parent_row == row)
        if len(children) == 0:
            continue
        arriving = tree.flow_spectrum(int(table.ids[row]), float(table.length[row]))
        leaving = [tree.flow_spectrum(int(table.ids[child]), 0.0) for child in children]
        largest = np.max(np.abs(np.vstack([arriving, *leaving])), axis=0)
        assert np.all(np.abs(arriving - np.sum(leaving, axis=0)) <= ROUND_OFF * largest)
        pressure = tree.pressure_spectrum(int(table.ids[row]), float(table.length[row]))
        for child in children:
            other = tree.pressure_spectrum(int(table.ids[child]), 0.0)
            assert np.allclose(pressure, other, rtol=ROUND_OFF, atol=0)


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=st.integers(0, 2**31), count=st.integers(0, 15))
def test_every_tree_is_passive(tree_of, random_rows, seed, count):
    """No place of a tree gives back more than it takes: Re Y >= 0 at every inlet and load."""
    tree = tree_of(random_rows(seed, count))
    state = tree.solve()
    assert np.all(state.admittance_in.real >= 0.0)
    assert np.all(state.admittance_load.real >= 0.0)
    assert np.all(state.steady.conductance_in > 0.0)


def test_flow_source_drives_its_flow(tree_of, one_segment):
    rows = [one_segment(1, 0), one_segment(2, 1, resistance=1e9), one_segment(3, 1, resistance=3e9)]
    tree = tree_of(rows, source="flow", venous_pressure=400.0)
    assert np.allclose(tree.flow(1, 0.0), tree.signal.flow, rtol=1e-10, atol=1e-16)


def test_signal_without_harmonics_beyond_its_own_is_kept(tree_of, one_segment):
    tree = tree_of([one_segment(1, 0, resistance=1e9)])
    assert np.allclose(tree.pressure(1, 0.0), tree.signal.pressure, rtol=1e-12, atol=0)


def test_beds_keep_the_table_resistance_to_the_mean(tree):
    slow = terminal_admittance(tree.table, np.array([1e-6]), tree.parameters)[:, 0]
    ends = np.isfinite(tree.table.terminal_resistance)
    assert np.allclose(1.0 / slow[ends].real, tree.table.terminal_resistance[ends], rtol=1e-6)
    assert np.all(slow[~ends] == 0.0)


def test_more_harmonics_than_one_block_agree(tree_of, random_rows):
    rows = random_rows(7, 5)
    few, many = tree_of(rows, harmonics=32), tree_of(rows, harmonics=300)
    assert np.allclose(
        few.solve().admittance_in, many.solve().admittance_in[:, :32], rtol=1e-12, atol=0
    )
