"""The native solver and its NumPy twin take the same steps."""

from __future__ import annotations

import numpy as np
import pytest
from reference import mpm_twin as twin

from vulnus.injury.materials import tissue_table
from vulnus.injury.solver import (
    DAMAGE,
    GRADIENT,
    NETWORK_STRAIN,
    OPENING,
    PLASTIC_STRAIN,
    STRAIN,
    MpmSolver,
)

pytestmark = pytest.mark.physics

GRAVITY = (0.0, 0.0, -9.81)
SPACING = 0.004


def random_body(seed: int):
    """300 particles of all tissues that fly into each other at some 300 m/s."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.011, 0.011, (300, 3))
    v = -8e3 * x * rng.uniform(0.5, 1.5, (300, 1)) + rng.normal(0.0, 300.0, (300, 3))
    material = rng.integers(1, 8, 300).astype(np.uint8)
    return x, v, material, rng.uniform(0.5, 1.5, 300) * 1e-8


def native_and_twin(seed: int, *, steps: int, dt: float, stress_sign: float = 1.0):
    x, v, material, volume = random_body(seed)
    table = tissue_table(SPACING)
    solver = MpmSolver(
        materials=table, grid_spacing=SPACING, lower=(-1.0,) * 3, upper=(1.0,) * 3,
        gravity=GRAVITY, precision="float64",
    )  # fmt: skip
    solver.set_particles(x, volume=volume, material=material, velocity=v)
    state = twin.at_rest(x, v)
    for k in range(steps):
        solver.advance(until=(k + 1) * dt)
        assert solver.steps == k + 1
        state = twin.step(
            state, volume=volume, m=twin.columns(table, material), dx=SPACING, dt=dt,
            gravity=np.array(GRAVITY), stress_sign=stress_sign,
        )  # fmt: skip
    return solver, state


def relative(a, b):
    return float(np.max(np.abs(a - b)) / np.max(np.abs(b)))


def native_b(solver, field=STRAIN):
    e = solver._native.values(field, 6)
    rows = e[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    return rows + np.eye(3)


def test_one_step_agrees_to_rounding():
    # 1e-12: sums of some 40 contributions of either sign, each with an error of 1e-16.
    solver, state = native_and_twin(1, steps=1, dt=2e-7)
    assert relative(solver.position, state.x) < 1e-12
    assert relative(solver.velocity, state.v) < 1e-12
    assert relative(solver._native.values(GRADIENT, 9).reshape(-1, 3, 3), state.c) < 1e-12
    assert relative(native_b(solver), state.b) < 1e-12
    assert relative(native_b(solver, NETWORK_STRAIN), state.network) < 1e-12


def test_plastic_steps_agree():
    """All return maps are at work; rounding grows by the stiffness, 1e-9 is far below any law."""
    solver, state = native_and_twin(2, steps=6, dt=3e-7)
    assert np.mean(state.alpha > 0) > 0.1
    assert np.any(state.opening > 0)
    assert np.any((state.damage > 0) & (state.damage < 1))
    assert relative(native_b(solver), state.b) < 1e-9
    assert relative(native_b(solver, NETWORK_STRAIN), state.network) < 1e-9
    assert relative(solver._native.values(DAMAGE, 1)[:, 0], state.damage) < 1e-9
    assert relative(solver._native.values(PLASTIC_STRAIN, 1)[:, 0], state.alpha) < 1e-9
    assert relative(solver._native.values(OPENING, 1)[:, 0], state.opening) < 1e-9
    assert relative(solver.velocity, state.v) < 1e-9


def test_the_comparison_can_fail():
    """With the sign of the stress turned round the twin must be seen to differ."""
    solver, state = native_and_twin(2, steps=3, dt=3e-7, stress_sign=-1.0)
    assert relative(solver.velocity, state.v) > 1e-3
