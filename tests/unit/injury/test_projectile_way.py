"""Out is a body whose surface, not its middle, is clear of the limb; and only then has it left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb

from vulnus.injury import AimParameters, InjuryParameters, ProjectileParameters
from vulnus.injury.bodies.drawn_shapes import Cylinder
from vulnus.injury.bodies.rigid_body import BodyState
from vulnus.injury.shot.projectile_way import fates_of, is_out, leaves_exit, ways_of
from vulnus.injury.shot.record import RunRecord
from vulnus.injury.shot.setup import prepare_shot

AIMED = InjuryParameters(
    aim=AimParameters(target=(0.0, 0.0, 0.0)), grid_spacing=0.005, window_length=0.05,
    absorbing_length=0.006,
)  # fmt: skip
ROD = ProjectileParameters(shape="cylinder", diameter=0.009, length=0.08, speed=200.0)
KNIFE = ProjectileParameters(
    shape="blade", diameter=0.02, length=0.1, width=0.02, thickness=0.003, tip_length=0.02,
    depth=0.025, speed=20.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def limb():
    return synthetic_limb(spacing=0.003, length=0.07)


def state(y, *, rotation=None, velocity=(0.0, 200.0, 0.0)) -> BodyState:
    return BodyState(
        name="rod", position=np.array([0.0, y, 0.0]), velocity=np.array(velocity),
        rotation=np.eye(3) if rotation is None else rotation, angular_velocity=np.zeros(3),
        impulse=np.zeros(3), angular_impulse=np.zeros(3), normal_impulse=0.0, work=1.0,
    )  # fmt: skip


def test_a_long_body_is_out_when_its_tail_is(limb):
    """The limb ends at y = 20 mm; the rod of 80 mm lies along y, or across."""
    rod, margin = Cylinder(0.0045, 0.08), 0.01
    ahead = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert not is_out(limb, rod, state(0.065, rotation=ahead), margin)
    assert is_out(limb, rod, state(0.073, rotation=ahead), margin)
    assert is_out(limb, rod, state(0.037), margin)  # across: its side is 4.5 mm from its middle
    assert not is_out(limb, rod, state(-0.055, rotation=ahead), margin)


@pytest.mark.parametrize("projectile", [ROD, KNIFE])
def test_what_has_only_touched_the_limb_is_inside_and_has_no_tract(limb, projectile):
    setup = prepare_shot(limb, replace(AIMED, projectile=projectile))
    record = RunRecord(setup.solver, setup.connected)
    assert fates_of(setup) == ["inside"]
    (way,) = ways_of(setup, record)
    assert way.exit_place is None
    assert np.linalg.norm(way.points[-1] - way.points[0]) < 1e-5
    # Its nose is at the skin, its middle far before it.
    assert way.points[0][1] == pytest.approx(-0.02, abs=0.003)


def test_a_blade_leaves_an_exit_where_it_is_longer_than_the_way_through(limb):
    short = prepare_shot(limb, replace(AIMED, projectile=KNIFE))
    through = prepare_shot(limb, replace(AIMED, projectile=replace(KNIFE, depth=0.06)))
    assert not leaves_exit(short, 0, "left")
    assert leaves_exit(through, 0, "left")


def test_the_thrust_goes_in_and_clear_of_the_limb(limb):
    setup = prepare_shot(limb, replace(AIMED, projectile=KNIFE))
    # 25 mm in and out at 20 m/s, and three cells of 5 mm on; the nearest point is 1.5 mm away.
    assert setup.thrust_end == pytest.approx((0.05 + 0.015) / 20.0, abs=0.003 / 20.0)
    assert setup.turns[0] == pytest.approx(0.025 / 20.0, abs=0.002 / 20.0)
    ends = setup.bodies[0].path.positions
    assert is_out(limb, setup.bodies[0].shape, replace_place(setup, ends[-1]), 2 * 0.005)
    assert not is_out(limb, setup.bodies[0].shape, replace_place(setup, ends[0]), 2 * 0.005)


def replace_place(setup, place) -> BodyState:
    return replace(setup.solver.bodies[0], position=np.asarray(place))
