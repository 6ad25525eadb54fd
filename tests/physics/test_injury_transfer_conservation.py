"""Transfers between particles and grid keep mass, momentum and angular momentum."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.injury.materials import tissue_table
from vulnus.injury.solver import GRADIENT, STRAIN, MpmSolver

pytestmark = pytest.mark.physics


def strained_cloud(seed: int, precision: str, *, strain: float = 1e-3) -> MpmSolver:
    rng = np.random.default_rng(seed)
    n = 500
    solver = MpmSolver(
        materials=tissue_table(0.003), grid_spacing=0.003, lower=(-1.0,) * 3, upper=(1.0,) * 3,
        precision=precision,
    )  # fmt: skip
    solver.set_particles(
        rng.uniform(-0.015, 0.015, (n, 3)),
        volume=rng.uniform(0.5, 2.0, n) * 1e-9,
        material=rng.integers(1, 8, n).astype(np.uint8),
        velocity=rng.normal(0.0, 10.0, (n, 3)),
    )
    solver._native.set_values(GRADIENT, rng.normal(0.0, 1e3, (n, 9)))
    solver._native.set_values(STRAIN, rng.normal(0.0, strain, (n, 6)))
    return solver


def scales(solver: MpmSolver) -> dict[str, float]:
    """What the sums are made of: sizes to compare a difference with."""
    totals = solver.totals()
    speed = np.sqrt(2.0 * totals["kinetic_energy"] / totals["mass"])
    momentum = totals["mass"] * speed
    return {"mass": totals["mass"], "momentum": momentum, "angular_momentum": 0.02 * momentum}


def assert_same(before, after, scale, tolerance):
    for name, size in scale.items():
        difference = np.max(np.abs(np.subtract(before[name], after[name])))
        assert difference <= tolerance * size, name


@settings(derandomize=True, max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_scatter_and_gather_keep_mass_and_both_momenta(seed):
    """Equation: Chong2017 (1): without gravity, inner stress moves no momentum in or out.

    Round-off: 500 particles on some thousand nodes, so 1e-13 of the sum of magnitudes in float64.
    The stress is symmetric, so APIC's angular momentum is kept too.
    """
    solver = strained_cloud(seed, "float64")
    scale = scales(solver)
    before = solver.totals()
    solver._native.scatter_only(1e-7)
    assert_same(before, solver.totals(grid=True), scale, 1e-12)
    solver._native.gather_only(1e-7)
    assert_same(before, solver.totals(), scale, 1e-12)


def test_single_precision_keeps_them_to_its_own_rounding():
    solver = strained_cloud(3, "float32", strain=1e-5)
    scale = scales(solver)
    before = solver.totals()
    solver._native.scatter_only(1e-7)
    assert_same(before, solver.totals(grid=True), scale, 2e-5)
    solver._native.gather_only(1e-7)
    assert_same(before, solver.totals(), scale, 2e-5)


def test_an_affine_velocity_field_survives_the_round_trip():
    """APIC: a velocity field v = v0 + A x is reproduced exactly by scatter and gather."""
    rng = np.random.default_rng(0)
    solver = strained_cloud(5, "float64", strain=0.0)
    affine, constant = rng.normal(0.0, 100.0, (3, 3)), rng.normal(0.0, 5.0, 3)
    velocity = solver.position @ affine.T + constant
    solver._native.set_values(3, velocity)
    solver._native.set_values(GRADIENT, np.tile(affine.reshape(9), (500, 1)))
    solver._native.set_values(STRAIN, np.zeros((500, 6)))
    solver._native.scatter_only(1e-9)
    solver._native.gather_only(1e-9)
    assert np.allclose(solver.velocity, velocity, rtol=0.0, atol=1e-11)
    gradient = solver._native.values(GRADIENT, 9).reshape(-1, 3, 3)
    assert np.allclose(gradient, affine, rtol=0.0, atol=1e-8)


def test_gravity_adds_exactly_its_impulse():
    """Equation: Chong2017 (1): d(momentum)/dt = m g for a body that nothing touches."""
    rng = np.random.default_rng(7)
    gravity = (1.0, -2.0, -9.81)
    solver = MpmSolver(
        materials=tissue_table(0.003), grid_spacing=0.003, lower=(-1.0,) * 3, upper=(1.0,) * 3,
        gravity=gravity, precision="float64",
    )  # fmt: skip
    x = rng.uniform(-0.01, 0.01, (800, 3))
    solver.set_particles(x, volume=np.full(800, 1e-8), material=np.full(800, 2, np.uint8))
    solver.advance(until=2e-5)
    totals = solver.totals()
    expected = totals["mass"] * np.array(gravity) * 2e-5
    assert solver.steps > 10
    assert np.allclose(totals["momentum"], expected, rtol=1e-10, atol=0.0)
