"""What a shot leaves behind: a tract of about the ball's width, and the vessel it meets cut."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb

from vulnus.core.handoff import Tissue
from vulnus.injury import AimParameters, InjuryParameters, ProjectileParameters, shoot
from vulnus.injury.bodies.rigid_body import RigidBody
from vulnus.injury.bodies.shapes import Sphere
from vulnus.injury.materials import MUSCLE, material_table
from vulnus.injury.solver import MpmSolver

pytestmark = pytest.mark.physics

BALL = ProjectileParameters(diameter=0.009, speed=350.0)


def shot_at(offset: float, *, limb=None, **changes):
    """A shot in +y that passes `offset` [m] in x beside the artery."""
    limb = limb or synthetic_limb(spacing=0.002, length=0.07, artery_at=(-0.004, 0.0))
    aim = AimParameters(target=(-0.004 + offset, 0.0, 0.0), azimuth=0.0)
    parameters = InjuryParameters(
        projectile=BALL, aim=aim, grid_spacing=0.003, duration=2e-4, window_length=0.05,
        absorbing_length=0.0, threads=1, **changes,
    )  # fmt: skip
    return shoot(limb, parameters).permanent


@pytest.fixture(scope="module")
def central_shot():
    return shot_at(0.0)


def test_a_sphere_through_gel_leaves_a_tract_of_its_diameter():
    """Right behind a sphere of 5 cells the gel is open for about the diameter.

    A grid contact adds up to a cell on every side (PHYSICS.md 1.6), and the cavity that the gel's
    inertia opens comes on top further back, so 0.8 to 1.6 diameters one radius behind the centre.
    """
    dx, diameter = 0.002, 0.010
    half = np.array([0.02, 0.02, 0.02])
    rng = np.random.default_rng(0)
    edge = np.arange(-0.02, 0.02, dx / 2.0) + dx / 4.0
    x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    x += rng.uniform(-0.1, 0.1, x.shape) * dx
    ball = RigidBody(
        shape=Sphere(diameter / 2), centre=(-0.025, 0, 0), velocity=(200.0, 0, 0), friction=0.0
    )
    solver = MpmSolver(
        materials=material_table([MUSCLE], dx), grid_spacing=dx, lower=tuple(-half - 0.1),
        upper=tuple(half + 0.1), bodies=[ball],
    )  # fmt: skip
    solver.set_particles(
        x, volume=np.full(len(x), (dx / 2) ** 3), material=np.zeros(len(x), np.uint8)
    )
    solver.advance(until=1.5e-4)
    centre = -0.025 + 200.0 * 1.5e-4
    position = solver.position
    behind = np.abs(position[:, 0] - (centre - diameter / 2)) < dx
    # Half-width of the open channel: the 1 % quantile spares single torn-off particles.
    width = 2.0 * np.quantile(np.hypot(position[behind, 1], position[behind, 2]), 0.01)
    assert 0.8 * diameter < width < 1.6 * diameter


@pytest.fixture(scope="module")
def graze():
    """The line passes 1.5 mm beside a limb of radius 20 mm, with a ball of 4.5 mm."""
    limb = synthetic_limb(spacing=0.002, length=0.07, artery_at=(-0.004, 0.0))
    parameters = InjuryParameters(
        projectile=BALL, aim=AimParameters(target=(0.0215, 0.0, 0.0)), grid_spacing=0.003,
        duration=2e-4, window_length=0.05, absorbing_length=0.0, threads=1,
    )  # fmt: skip
    return shoot(limb, parameters)


def test_a_ball_that_grazes_the_limb_ploughs_a_furrow(graze):
    """It reaches 3 mm deep: skin is destroyed there and nowhere else, the artery is whole."""
    limb, (ball,) = graze.permanent, graze.report.projectiles
    destroyed = (limb.damage >= 0.9) & (limb.tissue == Tissue.SKIN)
    assert np.count_nonzero(destroyed) > 10
    assert np.all(limb.reference_position[destroyed, 0] > 0.01)
    assert limb.injuries == ()
    assert graze.report.vessels[0].kind == "intact"
    # Its wall is 21.5 + 4 - 4.5 - 1.3 mm away from the ball's surface: 5 % for what it was moved.
    assert graze.report.vessels[0].nearest_distance == pytest.approx(0.0197, rel=0.05)
    assert ball.fate == "left"
    assert 0.0 < ball.tract.arc_length[-1] < 0.03
    assert ball.energy.total > 0.0


def test_the_vessel_in_the_path_is_cut_where_the_line_crosses_it(central_shot):
    assert central_shot.severed_segment == "anterior_tibial"
    injury = central_shot.injuries[0]
    assert injury.arc_fraction == pytest.approx(0.5, abs=0.05)
    # At least the ball's width is gone; stretch tears at most some widths more.
    assert 0.8 * BALL.diameter < injury.gap < 4.0 * BALL.diameter
    assert injury.lumen_radius == pytest.approx(0.0013)
    for axis in (injury.axis_proximal, injury.axis_distal):
        assert math.isclose(np.linalg.norm(axis), 1.0, rel_tol=1e-12)
    # Both lumens open towards the gap: the proximal one downwards, the distal one upwards.
    assert injury.position_proximal[2] > 0.0 > injury.position_distal[2]
    assert injury.axis_proximal[2] < 0.0 < injury.axis_distal[2]


def test_a_vessel_off_the_path_is_not_cut():
    """The line passes 17 mm beside the artery, some four radii of the ball.

    The temporary cavity, 11 mm wide by then, pushes it aside by 3 mm; at 13 mm it would tear it.
    """
    wound = shot_at(0.017)
    assert wound.injuries == ()
    assert wound.severed_segment is None
    assert np.max(wound.arteries[0].damage) < 0.9
    assert wound.entry_area > 0.0


def test_the_skin_is_holed_on_both_sides(central_shot):
    """In the open cavity at 0.2 ms: at least half the ball's section, less than what is seen."""
    section = 0.25 * math.pi * BALL.diameter**2
    for area in (central_shot.entry_area, central_shot.exit_area):
        assert 0.5 * section < area < 12.0 * section


def test_tissue_outside_the_window_and_at_the_held_ends_stays(central_shot):
    moved = np.linalg.norm(central_shot.position - central_shot.reference_position, axis=1)
    height = np.abs(central_shot.reference_position[:, 2])
    assert np.max(moved[height > 0.025]) == 0.0
    # Inside the held 6 mm only the outermost node row feels anything: less than a tenth of a cell.
    assert np.max(moved[height > 0.0225]) < 3e-4
    assert np.max(moved) > 0.005


def test_the_limb_is_returned_whole_and_in_order(central_shot):
    limb = synthetic_limb(spacing=0.002, length=0.07, artery_at=(-0.004, 0.0))
    assert np.array_equal(central_shot.reference_position, limb.position)
    assert np.array_equal(central_shot.tissue, limb.tissue)
    assert np.all(np.isfinite(central_shot.position))
    assert np.all((central_shot.damage >= 0.0) & (central_shot.damage <= 1.0))
    # Bone beside the path is hardly damaged, skin at the entry is.
    skin = (limb.tissue == Tissue.SKIN) & (limb.position[:, 1] < 0.0)
    near = np.hypot(limb.position[:, 0] + 0.004, limb.position[:, 2]) < 0.003
    assert np.mean(central_shot.damage[skin & near]) > 0.9
