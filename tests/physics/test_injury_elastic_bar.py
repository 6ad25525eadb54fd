"""Longitudinal vibration of an elastic bar against its closed form (PHYSICS.md M1, coarse)."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury.boundaries import HeldEnds
from vulnus.injury.materials import Material, material_table
from vulnus.injury.solver import MpmSolver

pytestmark = pytest.mark.physics

YOUNG, DENSITY, SPACING, CELLS = 1e7, 1000.0, 0.01, 24
# Poisson's ratio 0, so that the bar is one-dimensional: K = E/3, G = E/2.
ELASTIC = Material(density=DENSITY, bulk_modulus=YOUNG / 3.0, shear_modulus=YOUNG / 2.0)


def vibrating_bar() -> tuple[MpmSolver, np.ndarray, float]:
    """A bar along x, held at x <= 0, with the velocity of its first mode, 1 m/s at the tip."""
    length = CELLS * SPACING
    axis = (np.arange(2 * CELLS) + 0.5) * SPACING / 2.0
    side = (np.arange(4) + 0.5) * SPACING / 2.0
    x = np.stack(np.meshgrid(axis, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    solver = MpmSolver(
        materials=material_table([ELASTIC], SPACING), grid_spacing=SPACING, lower=(-1.0,) * 3,
        upper=(1.0,) * 3, courant_number=0.3, precision="float64",
        boundaries=[HeldEnds(axis=(1.0, 0.0, 0.0), lower=0.5 * SPACING, upper=1e3)],
    )  # fmt: skip
    velocity = np.zeros_like(x)
    velocity[:, 0] = np.sin(0.5 * np.pi * x[:, 0] / length)
    volume = np.full(len(x), (SPACING / 2.0) ** 3)
    solver.set_particles(x, volume=volume, material=np.zeros(len(x), np.uint8), velocity=velocity)
    return solver, x, length


def test_the_first_mode_has_the_period_of_the_wave_equation():
    """Equation: Chong2017 (1) with Hencky stress at small strain: omega = pi c / 2 L."""
    solver, x, length = vibrating_bar()
    speed = np.sqrt(YOUNG / DENSITY)
    period = 4.0 * length / speed
    tip = x[:, 0] > length - 0.6 * SPACING
    times, tips = [], []
    for sample in np.linspace(0.0, 1.3, 131)[1:] * period:
        solver.advance(until=sample)
        times.append(sample)
        tips.append(np.mean(solver.position[tip, 0] - x[tip, 0]))
    tips = np.array(tips)
    crossings = [
        np.interp(0.0, [tips[k], tips[k + 1]], [times[k], times[k + 1]])
        if tips[k] < tips[k + 1]
        else np.interp(0.0, [tips[k + 1], tips[k]], [times[k + 1], times[k]])
        for k in range(len(tips) - 1)
        if tips[k] * tips[k + 1] < 0
    ]
    # Zeros at T/2 and T. 2 %: the free end's node row carries half a cell of 24 cells; M1 asks
    # 1 % of a fine bar.
    assert crossings[0] == pytest.approx(0.5 * period, rel=0.02)
    assert crossings[1] == pytest.approx(period, rel=0.02)
    # Amplitude V0 / omega, and an APIC loss of less than 5 % in a period.
    amplitude = 2.0 * length / (np.pi * speed)
    assert np.max(tips) == pytest.approx(amplitude, rel=0.03)
    late = np.max(tips[100:])
    assert late > 0.95 * np.max(tips[:60])
