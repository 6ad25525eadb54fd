"""The body of a shot: of its shape and turn, and where it touches the limb first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb

from vulnus.core.errors import ScenarioError
from vulnus.injury import AimParameters, InjuryParameters, ProjectileParameters
from vulnus.injury.bodies.contact_way import Outline
from vulnus.injury.bodies.shape_distance import distance_to
from vulnus.injury.parameters import ShotParameters
from vulnus.injury.shot.setup import prepare_shot

AIMED = InjuryParameters(
    aim=AimParameters(target=(0.0, 0.0, 0.0)),
    grid_spacing=0.004,
    window_length=0.05,
    absorbing_length=0.006,
)
BALL = ProjectileParameters(diameter=0.009)
BULLET = ProjectileParameters(
    shape="ogive", motion="dynamic", mass=0.008, diameter=0.009, length=0.016, nose_length=0.01,
    spin=1000.0,
)  # fmt: skip
FRAGMENT = ProjectileParameters(
    shape="cylinder", motion="dynamic", mass=0.0011, diameter=0.009, length=0.009
)
KNIFE = ProjectileParameters(
    shape="blade", diameter=0.02, length=0.1, width=0.02, thickness=0.003, tip_length=0.02,
    depth=0.025, speed=7.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def limb():
    return synthetic_limb(spacing=0.0025, length=0.07)


def first_body(limb, projectile, **changes):
    setup = prepare_shot(limb, replace(AIMED, projectile=projectile, **changes))
    return setup.solver.bodies[0], setup


@pytest.mark.parametrize("projectile", [BALL, BULLET, FRAGMENT, KNIFE])
def test_the_nose_stands_at_the_limb_when_time_begins(limb, projectile):
    """Its foremost part is within a spacing of the points, 2.5 mm, of the skin at -20 mm."""
    body, _ = first_body(limb, projectile)
    shape = projectile_shape(projectile)
    direction = np.array([0.0, 1.0, 0.0])
    nose = body.position[1] + Outline.of(shape).reach(direction, body.rotation)
    assert nose == pytest.approx(-0.02, abs=0.0025)
    local = (np.asarray(limb.position, np.float64) - body.position) @ body.rotation
    assert distance_to(shape, local).min() > -1e-4


def projectile_shape(projectile):
    from vulnus.injury.shot.flying_bodies import shape_of

    return shape_of(projectile)


def test_a_bullet_flies_nose_first_and_spins_about_it(limb):
    body, _ = first_body(limb, BULLET)
    assert body.rotation[:, 0] == pytest.approx((0.0, 1.0, 0.0), abs=1e-9)
    assert body.angular_velocity == pytest.approx((0.0, 1000.0, 0.0), abs=1e-5)
    assert body.velocity == pytest.approx((0.0, 350.0, 0.0))


def test_yaw_turns_the_nose_to_the_fliers_right(limb):
    """It flies to posterior (+y) with proximal (+z) up, so that its right is +x."""
    body, _ = first_body(limb, replace(BULLET, yaw=0.3))
    assert body.rotation[:, 0] == pytest.approx((np.sin(0.3), np.cos(0.3), 0.0), abs=1e-5)
    assert body.velocity[0] == pytest.approx(0.0)


def test_a_blade_lies_along_the_limb_and_a_quarter_turn_lays_it_across(limb):
    upright, _ = first_body(limb, KNIFE)
    across, _ = first_body(limb, replace(KNIFE, roll=np.pi / 2))
    assert abs(upright.rotation[2, 2]) == pytest.approx(1.0, abs=1e-3)  # z of the body is its width
    assert abs(across.rotation[2, 2]) == pytest.approx(0.0, abs=1e-3)


def test_a_blade_that_does_not_reach_the_skin_is_refused(limb):
    with pytest.raises(ScenarioError, match="does not reach"):
        first_body(limb, replace(KNIFE, depth=-0.01))


def test_a_mesh_without_a_file_is_refused(limb):
    with pytest.raises(ScenarioError, match="STL"):
        first_body(limb, replace(BALL, shape="stl"))


def test_several_projectiles_each_have_their_line(limb):
    second = ShotParameters(
        projectile=FRAGMENT, aim=AimParameters(target=(0.0, 0.0, 0.01), azimuth=np.pi / 2)
    )
    setup = prepare_shot(limb, replace(AIMED, other_shots=(second,)))
    assert [body.name for body in setup.solver.bodies] == ["sphere", "cylinder"]
    assert setup.shots[1].direction == pytest.approx((-1.0, 0.0, 0.0))
    assert setup.solver.bodies[1].position[0] > 0.02
    # The window reaches as far around each of the two tracks.
    height = limb.position[setup.simulated, 2]
    assert height.max() == pytest.approx(0.035, abs=0.003)
    assert height.min() == pytest.approx(-0.025, abs=0.003)


def test_a_grazing_ball_touches_the_limb_beside_its_middle(limb):
    body, setup = first_body(limb, BALL, aim=AimParameters(target=(0.022, 0.0, 0.0)))
    assert setup.shot.beside[0] > 0.0
    assert body.position[0] == pytest.approx(0.022)
    assert -0.02 < body.position[1] < 0.0


def test_ends_absorb_only_where_the_window_cuts_the_limb(limb):
    from vulnus.injury.boundaries import AbsorbingEnds, HeldEnds
    from vulnus.injury.shot.setup import ends_of, window_of

    axis = np.array([0.0, 0.0, 1.0])
    height = np.asarray(limb.position, np.float64) @ axis
    _, setup = first_body(limb, BALL)
    kinds = {}
    for place, length in (("middle", 0.04), ("whole", None), ("end", 0.08)):
        shot = replace(setup.shot)
        if place == "end":
            shot = replace(shot, entry_point=(0, 0, 0.02), exit_point=(0, 0, 0.02))
        window = window_of(height, [shot], axis, length)
        kinds[place] = [type(end) for end in ends_of(window, AIMED)]
    assert kinds["middle"] == [AbsorbingEnds]
    assert kinds["whole"] == [HeldEnds]
    assert kinds["end"] == [HeldEnds, AbsorbingEnds]
