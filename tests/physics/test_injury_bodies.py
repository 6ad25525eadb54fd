"""Rigid bodies among the tissue: momentum closes, energy is lost, light bodies do not overshoot."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import ScenarioError, UnstableStepError
from vulnus.injury.bodies.attitude import attitude
from vulnus.injury.bodies.drawn_shapes import Ogive
from vulnus.injury.bodies.rigid_body import BodyPath, RigidBody
from vulnus.injury.bodies.shapes import SampledShape, Sphere
from vulnus.injury.bodies.signed_distance import sample
from vulnus.injury.materials import Material, material_table
from vulnus.injury.solver import MpmSolver, set_threads

pytestmark = pytest.mark.physics

SPACING = 0.004
SOFT = Material(density=1000.0, bulk_modulus=2e7, shear_modulus=2e6, yield_stress=2e5)


def block(*, bodies, precision="float64", edge=16, **changes) -> MpmSolver:
    """A cube of `edge`³ points, 8 a cell, around the origin, free on all sides."""
    solver = MpmSolver(
        materials=material_table([SOFT], SPACING), grid_spacing=SPACING, lower=(-0.5,) * 3,
        upper=(0.5,) * 3, precision=precision, bodies=bodies, **changes,
    )  # fmt: skip
    axis = (np.arange(edge) + 0.5 - 0.5 * edge) * SPACING / 2.0
    x = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    volume = np.full(len(x), (SPACING / 2.0) ** 3)
    solver.set_particles(x, volume=volume, material=np.zeros(len(x), np.uint8))
    return solver


def ball(**changes) -> RigidBody:
    settings = {
        "shape": Sphere(0.008), "centre": (0.004, -0.027, 0.003), "velocity": (5.0, 60.0, 0.0),
        "angular_velocity": (0.0, 900.0, 2000.0), "motion": "dynamic", "mass": 0.02,
        "friction": 0.3, **changes,
    }  # fmt: skip
    return RigidBody(**settings)


def momenta(solver: MpmSolver, masses) -> tuple[np.ndarray, np.ndarray]:
    """Linear and angular momentum (about the origin) of particles and bodies together."""
    totals = solver.totals()
    linear = np.array(totals["momentum"])
    angular = np.array(totals["angular_momentum"])
    for body, mass in zip(solver.bodies, masses, strict=True):
        inertia = 0.4 * mass * 0.008**2
        linear = linear + mass * body.velocity
        angular = angular + np.cross(body.position, mass * body.velocity)
        angular = angular + inertia * body.angular_velocity
    return linear, angular


def test_momentum_of_tissue_and_bodies_closes():
    """Two dynamic balls; 1e-10 of the momentum that changes hands."""
    second = ball(centre=(0.0, 0.027, 0.0), velocity=(0.0, -40.0, 3.0), name="second")
    solver = block(bodies=[ball(), second])
    masses = (0.02, 0.02)
    linear, angular = momenta(solver, masses)
    solver.advance(until=4e-4)
    new_linear, new_angular = momenta(solver, masses)
    exchanged = np.linalg.norm(solver.bodies[0].impulse)
    assert exchanged > 0.1
    assert np.allclose(new_linear, linear, rtol=0.0, atol=1e-10 * exchanged)
    assert np.allclose(new_angular, angular, rtol=0.0, atol=1e-10 * exchanged * 0.03)


def test_a_dynamic_body_loses_the_energy_that_its_work_names():
    solver = block(bodies=[ball()])

    def energy():
        body = solver.bodies[0]
        spin = 0.4 * 0.02 * 0.008**2 * np.dot(body.angular_velocity, body.angular_velocity)
        return 0.5 * (0.02 * np.dot(body.velocity, body.velocity) + spin)

    before = energy()
    solver.advance(until=4e-4)
    assert solver.bodies[0].work > 1.0
    assert before - energy() == pytest.approx(solver.bodies[0].work, rel=1e-10)


@pytest.mark.parametrize("mass", [1e-6, 1e-4])
def test_a_body_lighter_than_the_tissue_it_meets_does_not_overshoot(mass):
    """It weighs less than one node; an inelastic contact cannot fling it back."""
    solver = block(bodies=[ball(mass=mass, angular_velocity=(0.0,) * 3, velocity=(0.0, 60.0, 0.0))])
    speeds = []
    for _ in range(60):
        solver.advance(until=1.0, max_steps=1)
        speeds.append(solver.bodies[0].velocity[1])
    assert min(speeds) > -15.0  # the block's own rebound; an explicit impulse gives -600 and more
    assert abs(speeds[-1]) < 15.0
    assert max(speeds) <= 60.0 + 1e-9


def test_a_kinematic_body_keeps_its_motion_and_books_its_work():
    solver = block(bodies=[ball(motion="kinematic", mass=None, velocity=(0.0, 60.0, 0.0))])
    solver.advance(until=2e-4)
    body = solver.bodies[0]
    assert np.allclose(body.velocity, (0.0, 60.0, 0.0))
    assert np.allclose(body.position, (0.004, -0.015, 0.003))
    spin = np.dot(body.angular_impulse, (0.0, 900.0, 2000.0))
    assert body.work == pytest.approx(-60.0 * body.impulse[1] - spin, rel=1e-10)
    assert body.normal_impulse >= abs(body.impulse[1])
    # Without supports the block takes up what the ball gave it.
    assert solver.totals()["momentum"][1] == pytest.approx(-body.impulse[1], rel=1e-10)


def test_a_guided_body_follows_its_path_and_stops():
    path = BodyPath(
        times=np.array([0.0, 1e-4, 3e-4]),
        positions=np.array([[0.0, -0.03, 0.0], [0.0, -0.02, 0.0], [0.002, -0.03, 0.0]]),
    )
    solver = block(bodies=[RigidBody(shape=Sphere(0.006), path=path)])
    solver.advance(until=1e-4)
    assert np.allclose(solver.bodies[0].position, (0.0, -0.02, 0.0), atol=1e-12)
    solver.advance(until=2e-4)
    assert np.allclose(solver.bodies[0].position, (0.001, -0.025, 0.0), atol=1e-12)
    solver.advance(until=5e-4)
    assert np.allclose(solver.bodies[0].position, (0.002, -0.03, 0.0), atol=1e-12)
    assert np.allclose(solver.bodies[0].velocity, 0.0)


def test_bodies_have_the_same_bits_with_two_threads_and_resumed():
    def run(threads, split=False):
        set_threads(threads)
        solver = block(bodies=[ball()], precision="float32")
        if split:
            solver.advance_epoch(until=3e-4)
            saved = solver.state()
            solver = block(bodies=[ball()], precision="float32")
            solver.restore(saved)
        while solver.time < 3e-4:
            solver.advance_epoch(until=3e-4)
        return solver

    one, two, resumed = run(1), run(2), run(1, split=True)
    set_threads(0)
    assert np.any(one._native.body_state()[0, 16:19] != 0.0)
    for other in (two, resumed):
        assert np.array_equal(one._native.body_state(), other._native.body_state())
        assert np.array_equal(one.position, other.position)


def test_a_free_body_turns_as_euler_says():
    """No tissue near: momentum and energy of the spin stay, gravity accelerates the fall."""
    solver = block(
        bodies=[ball(centre=(0.3, 0.0, 0.0), velocity=(0.0, 0.0, 1.0))], gravity=(0.0, 0.0, -9.81)
    )
    solver.advance(until=1e-3)
    body = solver.bodies[0]
    assert np.allclose(body.angular_velocity, (0.0, 900.0, 2000.0))
    assert body.velocity[2] == pytest.approx(1.0 - 9.81e-3, rel=1e-12)
    angle = np.hypot(900.0, 2000.0) * 1e-3
    assert np.trace(body.rotation) == pytest.approx(1.0 + 2.0 * np.cos(angle), abs=1e-9)


def test_the_step_sees_the_spin_of_the_surface():
    """16 mm at 50 000 rad/s: 400 m/s at the surface, |v| dt < 0.3 cells."""
    solver = block(bodies=[ball(angular_velocity=(0.0, 5e4, 0.0))])
    solver.advance(until=1.0, max_steps=1)
    assert solver.step_size <= 0.3 * SPACING / 400.0


def test_a_body_that_is_not_finite_is_named():
    solver = block(bodies=[ball(name="fragment 7", centre=(0.2, 0.0, 0.0))])
    rows = solver._native.body_state()
    rows[0, 3] = np.inf
    solver._native.set_body_state(rows)
    with pytest.raises(UnstableStepError, match="fragment 7"):
        solver.advance(until=1e-4)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"mass": None}, "mass"),
        ({"mass": -1.0}, "mass"),
        ({"motion": "floating"}, "motion"),
        ({"centre": None}, "centre"),
        ({"rotation": np.ones((3, 3))}, "rotation"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "rotation"),
        ({"velocity": (np.nan, 0.0, 0.0)}, "finite"),
        ({"friction": -0.1}, "friction"),
    ],
)
def test_a_body_that_cannot_be_is_refused_by_name(changes, named):
    with pytest.raises(ScenarioError, match=named):
        ball(**changes)


def test_a_sampled_ball_does_what_the_exact_one_does():
    """The same ball as a mesh-like distance grid: its impulse within 3 %, its turn within 3 %."""

    class SampledBall(SampledShape):
        def drawn_box(self):
            return np.full(3, -0.008), np.full(3, 0.008)

        def drawn(self):
            return sample(
                lambda x, y, z: np.sqrt(x**2 + y**2 + z**2) - 0.008, *self.drawn_box(), 0.016
            )

    states = []
    for shape in (Sphere(0.008), SampledBall()):
        solver = block(bodies=[ball(shape=shape)])
        solver.advance(until=3e-4)
        states.append(solver.bodies[0])
    exact, sampled = states
    scale = np.linalg.norm(exact.impulse)
    assert scale > 0.05
    assert np.allclose(sampled.impulse, exact.impulse, atol=0.03 * scale)
    turned = np.linalg.norm(exact.angular_impulse)
    assert np.allclose(sampled.angular_impulse, exact.angular_impulse, atol=0.03 * turned)


def test_momentum_closes_with_a_tumbling_bullet():
    """No symmetry: a yawed ogive; linear and angular momentum to 1e-10 of what is exchanged."""
    shape = Ogive(0.004, 0.018, 0.009)
    bullet = RigidBody(
        shape=shape, centre=(0.002, -0.028, 0.001), velocity=(0.0, 80.0, 0.0), mass=0.005,
        rotation=attitude((0, 1, 0), yaw=0.3), angular_velocity=(0.0, 3000.0, 0.0),
        motion="dynamic",
    )  # fmt: skip
    solver = block(bodies=[bullet])

    def total():
        body, sums = solver.bodies[0], solver.totals()
        world = body.rotation @ bullet.inertia @ body.rotation.T
        spin = np.cross(body.position, 0.005 * body.velocity) + world @ body.angular_velocity
        linear = np.array(sums["momentum"]) + 0.005 * body.velocity
        return linear, np.array(sums["angular_momentum"]) + spin

    linear, angular = total()
    solver.advance(until=4e-4)
    exchanged = np.linalg.norm(solver.bodies[0].impulse)
    assert exchanged > 0.05
    new_linear, new_angular = total()
    assert np.allclose(new_linear, linear, rtol=0.0, atol=1e-10 * exchanged)
    assert np.allclose(new_angular, angular, rtol=0.0, atol=1e-10 * exchanged * 0.03)


def test_particle_arrays_that_differ_in_length_are_refused():
    solver = block(bodies=[])
    with pytest.raises(ScenarioError, match="lengths"):
        solver.set_particles(np.zeros((3, 3)), volume=np.ones(2), material=np.zeros(3, np.uint8))


def test_a_body_on_a_rail_keeps_to_it_and_closes_the_balance_along_it():
    """Beside the middle of the block the tissue pushes aside and turns; the rail bears that."""
    slid = ball(
        centre=(-0.027, 0.004, 0.0), velocity=(100.0, 0.0, 0.0), rail=(2.0, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 0.0),
    )  # fmt: skip
    solver = block(bodies=[slid])
    start = 0.5 * slid.mass * 100.0**2
    solver.advance(until=2e-4)
    (state,) = solver.bodies
    assert np.all(state.position[1:] == (0.004, 0.0))
    assert np.all(state.velocity[1:] == 0.0)
    assert np.all(state.angular_velocity == 0.0)
    assert np.linalg.norm(state.impulse[1:]) > 1e-3 * abs(state.impulse[0])
    assert slid.mass * (state.velocity[0] - 100.0) == pytest.approx(state.impulse[0], rel=1e-10)
    assert start - 0.5 * slid.mass * state.velocity[0] ** 2 == pytest.approx(state.work, rel=1e-9)


def test_the_clock_is_that_of_the_bodies_where_a_stop_comes_nearer():
    """x = x0 + v t also where steps begun for a later stop meet an earlier one; round-off."""
    far = ball(centre=(0.0, -0.3, 0.0), velocity=(0.0, 60.0, 0.0), motion="kinematic")
    solver = block(bodies=[far], edge=4)
    solver.advance(until=1e-3, max_steps=3)
    solver.advance(until=solver.time + 0.1 * solver.step_size)
    assert solver.bodies[0].position[1] == pytest.approx(-0.3 + 60.0 * solver.time, abs=1e-12)


def test_gravity_moves_a_body_along_its_rail():
    """Its part along the rail, nothing across."""
    rail = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    bead = ball(
        centre=(0.3, 0.0, 0.0), velocity=tuple(2.0 * rail), angular_velocity=(0.0,) * 3,
        rail=tuple(rail),
    )  # fmt: skip
    solver = block(bodies=[bead], edge=4, gravity=(0.0, -1000.0, 50.0))
    solver.advance(until=1e-3)
    gained = solver.bodies[0].velocity - 2.0 * rail
    assert np.allclose(gained, -1000.0 * 1e-3 / np.sqrt(2.0) * rail, atol=1e-9)


@pytest.mark.parametrize("key", ["velocity", "angular_velocity"])
def test_a_path_and_a_velocity_are_one_too_many(key):
    way = BodyPath(times=np.array([0.0, 1.0]), positions=np.array([[0.0, 0, 0], [0.1, 0, 0]]))
    with pytest.raises(ScenarioError, match=f"projectile {key}"):
        RigidBody(shape=Sphere(0.008), path=way, **{key: (0.0, 10.0, 0.0)})


def test_a_contact_that_is_not_solved_is_told():
    """With one iteration where three are needed; with as many as there are it is none."""
    solver = block(bodies=[ball(mass=1e-4, friction=5.0)])
    solver._native.contact_iterations = 1
    with pytest.raises(UnstableStepError, match="projectile has a contact") as error:
        solver.advance(until=4e-4)
    assert "friction" in error.value.advice
    block(bodies=[ball(mass=1e-4, friction=5.0)]).advance(until=4e-4)
