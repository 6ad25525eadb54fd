"""Womersley's functions and the two-port of one line, against Bessel functions and limits."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.circulation import CirculationParameters
from vulnus.circulation.source_path import SourceEquation, through_line
from vulnus.circulation.womersley import (
    inertia_factor,
    inverse_root_factor,
    line_constants,
    poiseuille_resistance,
    wave_speed,
)

I_TO_THREE_HALVES = np.exp(0.75j * np.pi)


def test_inertia_factor_is_one_minus_bessel_ratio():
    from scipy.special import jv

    alpha = np.linspace(0.5, 25.0, 60)
    z = I_TO_THREE_HALVES * alpha
    printed = 1.0 - 2.0 * jv(1, z) / (z * jv(0, z))
    # 1e-12: the printed form loses digits to cancellation at the small end
    assert np.allclose(inertia_factor(alpha), printed, rtol=1e-12, atol=0)


def test_slow_flow_is_viscous():
    alpha = np.array([1e-4, 1e-3, 0.05])
    # the next term of the series is -i α⁴ i/48, i.e. α²/6 relative
    assert np.allclose(inertia_factor(alpha), 0.125j * alpha**2, rtol=alpha**2 / 5.0, atol=0)


def test_fast_flow_is_inertial():
    alpha = np.array([50.0, 200.0, 1000.0])
    # 1 - 2/(α √i) + O(1/α²)
    expected = 1.0 - 2.0 * np.exp(-0.25j * np.pi) / alpha
    assert np.all(np.abs(inertia_factor(alpha) - expected) < 3.0 / alpha**2)


def test_table_agrees_with_bessel_functions():
    alpha = np.geomspace(1e-4, 1999.0, 5000)
    product = inverse_root_factor(alpha) * np.sqrt(inertia_factor(alpha))
    # 1e-12: error of a cubic Hermite table with step 9e-4 of a function of order one
    assert np.max(np.abs(product - 1.0)) < 1e-12


def test_table_continues_beyond_its_end():
    alpha = np.array([1999.0, 2001.0, 1e4])
    product = inverse_root_factor(alpha) * np.sqrt(inertia_factor(alpha))
    assert np.max(np.abs(product - 1.0)) < 1e-6  # the next term is of order 1/α²


def test_line_tends_to_poiseuille_at_low_frequency(tree_of, one_segment):
    tree = tree_of([one_segment(1, 0, resistance=1e9)])
    lines = line_constants(tree.table, np.array([1e-5]), CirculationParameters(wall_phase=0.0))
    series = lines.propagation[0, 0] * lines.impedance[0, 0] * tree.table.length[0]
    expected = poiseuille_resistance(tree.table.length, tree.table.radius, 4e-3)[0]
    # the inertial part of the series impedance is ρ ω L/(πR²) 4/3, 1e-5 of the viscous one here
    assert series.real == pytest.approx(expected, rel=1e-6)
    assert abs(series.imag) < 1e-4 * expected


def test_line_tends_to_lossless_waves_at_high_frequency(tree_of, one_segment):
    tree = tree_of([one_segment(1, 0, resistance=1e9)])
    parameters = CirculationParameters(wall_phase=0.0)
    omega = np.array([1e7])  # α = 3255 in this tube
    lines = line_constants(tree.table, omega, parameters)
    speed = wave_speed(tree.table, density=parameters.density, poisson_ratio=0.5)[0]
    area = np.pi * tree.table.radius[0] ** 2
    # 1e-3: the first correction is 1/α
    assert lines.impedance[0, 0] == pytest.approx(parameters.density * speed / area, rel=1e-3)
    assert lines.propagation[0, 0].imag == pytest.approx(omega[0] / speed, rel=1e-3)


def test_moens_korteweg_speed_of_the_tibial_arteries(tree):
    speed = wave_speed(tree.table, density=1060.0, poisson_ratio=0.5)
    # 17.5 and 14.3 m/s of the table in CIRCULATION.md 1.3, given to three digits
    for name, expected in (("left anterior tibial 1", 17.5), ("left anterior tibial 2", 14.3)):
        row = tree.table.row(tree.table.id_of[name])
        assert speed[row] == pytest.approx(expected, rel=0.01)


def test_wall_damps_waves_and_never_feeds_them(tree):
    lines = tree.lines
    assert np.all(lines.propagation.real > 0.0)
    assert np.all(lines.impedance.real > 0.0)


def test_two_port_is_reciprocal(tree):
    """AD - BC = 1; each row of the two-port here is divided by e^(γL)."""
    row, length = 20, float(tree.table.length[20])
    gamma = tree.lines.propagation[row]
    line = {
        "propagation": gamma,
        "impedance": tree.lines.impedance[row],
        "resistance": float(tree.lines.resistance[row]),
        "length": length,
    }
    one = np.ones(len(gamma) + 1, dtype=complex)
    zero = 0.0 * one
    pressure = through_line(SourceEquation(a=one, b=zero, c=one), **line)
    flow = through_line(SourceEquation(a=zero, b=one, c=one), **line)
    determinant = pressure.a * flow.b - pressure.b * flow.a
    scale = np.append(1.0, np.exp(-2.0 * gamma * length))
    assert np.allclose(determinant, scale, rtol=1e-12, atol=1e-15)
