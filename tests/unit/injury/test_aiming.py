"""The line of flight: where it comes from, where it crosses the skin, and when it is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import cylinder_surface, synthetic_limb

from vulnus.core.errors import AnatomyError, ProjectileError
from vulnus.core.handoff import TriangleSurface
from vulnus.injury import AimParameters, ProjectileParameters, aim
from vulnus.injury.shot.line import crossing_distances, flight_direction, line_point


@pytest.fixture(scope="module")
def limb():
    return synthetic_limb(spacing=0.004)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "direction"),
    [
        (0.0, 0.0, (0, 1, 0)),  # from anterior (-y), so it flies to posterior (+y)
        (90.0, 0.0, (-1, 0, 0)),  # from the patient's left (+x)
        (180.0, 0.0, (0, -1, 0)),
        (270.0, 0.0, (1, 0, 0)),
        (0.0, 90.0, (0, 0, -1)),  # from above
        (0.0, -30.0, (0, math.cos(math.pi / 6), 0.5)),
    ],
)
def test_azimuth_and_elevation_name_the_side_it_comes_from(azimuth, elevation, direction):
    parameters = AimParameters(azimuth=math.radians(azimuth), elevation=math.radians(elevation))
    assert np.allclose(flight_direction(parameters), direction, atol=1e-12)


def test_entry_and_exit_lie_on_the_cylinder(limb):
    shot = aim(limb, AimParameters(target=(0.005, 0.0, 0.01)), ProjectileParameters())
    depth = math.sqrt(0.02**2 - 0.005**2)
    # 1e-4: the mesh is a prism of 96 sides, its sagitta 1e-5.
    assert np.allclose(shot.entry_point, (0.005, -depth, 0.01), atol=1e-4)
    assert np.allclose(shot.exit_point, (0.005, depth, 0.01), atol=1e-4)
    assert shot.direction == (0.0, 1.0, 0.0)
    assert shot.speed == 350.0


def test_the_point_on_the_artery_is_a_fraction_of_its_length(limb):
    shot = aim(limb, AimParameters(artery="anterior_tibial", fraction=0.25))
    assert shot.entry_point[2] == pytest.approx(0.02, abs=1e-9)
    assert shot.entry_point[0] == pytest.approx(-0.003, abs=1e-9)


def test_a_target_behind_or_inside_gives_the_same_line(limb):
    lines = [aim(limb, AimParameters(target=(0.002, y, 0.0))) for y in (-0.3, 0.0, 0.019, 0.4)]
    for line in lines[1:]:
        assert np.allclose(line.entry_point, lines[0].entry_point, atol=1e-9)
        assert np.allclose(line.exit_point, lines[0].exit_point, atol=1e-9)


def test_direction_of_any_length_takes_precedence(limb):
    aimed = AimParameters(target=(0.0, 0.0, 0.0), azimuth=1.0, direction=(-7.0, 0.0, 0.0))
    shot = aim(limb, aimed)
    assert shot.direction == (-1.0, 0.0, 0.0)
    assert shot.entry_point[0] > 0.0


@pytest.mark.parametrize("length", [1e-300, 1e-9, 1e9, 1e300])
def test_a_direction_may_be_as_long_as_numbers_go(length):
    along = flight_direction(AimParameters(direction=(3.0 * length, 0.0, -4.0 * length)))
    assert np.allclose(along, (0.6, 0.0, -0.8), atol=1e-12)


def test_a_miss_says_by_how_much(limb):
    with pytest.raises(ProjectileError, match=r"passes 1[45]\.\d mm beside the limb") as error:
        aim(limb, AimParameters(target=(0.035, 0.0, 0.0)))
    assert error.value.exit_code == 5


def test_a_graze_with_the_edge_only_is_a_shot(limb):
    """The line passes 1.5 mm beside the cylinder, less than the ball's radius of 4.5 mm."""
    shot = aim(limb, AimParameters(target=(0.0215, 0.0, 0.01)), ProjectileParameters())
    # 1e-4: the mesh is a prism of 96 sides. The touched arc is that within 4.5 mm of the line.
    assert np.linalg.norm(shot.beside) < 0.0045
    assert np.dot(shot.beside, shot.direction) == pytest.approx(0.0, abs=1e-12)
    assert np.hypot(*shot.entry_point[:2]) == pytest.approx(0.02, abs=1e-4)
    assert shot.entry_point[0] >= 0.017 - 1e-4
    assert shot.entry_point[1] < 0.0 < shot.exit_point[1]
    assert line_point(shot)[[0, 2]] == pytest.approx((0.0215, 0.01), abs=1e-9)


