"""The blood's surface: the paper's sequence on cases with a known answer."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from vulnus.core.handoff import TriangleSurface
from vulnus.geometry import surface_volume
from vulnus.visualization import BloodSurfaceParameters, blood_surface

SPACING = 1e-3


def ball(radius: float) -> np.ndarray:
    count = int(radius / SPACING) + 1
    axis = SPACING * np.arange(-count, count + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    return points[np.linalg.norm(points, axis=1) <= radius].astype(np.float32)


def edges_used_twice(surface: TriangleSurface) -> bool:
    triangles = surface.triangles
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return bool(np.all(counts == 2))


def test_surface_of_a_ball_is_watertight_outward_and_around_its_particles() -> None:
    radius = 0.01
    surface = blood_surface(ball(radius), SPACING, BloodSurfaceParameters())
    assert edges_used_twice(surface)
    assert surface_volume(surface) > 0.0
    distance = np.linalg.norm(surface.vertices, axis=1)
    # Spheres of one spacing about points up to the radius; the lattice leaves steps of up to one
    # spacing in the ball, and five iterations at this radius take less than a tenth of one.
    assert distance.max() < radius + 1.05 * SPACING
    assert distance.min() > radius - 0.1 * SPACING
    assert distance.mean() > radius + 0.3 * SPACING


def test_empty_frame_gives_an_empty_surface() -> None:
    surface = blood_surface(np.zeros((0, 3), np.float32), SPACING, BloodSurfaceParameters())
    assert surface.triangles.shape == (0, 3)


def test_particles_that_are_not_finite_are_left_out() -> None:
    points = np.concatenate([ball(3e-3), [[np.nan, 0.0, 0.0]]]).astype(np.float32)
    clean = blood_surface(ball(3e-3), SPACING, BloodSurfaceParameters())
    surface = blood_surface(points, SPACING, BloodSurfaceParameters())
    assert np.array_equal(surface.vertices, clean.vertices)


def test_a_single_drop_keeps_its_size_only_where_droplets_are_kept() -> None:
    drop = np.zeros((1, 3), np.float32)
    radius = {}
    for keep in (True, False):
        parameters = BloodSurfaceParameters(keep_droplets=keep)
        surface = blood_surface(drop, SPACING, parameters)
        radius[keep] = float(np.linalg.norm(surface.vertices, axis=1).max(initial=0.0))
    # The plain flow takes R² down by 2/3 h² a step: after 5 steps at h = R/2, R² is 1/6 of it.
    assert radius[False] < 0.5 * SPACING
    assert radius[True] > 0.8 * SPACING


def test_velocity_of_a_translation_arrives_on_every_vertex() -> None:
    points = ball(4e-3)
    velocity = np.broadcast_to([1.0, -2.0, 0.5], points.shape)
    surface = blood_surface(points, SPACING, BloodSurfaceParameters(), velocity=velocity)
    carried = surface.vertex_data["velocity"]
    assert carried.shape == surface.vertices.shape
    assert np.allclose(carried, [1.0, -2.0, 0.5], atol=1e-6)  # a weighted mean of equal values


def test_surface_moves_with_its_particles_by_whole_voxels() -> None:
    rng = np.random.default_rng(11)  # off the lattice, where equally near particles would tie
    points = ball(3e-3) + 0.1 * SPACING * rng.standard_normal((len(ball(3e-3)), 3))
    shift = np.array([7, -3, 11]) * 0.5 * SPACING
    first = blood_surface(points, SPACING, BloodSurfaceParameters())
    moved = blood_surface(points + shift, SPACING, BloodSurfaceParameters())
    distance, _ = cKDTree(moved.vertices - shift).query(first.vertices)
    # Positions pass through float32: 1e-9 m here; a vertex off its place is off by a voxel.
    assert distance.max() < 1e-2 * SPACING
