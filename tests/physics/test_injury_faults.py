"""Trouble in a step ends the run with the particle that had it."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import ScenarioError, UnstableStepError
from vulnus.injury.materials import tissue_table
from vulnus.injury.solver import GRADIENT, STRAIN, MpmSolver

pytestmark = pytest.mark.physics


def block(**changes) -> MpmSolver:
    settings = {"lower": (-0.2,) * 3, "upper": (0.2,) * 3, "grid_spacing": 0.004, **changes}
    solver = MpmSolver(materials=tissue_table(0.004), **settings)
    edge = np.arange(-0.009, 0.01, 0.002)
    x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    velocity = np.zeros_like(x)
    solver.set_particles(
        x, volume=np.full(len(x), 8e-9), material=np.full(len(x), 2, np.uint8), velocity=velocity
    )
    return solver


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_nan_is_reported_with_its_particle(precision):
    solver = block(precision=precision)
    velocity = np.zeros((1000, 3))
    velocity[[431, 777], 1] = np.nan
    solver._native.set_values(3, velocity)
    with pytest.raises(UnstableStepError, match="not finite") as error:
        solver.advance(until=1e-5)
    assert "at particle 431," in str(error.value)  # the lowest of the two, not its neighbours
    assert error.value.exit_code == 7


def test_a_value_that_overflows_is_named():
    solver = MpmSolver(
        materials=tissue_table(0.004), grid_spacing=0.004, lower=(-1.0,) * 3, upper=(1.0,) * 3
    )
    x = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    velocity = np.zeros((3, 3))
    velocity[1, 2] = np.inf
    solver.set_particles(
        x, volume=np.full(3, 8e-9), material=np.full(3, 2, np.uint8), velocity=velocity
    )
    with pytest.raises(UnstableStepError, match="particle 1,"):
        solver.advance(until=1e-6)


def test_an_inverted_particle_is_named():
    """A velocity gradient that turns a particle inside out within one step."""
    solver = MpmSolver(
        materials=tissue_table(0.004), grid_spacing=0.004, lower=(-1.0,) * 3, upper=(1.0,) * 3,
        largest_step=1e-6,
    )  # fmt: skip
    x = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    solver.set_particles(x, volume=np.full(3, 8e-9), material=np.full(3, 2, np.uint8))
    gradient = np.zeros((3, 9))
    gradient[2, 0] = -3e6
    solver._native.set_values(GRADIENT, gradient)
    with pytest.raises(UnstableStepError, match="inverted particle at particle 2,"):
        solver.advance(until=2e-6)


def test_a_particle_that_flies_out_is_named_with_place_and_time():
    solver = block(upper=(0.2, 0.2, 0.03), lower=(-0.2, -0.2, -0.03))
    velocity = np.zeros((1000, 3))
    velocity[:, 2] = 500.0
    solver._native.set_values(3, velocity)
    with pytest.raises(UnstableStepError, match="left the domain") as error:
        solver.advance(until=1e-3)
    assert "30." in str(error.value)  # z in mm
    assert "t = 4" in str(error.value)  # 21 mm at 500 m/s: 42 us
    assert "courant_number" in str(error.value)


def test_a_sound_block_raises_nothing():
    solver = block()
    solver._native.set_values(STRAIN, np.full((1000, 6), 1e-4))
    solver.advance(until=2e-5)
    assert np.all(np.isfinite(solver.velocity))


def test_a_run_goes_on_from_a_good_state_after_a_fault():
    solver = block()
    solver.advance(until=1e-6)
    good = solver.state()
    velocity = np.zeros((1000, 3))
    velocity[5] = np.nan
    solver._native.set_values(3, velocity)
    with pytest.raises(UnstableStepError):
        solver.advance(until=2e-6)
    solver.restore(good)
    solver.advance(until=2e-6)
    assert solver.time == 2e-6
    assert np.all(np.isfinite(solver.velocity))


@pytest.mark.parametrize("points", [7, 11, 15, 27])
def test_particles_a_last_digit_beside_the_nodes_are_no_fault(points):
    """Lattices 0.1 m off whose points lie on the nodes but for rounding.

    A node beyond them has a weight of 1e-44, and so a mass whose inverse is infinite in floats.
    """
    spacing = 0.002
    edge = (np.arange(points) + 0.5) * spacing / 2.0 - points * spacing / 4.0
    for shift in (0.05, 0.1):
        x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3) + shift
        solver = MpmSolver(
            materials=tissue_table(spacing), grid_spacing=spacing, lower=(-1.0,) * 3,
            upper=(1.0,) * 3,
        )  # fmt: skip
        solver.set_particles(x, volume=np.full(len(x), 1e-9), material=np.full(len(x), 2, np.uint8))
        solver.advance(until=1.0, max_steps=3)
        assert np.all(solver.velocity == 0.0)


def test_a_particle_without_volume_is_refused():
    solver = block()
    with pytest.raises(ScenarioError, match="volume"):
        solver.set_particles(
            np.zeros((2, 3)), volume=np.array([1e-9, 0.0]), material=np.zeros(2, np.uint8)
        )
