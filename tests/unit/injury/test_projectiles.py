"""The table of projectiles: masses that fit their sizes, bodies that fly as told."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vulnus.core.errors import ScenarioError
from vulnus.injury.bodies.attitude import attitude
from vulnus.injury.bodies.projectiles import PROJECTILES, projectile

LEAD, STEEL = 11340.0, 7850.0


@pytest.mark.parametrize("name", PROJECTILES)
def test_every_projectile_has_a_source_and_makes_a_body(name):
    row = projectile(name)
    assert row.name == name
    assert row.source
    assert row.speed_range[0] <= row.speed <= row.speed_range[1]
    body = row.body((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    assert body.mass == row.mass
    assert np.linalg.norm(body.velocity) == pytest.approx(row.speed)
    assert body.shape.upper[0] > 0.0


@pytest.mark.parametrize("name", [n for n, row in PROJECTILES.items() if row.shape != "blade"])
def test_its_mass_fits_its_size(name):
    """Steel balls and fragments to 5 %; bullets lie between steel and lead."""
    row = projectile(name)
    density = row.mass / row.solid().volume
    if row.shape == "ogive":
        assert 0.9 * STEEL < density < 1.05 * LEAD
    else:
        assert density == pytest.approx(STEEL, rel=0.05)


def test_a_bullet_takes_its_inertia_from_its_shape_and_its_own_mass():
    row = projectile("9x19_fmj")
    shape = row.solid()
    body = row.body((0, 0, 0), (1, 0, 0))
    assert np.allclose(body.inertia, shape.unit_inertia * row.mass / shape.volume)
    assert body.inertia[1, 1] > body.inertia[0, 0] > 0.0


def test_attitude_turns_as_a_flier_sees_it():
    """Flight along +y, z up: the right is +x."""
    nose = attitude((0, 2, 0), yaw=math.radians(30))[:, 0]
    assert np.allclose(nose, (0.5, math.sqrt(0.75), 0.0))
    nose = attitude((0, 1, 0), pitch=math.radians(30))[:, 0]
    assert np.allclose(nose, (0.0, math.sqrt(0.75), 0.5))
    width = attitude((0, 1, 0))[:, 2]
    assert np.allclose(width, (0.0, 0.0, 1.0))
    width = attitude((0, 1, 0), roll=math.radians(90))[:, 2]
    assert np.allclose(width, (1.0, 0.0, 0.0))  # clockwise from behind: the top goes to the right


def test_attitude_has_an_answer_for_a_flight_straight_up():
    turn = attitude((0, 0, 1))
    assert np.allclose(turn @ turn.T, np.eye(3))
    assert np.allclose(turn[:, 0], (0, 0, 1))


def test_spin_is_about_the_nose_and_follows_the_twist():
    row = projectile("5.56_m193")
    assert row.spin == pytest.approx(2.0 * math.pi * 990.0 / 0.305)
    body = row.body((0, 0, 0), (0, 1, 0), yaw=0.05, spin=row.spin)
    assert np.allclose(body.angular_velocity, row.spin * body.turn[:, 0])


def test_a_stab_goes_in_and_comes_out():
    body = projectile("knife").stab((0.0, -0.02, 0.0), (0, 1, 0), depth=0.03, speed=5.0, gap=0.002)
    tip = np.asarray(body.path.positions) + body.turn @ [body.shape.upper[0], 0.0, 0.0]
    assert np.allclose(tip, [(0, -0.022, 0), (0, 0.01, 0), (0, -0.022, 0)], atol=1e-12)
    assert body.path.times[-1] == pytest.approx(2 * 0.032 / 5.0)
    assert body.cutting


def test_an_unknown_projectile_is_refused_with_the_nearest_name():
    with pytest.raises(ScenarioError, match="9x19_fmj"):
        projectile("9x19fmj")
    with pytest.raises(ScenarioError, match="no blade"):
        projectile("22lr").stab((0, 0, 0), (0, 1, 0))
