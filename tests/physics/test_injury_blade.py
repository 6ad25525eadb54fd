"""A blade cuts: a plane of broken particles, tissue beside it stays; a blunt plate ploughs."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury.bodies.drawn_shapes import BladeShape, Box
from vulnus.injury.bodies.rigid_body import BodyPath, RigidBody
from vulnus.injury.boundaries import Wall
from vulnus.injury.materials import material_table, neo_hookean, von_mises
from vulnus.injury.solver import MpmSolver

pytestmark = pytest.mark.physics

SPACING, THICKNESS, DEPTH, SPEED = 0.002, 0.002, 0.016, 20.0
GEL = von_mises(
    density=1000.0, youngs_modulus=3e5, poisson_ratio=0.49, yield_stress=3e4
)  # as soft as 10 % gelatin, compressible enough for short runs


def stabbed(shape, *, cutting, beside=0.0007):
    """Particles before and after a thrust of 16 mm along x and back; and the solver.

    The plate lies `beside` [m] a plane of nodes.
    """
    across = (np.arange(24) - 11.5) * SPACING / 2.0
    along = (np.arange(26) + 0.5) * SPACING / 2.0
    x = np.stack(np.meshgrid(along, across, across, indexing="ij"), axis=-1).reshape(-1, 3)
    outside = np.array([-0.001 - shape.upper[0], beside, 0.0])
    thrust = (DEPTH + 0.001) / SPEED
    path = BodyPath(
        times=np.array([0.0, thrust, 2.0 * thrust]),
        positions=np.array([outside, outside + [DEPTH + 0.001, 0.0, 0.0], outside]),
    )
    blade = RigidBody(shape=shape, path=path, cutting=cutting, name="blade")
    back = Wall(point=(0.024, 0.0, 0.0), normal=(-1.0, 0.0, 0.0))
    solver = MpmSolver(
        materials=material_table([GEL], SPACING), grid_spacing=SPACING, lower=(-0.2,) * 3,
        upper=(0.2,) * 3, bodies=[blade], boundaries=[back],
    )  # fmt: skip
    solver.set_particles(
        x, volume=np.full(len(x), (SPACING / 2.0) ** 3), material=np.zeros(len(x), np.uint8)
    )
    solver.advance(until=2.2 * thrust)
    return x, solver


@pytest.fixture(scope="module")
def cut():
    return stabbed(BladeShape(0.05, 0.012, THICKNESS, 0.008), cutting=True)


@pytest.fixture(scope="module")
def ploughed():
    return stabbed(Box((0.05, THICKNESS, 0.012)), cutting=False)


def test_the_cut_is_a_plane(cut):
    x, solver = cut
    broken = solver.damage > 0.9
    # Within a cell of the plate's sweep: its half thickness, and as far in width and depth.
    assert np.max(np.abs(x[broken, 1] - 0.0007)) < 0.5 * THICKNESS + SPACING
    assert np.max(np.abs(x[broken, 2])) < 0.006 + SPACING
    assert np.max(x[broken, 0]) < DEPTH + SPACING
    # Everything in the middle of the sweep is cut, back to the shoulder of the tip.
    swept = (np.abs(x[:, 1] - 0.0007) < 0.5 * THICKNESS) & (np.abs(x[:, 2]) < 0.003)
    assert np.all(broken[swept & (x[:, 0] < DEPTH - 0.008)])


def test_tissue_beside_the_cut_is_sound_and_stays(cut):
    x, solver = cut
    beside = np.abs(x[:, 1] - 0.0007) > 0.5 * THICKNESS + SPACING
    assert np.max(solver.damage[beside]) < 0.1
    assert np.max(np.linalg.norm(solver.position - x, axis=1)[beside]) < SPACING


def test_a_blunt_plate_of_its_size_displaces_much_more(cut, ploughed):
    moved = [np.linalg.norm(s.position - x, axis=1) for x, s in (cut, ploughed)]
    assert np.max(moved[1]) > 3.0 * np.max(moved[0])
    assert np.mean(moved[1]) > 2.0 * np.mean(moved[0])
    work = [s.bodies[0].work for _, s in (cut, ploughed)]
    assert work[1] > 5.0 * abs(work[0])


def test_a_network_is_cut_too():
    """A neo-Hookean block, which cannot flow: the damage of the sweep is 1."""
    shape = BladeShape(0.05, 0.012, THICKNESS, 0.008)
    blade = RigidBody(
        shape=shape, centre=(0.004 - shape.upper[0], 0.0, 0.0), velocity=(1.0, 0.0, 0.0),
        cutting=True,
    )  # fmt: skip
    solver = MpmSolver(
        materials=material_table([neo_hookean(1000.0, 1e5, 1e6)], SPACING), grid_spacing=SPACING,
        lower=(-0.2,) * 3, upper=(0.2,) * 3, bodies=[blade],
    )  # fmt: skip
    edge = (np.arange(10) - 4.5) * SPACING / 2.0
    x = np.stack(np.meshgrid(edge + 0.005, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    solver.set_particles(x, volume=np.full(len(x), 1e-9), material=np.zeros(len(x), np.uint8))
    solver.advance(until=1e-5)
    inside = (np.abs(x[:, 1]) < 0.0006) & (np.abs(x[:, 2]) < 1e-3) & (x[:, 0] < 0.002)
    assert np.count_nonzero(inside) > 0
    assert np.all(solver.damage[inside] == 1.0)
    assert np.all(solver.damage[np.abs(x[:, 1]) > 0.002] < 0.1)
