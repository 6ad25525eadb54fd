"""Holes in the skin: what is destroyed and what stands open, on made-up skins."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vulnus.core.handoff import TriangleSurface
from vulnus.injury.wound import skin_holes

SPACING = 0.001


def plate(thickness: float = 0.002, half: float = 0.03):
    """Skin points of a plate in z = 0, and its outer surface of two triangles."""
    edge = np.arange(-half, half, SPACING) + SPACING / 2
    depth = -(np.arange(int(thickness / SPACING)) + 0.5) * SPACING
    x = np.stack(np.meshgrid(edge, edge, depth, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = half * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    surface = TriangleSurface(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    return x, np.full(len(x), SPACING**3), surface


def hole_of(x, volume, surface, damage, position=None):
    destroyed = skin_holes.destroyed_skin(
        x, x if position is None else position, damage, spacing=SPACING, threshold=0.9
    )
    return skin_holes.hole_area(x, volume, destroyed, surface, centre=(0.0, 0.0, 0.0), radius=0.02)


def test_the_area_of_a_round_hole_of_destroyed_skin():
    """A disc of radius 6 mm; 5 %: the lattice of 1 mm points renders its rim."""
    x, volume, surface = plate()
    damage = (np.hypot(x[:, 0], x[:, 1]) < 0.006).astype(float)
    assert hole_of(x, volume, surface, damage) == pytest.approx(math.pi * 0.006**2, rel=0.05)


def test_skin_that_is_pulled_apart_is_a_hole_too():
    """Undamaged points blown away to four times their distance: dispersed, so no barrier."""
    x, volume, surface = plate()
    far = np.hypot(x[:, 0], x[:, 1]) < 0.006
    position = x.copy()
    position[far] = 6.0 * x[far] - np.array([0.0, 0.0, 0.05])
    area = hole_of(x, volume, surface, np.zeros(len(x)), position)
    assert area == pytest.approx(math.pi * 0.006**2, rel=0.1)


def test_whole_skin_has_no_hole_and_stretched_skin_neither():
    x, volume, surface = plate()
    assert hole_of(x, volume, surface, np.zeros(len(x))) == 0.0
    # 10 % stretch leaves more than half of the neighbours within reach.
    assert hole_of(x, volume, surface, np.full(len(x), 0.5), 1.1 * x) == 0.0


def test_damage_elsewhere_is_not_counted():
    x, volume, surface = plate()
    damage = (x[:, 0] > 0.025).astype(float)
    assert hole_of(x, volume, surface, damage) == 0.0


def test_surface_area_near_a_point_does_not_depend_on_the_triangles():
    """Two large triangles: the disc of 20 mm has 4 pi 1e-4 m²; 2 % by splitting to a tenth."""
    _, _, surface = plate()
    area = skin_holes.surface_area_near(surface, (0.0, 0.0, 0.0), 0.02)
    assert area == pytest.approx(math.pi * 0.02**2, rel=0.02)


def open_of(x, whole, position=None, *, centre=(0.0, 0.0, 0.0), radius=0.025):
    return skin_holes.open_area(
        x,
        x if position is None else position,
        whole,
        centre=centre,
        radius=radius,
        spacing=SPACING,
    )


def jittered_plate(seed=1):
    x, _, _ = plate()
    return x + np.random.default_rng(seed).uniform(-0.3, 0.3, x.shape) * SPACING


@pytest.mark.parametrize(("radius", "error"), [(0.003, 0.12), (0.006, 0.08), (0.012, 0.05)])
def test_the_open_area_of_a_round_hole(radius, error):
    """A quarter of the points' spacing of 1 mm in the radius: the closing rounds the rim."""
    x = jittered_plate()
    whole = np.hypot(x[:, 0], x[:, 1]) > radius
    assert open_of(x, whole) == pytest.approx(math.pi * radius**2, rel=error)


def test_whole_skin_is_closed_also_where_its_points_are_pushed_about():
    x = jittered_plate()
    assert open_of(x, np.ones(len(x), bool)) == 0.0
    bulged = x + np.array([0.0, 0.0, 1.0]) * np.exp(-(x[:, :1] ** 2) / 1e-4) * 0.01
    assert open_of(x, np.ones(len(x), bool), bulged) == 0.0


def test_destroyed_skin_under_skin_that_has_sprung_back_is_no_open_hole():
    """A disc of 4 mm is destroyed; the skin around has been pulled in over it."""
    x = jittered_plate()
    away = np.hypot(x[:, 0], x[:, 1])
    whole = away > 0.004
    drawn_in = x.copy()
    inward = np.clip(1.0 - 0.0045 * (0.02 - away) / 0.016 / np.maximum(away, 1e-6), 0.0, 1.0)
    near = away < 0.02
    drawn_in[near, :2] *= inward[near, None]
    closed = open_of(x, whole, drawn_in)
    assert closed < 0.1 * open_of(x, whole)


def test_skin_that_is_torn_without_loss_and_pulled_open_is_a_hole():
    """No point is destroyed; the halves of the skin are 8 mm apart over 20 mm."""
    x = jittered_plate()
    opened = x.copy()
    opened[:, 0] += np.sign(x[:, 0]) * 0.004 * (np.abs(x[:, 1]) < 0.01)
    assert open_of(x, np.ones(len(x), bool), opened) == pytest.approx(0.008 * 0.02, rel=0.15)


def test_the_hole_that_counts_is_the_one_in_the_middle():
    x = jittered_plate()
    whole = (np.hypot(x[:, 0], x[:, 1]) > 0.005) & (np.hypot(x[:, 0] - 0.014, x[:, 1]) > 0.003)
    assert open_of(x, whole) == pytest.approx(math.pi * 0.005**2, rel=0.08)


def test_the_open_area_does_not_depend_on_how_the_skin_lies():
    from scipy.spatial.transform import Rotation

    x = jittered_plate()
    whole = np.hypot(x[:, 0], x[:, 1]) > 0.006
    turn = Rotation.from_rotvec([0.4, -0.9, 0.3]).as_matrix()
    turned = x @ turn.T + np.array([0.3, -0.2, 0.1])
    assert open_of(turned, whole, centre=(0.3, -0.2, 0.1)) == pytest.approx(
        open_of(x, whole), rel=0.03
    )


def test_where_there_is_no_skin_there_is_no_hole():
    x = jittered_plate()
    assert open_of(x, np.ones(len(x), bool), centre=(1.0, 0.0, 0.0)) == 0.0
