"""What sets the time step, what ends a run whose step collapses, and how long a call may take."""

from __future__ import annotations

import time

import numpy as np
import pytest

from vulnus.core.errors import UnstableStepError
from vulnus.injury.bodies.rigid_body import STATE_ROWS, RigidBody
from vulnus.injury.bodies.shapes import Sphere
from vulnus.injury.boundaries import Wall
from vulnus.injury.materials import elastic, liquid, material_table
from vulnus.injury.solver import MpmSolver, set_threads

pytestmark = pytest.mark.physics

SPACING = 0.002
WATER = liquid(1000.0, 2.2e9)


@pytest.fixture(autouse=True)
def _one_thread():
    """Bodies of a few hundred points: a second thread only waits."""
    set_threads(1)
    yield
    set_threads(0)


def lattice(*cells):
    """Eight points a cell from the origin on."""
    axes = [(np.arange(2 * n) + 0.5) * SPACING / 2.0 for n in cells]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def solver_of(x, *, law=WATER, velocity=None, **settings):
    settings = {"lower": (-0.1,) * 3, "upper": (0.1,) * 3, **settings}
    solver = MpmSolver(materials=material_table([law], SPACING), grid_spacing=SPACING, **settings)
    volume = np.full(len(x), (SPACING / 2.0) ** 3)
    solver.set_particles(x, volume=volume, material=np.zeros(len(x), np.uint8), velocity=velocity)
    return solver


def test_a_liquid_pressed_to_nothing_ends_the_run_by_name():
    """A piston in a closed box of water: J^-7 makes a step of nothing out of 0.5 us.

    The fault names the particle that sets the step, the most squeezed one, with place and time.
    """
    length, speed = 8 * SPACING, 1000.0
    unit = np.eye(3)
    walls = [Wall(point=(0.0, 0.0, 0.0), normal=tuple(unit[k]), kind="slip") for k in range(3)]
    walls += [
        Wall(point=tuple(2 * SPACING * unit[k]), normal=tuple(-unit[k]), kind="slip")
        for k in (1, 2)
    ]
    piston = Wall(
        point=(length, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), kind="separating",
        velocity=(-speed, 0.0, 0.0),
    )  # fmt: skip
    solver = solver_of(lattice(8, 2, 2), boundaries=[*walls, piston])
    with pytest.raises(UnstableStepError, match="time step that has collapsed") as error:
        solver.advance(until=length / speed, max_steps=20000)
    told = str(error.value)
    particle = int(np.argmin(solver.volume_ratio))
    assert f"at particle {particle}," in told
    assert "volume ratio 0.1" in told  # water's waves are 1000 times as fast at 0.139
    assert f"t = {solver.time:.6g} s" in told
    assert "squeezes" in error.value.advice
    assert solver.time < length / speed


def test_a_body_without_bound_is_named_instead_of_waited_for():
    ball = RigidBody(shape=Sphere(0.004), centre=(0.05, 0.05, 0.05), name="ray")
    solver = solver_of(lattice(2, 2, 2), bodies=[ball])
    state = solver._native.body_state()
    state[0, STATE_ROWS["velocity"]] = (1e12, 0.0, 0.0)
    solver._native.set_body_state(state)
    with pytest.raises(UnstableStepError, match="ray is so fast"):
        solver.advance(until=1e-6)


def test_a_particle_without_bound_is_named():
    x = lattice(2, 2, 2)
    velocity = np.zeros_like(x)
    velocity[37] = 1e12
    with pytest.raises(UnstableStepError, match=r"collapsed .* particle 37,"):
        solver_of(x, velocity=velocity).advance(until=1e-6)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_places_without_a_particle_do_not_set_the_step(precision):
    """Blocks are filled up to whole bundles with copies, which no cell's mean volume rate calms.

    The largest wave speed is that of the particles: sqrt(K/rho) J^-3.5 of the most squeezed.
    """
    rng = np.random.default_rng(5)
    x = rng.uniform(0.0, 0.01, (1013, 3))
    velocity = 60.0 * np.sin(1500.0 * x[:, [1, 2, 0]]) - 60.0 * np.sin(1800.0 * x)
    solver = solver_of(x, velocity=velocity, precision=precision)
    for k in range(1, 6):
        solver.advance(until=k * 1e-6)
        stiffest = max(np.min(solver.volume_ratio) ** -3.5, 1.0)
        fastest = np.sqrt(2.2e9 / 1000.0) * max(stiffest, np.sqrt(np.max(solver.volume_ratio)))
        assert solver._native.sound_speed == pytest.approx(fastest, rel=1e-4)


def test_the_first_step_knows_the_speed_of_a_moving_wall():
    """0.3 cells of its way at most, before any node has its speed."""
    wall = Wall(point=(-0.05, 0, 0), normal=(1, 0, 0), kind="separating", velocity=(4e4, 0, 0))
    solver = solver_of(lattice(2, 2, 2), boundaries=[wall])
    solver.advance(until=1e-3, max_steps=1)
    assert solver.time <= 0.3 * SPACING / 4e4 * (1.0 + 1e-9)


def test_a_fast_body_keeps_the_particles_from_going_far_ahead():
    """Momentum passes at every step beside a body of 2000 m/s, so that they go no step ahead."""
    ball = RigidBody(shape=Sphere(0.004), centre=(0.05, 0.05, 0.05), velocity=(2e3, 0.0, 0.0))
    x = lattice(4, 4, 4)
    solver = solver_of(x, velocity=np.tile([10.0, 0.0, 0.0], (len(x), 1)), bodies=[ball])
    solver.advance(until=1e-3, max_steps=1)
    assert not solver.synchronized
    moved = np.mean(solver.position[:, 0] - x[:, 0])
    assert moved == pytest.approx(10.0 * solver.time, abs=0.5 * 10.0 * solver.step_size)


def test_a_long_start_of_an_epoch_is_a_call_of_its_own():
    """Half a million points: no native call takes 0.2 s, and the steps are those of one call.

    Ctrl-C is answered between calls. The shortest of three goes, for other work on the machine.
    """
    x = lattice(40, 40, 40)
    assert len(x) == 512000
    solver = solver_of(x)
    walls, taken = [], []
    for _ in range(12):
        start = time.perf_counter()
        taken.append(solver._native.advance(1, 1.0, 1.0))
        walls.append(time.perf_counter() - start)
    assert sum(taken) > 0
    whole = solver_of(x)
    assert whole.advance(until=1.0, max_steps=sum(taken)) == sum(taken)
    assert whole.time == solver.time
    assert np.array_equal(whole.position, solver.position)


@pytest.mark.parametrize(("speed", "error"), [(0.1, 1e-3), (1e-3, 0.02), (1e-4, 0.2)])
def test_what_drifts_slowly_in_single_precision_gets_there(speed, error):
    """x += v dt loses what is below 2^-24 of x, here 2e-9 m of 7.6e-11 to 7.6e-8 m a step.

    Rounded to the nearest the slower two would stand still for ever and the first lag by 2 %. With
    the dither the error stays some last digits, however many steps: 4e-9 m of 4e-5 to 4e-8 m.
    """
    x = lattice(2, 2, 2) + 0.05
    velocity = np.tile([speed, 0.0, 0.0], (len(x), 1))
    solver = solver_of(x, law=elastic(1000.0, 1e9, 0.2), velocity=velocity)
    start = solver.position
    solver.advance(until=1.0, max_steps=512)
    moved = np.mean(solver.position[:, 0] - start[:, 0])
    assert moved == pytest.approx(speed * solver.time, rel=error)
    assert np.array_equal(solver.position[:, 1:], start[:, 1:])  # what stands stays
