"""The tract's points and radii, and where along it the projectile's energy stayed."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury.wound.body_track import FlightPath
from vulnus.injury.wound.cavity import find_cavity
from vulnus.injury.wound.tract import (
    arc_length_of,
    cavity_radius,
    destroyed_radius,
    energy_along,
    points_in_limb,
)

SPACING = 0.002


def block(half=(0.03, 0.03, 0.03)):
    axes = [np.arange(-h, h, SPACING) + SPACING / 2 for h in half]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points + np.random.default_rng(4).uniform(-0.2, 0.2, points.shape) * SPACING


def straight(begin=-0.06, end=0.09, count=40) -> FlightPath:
    """A path along y at a falling speed that leaves 100 J on its way."""
    place = np.linspace(begin, end, count)
    return FlightPath(
        time=np.linspace(0.0, 5e-4, count),
        position=np.column_stack([0.004 + 0.0 * place, place, 0.0 * place]),
        speed=np.linspace(350.0, 200.0, count),
        work=np.interp(place, [-0.03, 0.03], [0.0, 100.0]),
    )


def test_the_tract_lies_between_the_two_surfaces():
    points = points_in_limb(straight(), block(), 1.5 * SPACING)
    assert points[0] == pytest.approx((0.004, -0.03, 0.0), abs=1.5 * SPACING)
    assert points[-1] == pytest.approx((0.004, 0.03, 0.0), abs=1.5 * SPACING)
    assert np.max(np.diff(arc_length_of(points))) <= 0.0021


def test_a_projectile_that_stops_ends_the_tract():
    points = points_in_limb(straight(end=0.0), block(), 1.5 * SPACING)
    assert points[-1][1] == pytest.approx(0.0, abs=1e-9)


def test_a_graze_has_a_short_tract_where_it_is_nearest():
    path = FlightPath(
        time=np.array([0.0, 1.0]),
        position=np.array([[0.035, -0.1, 0.0], [0.035, 0.1, 0.0]]),
        speed=np.full(2, 300.0),
        work=np.array([0.0, 1.0]),
    )
    points = points_in_limb(path, block(), 1.5 * SPACING)
    assert len(points) >= 2
    assert np.abs(points[:, 1]).max() < 0.035


def test_the_radius_of_a_round_tract_is_its_own():
    """5 % in the mean, as the volume; single points see the lattice, so 15 % there."""
    limb = block()
    radius = 0.008
    hollow = limb[np.hypot(limb[:, 0] - 0.004, limb[:, 2]) > radius]
    points = points_in_limb(straight(), limb, 1.5 * SPACING)[3:-3]
    found = cavity_radius(points, find_cavity(hollow, SPACING))[1:-1]
    assert np.mean(found) == pytest.approx(radius, rel=0.05)
    assert found == pytest.approx(np.full(len(found), radius), rel=0.15)


def test_the_radius_of_destroyed_tissue_counts_its_volume():
    limb = block()
    gone = np.hypot(limb[:, 0] - 0.004, limb[:, 2]) < 0.006
    points = points_in_limb(straight(), limb, 1.5 * SPACING)[3:-3]
    found = destroyed_radius(points, limb[gone], np.full(np.count_nonzero(gone), SPACING**3))
    assert np.mean(found[1:-1]) == pytest.approx(0.006, rel=0.05)
    assert np.all(destroyed_radius(points, limb[:0], np.zeros(0)) == 0.0)


def test_the_sum_of_the_energy_is_the_projectiles_loss():
    path = straight()
    deposit = energy_along(path)
    assert deposit.total == pytest.approx(100.0, rel=1e-12)
    assert np.all(deposit.energy >= 0.0)
    # Begins 30 mm before the surface: six empty bins of 5 mm, then 8.3 J each.
    assert deposit.energy[:5] == pytest.approx(np.zeros(5), abs=1e-9)
    assert deposit.energy[8] == pytest.approx(100.0 * 5 / 60, rel=1e-6)
    assert deposit.edges[-1] < 0.1  # and nothing is told of the way after it


@pytest.mark.parametrize("end", [-0.06, -0.0599999, -0.04])
def test_a_projectile_that_has_not_got_there_has_a_tract_without_length(end):
    points = points_in_limb(straight(end=end), block(), 1.5 * SPACING)
    assert 0.0 < arc_length_of(points)[-1] < 0.002
    assert np.all(np.isfinite(destroyed_radius(points, points[:1], np.full(1, 1e-9))))


def test_a_projectile_that_did_nothing_left_nothing():
    path = straight()
    idle = FlightPath(path.time, path.position, path.speed, np.zeros(len(path.time)))
    assert energy_along(idle).total == 0.0
