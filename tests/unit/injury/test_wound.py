"""Cut and holed vessels, measured on made-up outcomes with known answers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vulnus.core.handoff import ArteryCentreline
from vulnus.injury.wound import artery_wall as wound

LIMITS = wound.WallThresholds(lacerated=0.1, transected=0.9)


def straight_artery(length: float = 0.1, points: int = 11) -> ArteryCentreline:
    """An artery that runs down from the origin, tapering from 1.5 to 1 mm."""
    line = np.column_stack([np.zeros((points, 2)), np.linspace(0.0, -length, points)])
    return ArteryCentreline("posterior_tibial", line, np.linspace(0.0015, 0.001, points))


def test_stations_keep_the_points_of_the_artery():
    artery = straight_artery()
    stations = wound.resample(artery, 0.0015)
    assert np.array_equal(stations.points[stations.original], artery.points)
    assert np.max(np.diff(stations.arc_length)) <= 0.0015
    assert stations.arc_length[-1] == pytest.approx(0.1)
    assert stations.radius[stations.original] == pytest.approx(artery.radius)


def test_a_torn_out_length_is_one_injury_with_two_stumps():
    """Destroyed from 40 to 50 mm of 100 mm, the rest pushed 5 mm in x."""
    stations = wound.resample(straight_artery(), 0.001)
    deformed = stations.points + np.array([0.005, 0.0, 0.0])
    inside = (stations.arc_length >= 0.04 - 1e-9) & (stations.arc_length <= 0.05 + 1e-9)
    found = wound.find_injuries(stations, deformed, inside.astype(float), LIMITS)
    assert len(found) == 1
    injury = found[0]
    assert injury.arc_length == pytest.approx(0.045)
    assert injury.arc_fraction == pytest.approx(0.45)
    assert injury.gap == pytest.approx(0.011)  # 11 stations of 1 mm
    assert injury.lumen_radius == pytest.approx(0.0015 - 0.45 * 0.0005)
    assert np.allclose(injury.position_proximal, (0.005, 0.0, -0.039))
    assert np.allclose(injury.position_distal, (0.005, 0.0, -0.051))
    assert np.allclose(injury.position, (0.005, 0.0, -0.045))
    assert np.allclose(injury.axis_proximal, (0.0, 0.0, -1.0))
    assert np.allclose(injury.axis_distal, (0.0, 0.0, 1.0))


def test_an_artery_torn_to_its_end_has_its_stump_there():
    stations = wound.resample(straight_artery(), 0.001)
    damage = (stations.arc_length > 0.095).astype(float)
    (injury,) = wound.find_injuries(stations, stations.points, damage, LIMITS)
    assert injury.position_distal[2] == pytest.approx(-0.1)
    assert np.isfinite(injury.axis_distal).all()
    assert np.linalg.norm(injury.axis_distal) == pytest.approx(1.0)


def test_an_intact_artery_has_no_injury():
    stations = wound.resample(straight_artery(), 0.001)
    assert wound.find_injuries(stations, stations.points, np.full(101, 0.09), LIMITS) == []


def share_of(stations, *, stretch=1.0, approach=np.inf, wall=0.0):
    count = len(stations.points)
    return wound.destroyed_wall_share(
        stations,
        stretch=np.full(count - 1, stretch),
        approach=np.full(count, approach),
        wall_damage=np.full(count, wall),
        failure_stretch=1.6,
    )


@pytest.mark.parametrize(("stretch", "cut"), [(1.0, False), (1.2, False), (1.7, True)])
def test_stretch_beyond_failure_destroys_the_wall(stretch, cut):
    share = share_of(wound.resample(straight_artery(), 0.001), stretch=stretch)
    assert np.all((share >= 0.9) == cut)
    assert np.all((share >= 0.0) & (share <= 1.0))


def test_a_straight_edge_through_the_middle_takes_half_of_the_circumference():
    stations = wound.resample(straight_artery(), 0.001)
    assert share_of(stations, approach=0.0) == pytest.approx(np.full(101, 0.5))
    # At a quarter of the diameter cos(a) = 1/2, so a = 60 of 180 degrees.
    share = wound.destroyed_wall_share(
        stations,
        stretch=np.ones(100),
        approach=0.5 * stations.radius,
        wall_damage=np.zeros(101),
        failure_stretch=1.6,
    )
    assert share == pytest.approx(np.full(101, 1.0 / 3.0))
    assert np.all(share_of(stations, approach=0.0016) == 0.0)  # it passes beside the wall
    assert np.all(share_of(stations, approach=-0.002) == 1.0)  # it takes all of it


def test_a_ball_beside_a_vessel_comes_as_near_as_geometry_says():
    """A tube of 4 mm around a line 5 mm beside the vessel leaves 1 mm; ends count as rounded."""
    stations = wound.resample(straight_artery(), 0.001)
    path = np.array([[0.005, -0.05, -0.05], [0.005, 0.0, -0.05], [0.005, 0.03, -0.05]])
    near = wound.swept_approach(stations, path, 0.004)
    assert near[50] == pytest.approx(0.001)
    assert near[60] == pytest.approx(math.hypot(0.005, 0.010) - 0.004)
    assert np.all(np.isinf(wound.swept_approach(stations, path[:1], 0.004)))


def test_a_part_of_the_wall_gone_is_a_laceration_with_its_area():
    """A third of the wall over 11 stations of 1 mm: a third of the mantle."""
    stations = wound.resample(straight_artery(), 0.001)
    inside = (stations.arc_length >= 0.04 - 1e-9) & (stations.arc_length <= 0.05 + 1e-9)
    share = np.where(inside, 1.0 / 3.0, 0.0)
    (injury,) = wound.find_injuries(stations, stations.points, share, LIMITS)
    assert injury.kind == "lacerated"
    radius = 0.0015 - 0.45 * 0.0005
    assert injury.hole_area == pytest.approx(2.0 * math.pi * radius * 0.011 / 3.0, rel=1e-3)


def test_torn_edges_belong_to_the_transection():
    stations = wound.resample(straight_artery(), 0.001)
    share = np.zeros(101)
    share[40:51], share[44:47] = 0.3, 1.0
    (injury,) = wound.find_injuries(stations, stations.points, share, LIMITS)
    assert injury.kind == "transected"
    assert injury.gap == pytest.approx(0.003)
    assert injury.hole_area == pytest.approx(math.pi * injury.lumen_radius**2)


def test_wall_points_speak_only_for_a_vessel_that_the_grid_resolves():
    stations = wound.resample(straight_artery(), 0.001)
    wall, damage = stations.points[::2], np.ones(51)
    assert np.all(wound.wall_point_damage(stations, wall, damage, 0.0009) == 1.0)
    assert np.all(wound.wall_point_damage(stations, wall, damage, 0.003) == 0.0)
    assert np.all(wound.wall_point_damage(stations, wall[:0], damage[:0], 0.0009) == 0.0)


def test_the_worst_injury_is_that_of_the_widest_vessel():
    wide = wound.resample(straight_artery(), 0.001)
    damage = np.zeros(101)
    damage[[10, 80, 81, 82]] = 1.0
    found = wound.find_injuries(wide, wide.points, damage, LIMITS)
    ordered = wound.worst_first(found)
    assert [round(injury.arc_fraction, 2) for injury in ordered] == [0.1, 0.81]


def test_a_transection_is_worse_than_a_laceration_of_a_wider_vessel():
    stations = wound.resample(straight_artery(), 0.001)
    share = np.zeros(101)
    share[5], share[80] = 0.5, 1.0
    ordered = wound.worst_first(wound.find_injuries(stations, stations.points, share, LIMITS))
    assert [injury.kind for injury in ordered] == ["transected", "lacerated"]
