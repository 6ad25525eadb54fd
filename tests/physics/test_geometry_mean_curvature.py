"""Mean curvature flow: R² of a sphere falls linearly, a plane stands, drops vanish or are kept."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.geometry import LevelSet, surface_volume

pytestmark = pytest.mark.physics
H = 1e-3


def radius_square(level_set: LevelSet) -> float:
    """R² [voxel²] of the sphere with the mesh's volume."""
    return float((surface_volume(level_set.to_surface()) * 3 / 4 / np.pi) ** (2 / 3)) / H**2


@pytest.mark.parametrize("radius", [8, 12, 24])
def test_square_of_a_sphere_radius_falls_by_two_thirds_of_a_voxel_square_a_step(radius):
    sphere = LevelSet.from_particles([[0.01313, 0.0207, -0.4]], radius * H, voxel=H)
    fall = radius_square(sphere) - radius_square(sphere.mean_curvature_flow(5))
    # 10/3 in five steps. The one Godunov step after each moves the zero level inward by first
    # order, 7-10 % of the flow's own step at every radius (measured: 1.10).
    assert fall / (10 / 3) == pytest.approx(1.08, abs=0.06)


def test_the_fall_is_linear_in_time():
    sphere = LevelSet.from_particles([[0.01313, 0.0207, -0.4]], 16 * H, voxel=H)
    at = [radius_square(sphere.mean_curvature_flow(n)) for n in (0, 10, 20, 30)]
    falls = -np.diff(at)
    assert falls == pytest.approx(falls.mean(), rel=0.06)  # the shift by re-distancing grows slowly


def test_a_plane_does_not_move():
    normal = np.array([1.0, 2.0, -2.0]) / 3
    plane = LevelSet.from_function(
        lambda p: p @ normal, bounds=((-0.02,) * 3, (0.02,) * 3), voxel=H
    ).mean_curvature_flow(5)
    points = np.random.default_rng(0).uniform(-8e-3, 8e-3, (200, 3))
    points -= np.outer(points @ normal, normal)
    # The kink where the band is clamped, three voxels off, reaches it a little.
    assert np.abs(plane.sample(points)).max() < 1e-3 * H


def test_redistancing_alone_keeps_a_sphere():
    sphere = LevelSet.from_particles([[0.01313, 0.0207, -0.4]], 12 * H, voxel=H)
    moved = np.sqrt(radius_square(sphere)) - np.sqrt(radius_square(sphere.redistance(5)))
    assert 0.0 <= moved < 0.015  # voxels; first order, (5/2)·0.3·h/R at most


def lattice_drop(count: int, spacing: float) -> np.ndarray:
    axis = spacing * np.arange(-5, 6)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    order = np.argsort((points**2).sum(axis=1), kind="stable")
    return points[order[:count]] + [0.2e-3, 0.1e-3, 0.3e-3]


def volume_kept(count: int, *, keep_droplets: bool) -> float:
    spacing = 2 * H
    drop = LevelSet.from_particles(
        lattice_drop(count, spacing), spacing, voxel=H, keep_droplets=keep_droplets
    )
    return drop.mean_curvature_flow(5).volume() / drop.volume()


def test_five_steps_eat_single_drops_and_spare_large_ones():
    """The design note measured -97 % for one particle, -20 % for 33, -4 to -7 % for 257."""
    assert volume_kept(1, keep_droplets=False) < 0.15
    assert volume_kept(33, keep_droplets=False) == pytest.approx(0.8, abs=0.06)
    assert volume_kept(257, keep_droplets=False) == pytest.approx(0.945, abs=0.025)


def test_weights_by_neighbours_keep_single_drops():
    # One re-distance step each still takes a little of a drop of two voxels' radius.
    assert volume_kept(1, keep_droplets=True) > 0.75
    assert volume_kept(33, keep_droplets=True) > volume_kept(33, keep_droplets=False)
    large = [volume_kept(257, keep_droplets=keep) for keep in (True, False)]
    assert large[0] == pytest.approx(large[1], abs=0.03)
