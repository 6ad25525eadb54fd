"""Blood enters as fast as the tree says, and leaves again when the flow turns."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.hemorrhage import BleedingSolver, FluidParameters

DX = 1.5e-3
LAYER = 4.0 * np.pi * 1.5e-3**2 / DX**2
FLOW = 5e-6


def free_source(seed=1, threads=1) -> BleedingSolver:
    """A source in free space."""
    solver = BleedingSolver(FluidParameters(particle_spacing=DX, sound_speed=15.0), threads=threads)
    solver.native.set_source((0.0, 0.0, 0.0), 1.5e-3, 0.0, seed)
    return solver


def pulse(time):
    return FLOW * (1.0 + 0.8 * np.sin(2.0 * np.pi * time / 0.05))


def test_particle_count_is_the_integral_of_the_flow():
    """PHYSICS S12: to one layer, about 12 particles here; the flow is pulsatile."""
    times = np.linspace(0.0, 0.1, 201)
    solver = free_source()
    for until in (0.02, 0.05, 0.08, 0.1):
        solver.advance(until, (times, pulse(times)))
        fine = np.linspace(0.0, until, 4001)
        volume = np.trapezoid(pulse(fine), fine)
        assert solver.native.injected == pytest.approx(volume, rel=1e-3)
        assert abs(solver.particle_count - volume / DX**3) <= LAYER


def test_newcomers_start_on_the_shell_and_fly_outwards():
    solver = free_source()
    speed = FLOW / (4.0 * np.pi * 1.5e-3**2)
    while solver.particle_count == 0:
        solver.step_chunk(1.0, (np.array([0.0]), np.array([FLOW])), step_limit=1)
    position, velocity = solver.position[0], solver.velocity[0]
    assert np.linalg.norm(position) == pytest.approx(1.5e-3, rel=0.02)
    assert np.linalg.norm(velocity) == pytest.approx(speed, rel=1e-3)
    assert position @ velocity > 0.999 * np.linalg.norm(position) * np.linalg.norm(velocity)


def test_reversed_flow_takes_particles_back():
    """What is taken back leaves the ledger: injected = particles + pending throughout."""
    solver = free_source()
    solver.advance(0.03, (np.array([0.0]), np.array([FLOW])))
    before = solver.particle_count
    solver.advance(0.04, (np.array([0.0]), np.array([-FLOW])))
    volumes = solver.volumes()
    assert solver.particle_count < before
    held = volumes.in_limb + volumes.out_of_limb + volumes.removed + volumes.pending
    assert volumes.injected == pytest.approx(held, rel=1e-12)


def test_strays_are_booked():
    solver = free_source()
    solver.native.set_domain((-4e-3, -4e-3, -4e-3), (4e-3, 4e-3, 4e-3))
    solver.advance(0.1, (np.array([0.0]), np.array([FLOW])))
    volumes = solver.volumes()
    assert volumes.removed > 0.0
    held = volumes.in_limb + volumes.out_of_limb + volumes.removed + volumes.pending
    assert volumes.injected == pytest.approx(held, rel=1e-12)


def test_pressure_is_zero_at_a_free_surface():
    solver = free_source()
    solver.advance(0.005, (np.array([0.0]), np.array([FLOW])))
    assert solver.pressure_injury == 0.0


def test_seeds_differ_and_repeat():
    def run(seed):
        solver = free_source(seed)
        solver.advance(0.01, (np.array([0.0]), np.array([FLOW])))
        return solver.position[np.argsort(solver.id)]

    assert np.array_equal(run(1), run(1))
    assert not np.array_equal(run(1), run(2))