def test_the_graze_ends_at_the_radius(limb):
    """4.4 mm beside is a shot, 4.6 mm beside is a miss that tells the distance."""
    aim(limb, AimParameters(target=(0.0244, 0.0, 0.0)), ProjectileParameters(diameter=0.009))
    with pytest.raises(ProjectileError, match=r"4\.6 mm beside the limb .its radius is 4\.5"):
        aim(limb, AimParameters(target=(0.0246, 0.0, 0.0)), ProjectileParameters(diameter=0.009))


def test_a_start_gives_the_direction(limb):
    aimed = AimParameters(target=(0.0, 0.0, 0.0), start=(0.1, 0.0, 0.0), azimuth=2.0)
    shot = aim(limb, aimed)
    assert shot.direction == (-1.0, 0.0, 0.0)
    assert shot.entry_point[0] == pytest.approx(0.02, abs=1e-4)


def test_a_start_on_the_skin_is_a_contact_shot(limb):
    shot = aim(limb, AimParameters(target=(0.0, 0.0, 0.0), start=(0.0, -0.0205, 0.0)))
    assert shot.entry_point[1] == pytest.approx(-0.02, abs=1e-4)


def test_a_start_inside_the_limb_is_refused_with_the_depth(limb):
    with pytest.raises(ProjectileError, match=r"inside the limb, about 8\.\d mm") as error:
        aim(limb, AimParameters(target=(0.0, 0.01, 0.0), start=(0.0, -0.012, 0.0)))
    assert error.value.subject == "injury.aim.start"


def test_a_start_that_is_the_target_or_flies_away_is_refused(limb):
    with pytest.raises(ProjectileError, match="no direction"):
        aim(limb, AimParameters(target=(0.1, 0.0, 0.0), start=(0.1, 0.0, 0.0)))
    with pytest.raises(ProjectileError, match="away from the limb"):
        aim(limb, AimParameters(target=(0.1, 0.0, 0.0), start=(0.05, 0.0, 0.0)))


@pytest.mark.parametrize(
    ("parameters", "projectile", "subject"),
    [
        (AimParameters(), ProjectileParameters(diameter=-0.009), "diameter"),
        (AimParameters(), ProjectileParameters(speed=0.0), "speed"),
        (AimParameters(), ProjectileParameters(speed=math.nan), "speed"),
        (AimParameters(artery="femoral"), ProjectileParameters(), "artery"),
        (AimParameters(artery=None), ProjectileParameters(), "artery"),
        (AimParameters(fraction=1.5), ProjectileParameters(), "fraction"),
        (AimParameters(direction=(0.0, 0.0, 0.0)), ProjectileParameters(), "direction"),
        (AimParameters(direction=(math.inf, 0.0, 0.0)), ProjectileParameters(), "direction"),
        (AimParameters(target=(math.inf, 0.0, 0.0)), ProjectileParameters(), "target"),
    ],
)
def test_bad_values_are_refused_by_name(limb, parameters, projectile, subject):
    with pytest.raises(ProjectileError) as error:
        aim(limb, parameters, projectile)
    assert subject in error.value.subject


def test_a_limb_without_skin_surface_is_refused(limb):
    with pytest.raises(AnatomyError):
        aim(replace(limb, surfaces={}), AimParameters(target=(0.0, 0.0, 0.0)))


def test_a_line_through_shared_edges_and_vertices_still_hits():
    """Lines through the vertices of a mesh must not slip between its triangles."""
    surface = cylinder_surface(0.02, 0.08)
    for vertex in np.asarray(surface.vertices, np.float64)[:-2:37]:
        towards = -np.array([vertex[0], vertex[1], 0.0])
        towards /= np.linalg.norm(towards)
        distance = crossing_distances(surface, vertex + 0.5 * towards, towards)
        inside = abs(vertex[2]) < 0.0399
        assert (len(distance) >= 2) or not inside


def test_first_and_last_crossing_of_a_folded_surface():
    """Two cylinders side by side: entry in the first, exit out of the second."""
    one = cylinder_surface(0.01, 0.05)
    shifted = np.asarray(one.vertices) + np.array([0.03, 0.0, 0.0], np.float32)
    both = TriangleSurface(
        np.concatenate([one.vertices, shifted]),
        np.concatenate([one.triangles, one.triangles + len(one.vertices)]),
    )
    distance = crossing_distances(both, np.zeros(3), np.array([1.0, 0.0, 0.0]))
    assert distance[0] == pytest.approx(-0.01, abs=1e-4)
    assert distance[-1] == pytest.approx(0.04, abs=1e-4)
