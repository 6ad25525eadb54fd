"""Marching cubes: closed, manifold, outward, convergent."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vulnus.geometry import LevelSet, surface_area, surface_volume, vertex_normals

H = 1e-3


@settings(
    max_examples=10,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],  # the fixture is a pure function
)
@given(seed=st.integers(0, 10_000), filled=st.floats(0.1, 0.9))
def test_random_signs_give_a_closed_manifold(seed, filled, is_watertight):
    """Random values on 30³ voxels meet all 256 cases many times, next to all others."""
    rng = np.random.default_rng(seed)
    values = np.full((30, 30, 30), H, dtype=np.float32)
    values[1:-1, 1:-1, 1:-1] = H * (rng.uniform(size=(28, 28, 28)) - filled)
    level_set = LevelSet.from_dense(
        values, origin=np.full(3, -4 * H), spacing=np.full(3, H), direction=np.eye(3), voxel=H
    )
    surface = level_set.to_surface()
    assert is_watertight(surface)
    assert surface_volume(surface) > 0.0


def test_the_watertight_check_can_fail(is_watertight):
    surface = LevelSet.from_particles(np.zeros((1, 3)), 5e-3, voxel=H).to_surface()
    assert is_watertight(surface)
    holed = type(surface)(surface.vertices, surface.triangles[1:])
    assert not is_watertight(holed)


def test_cloud_after_flow_is_closed_and_has_no_empty_triangle(is_watertight):
    rng = np.random.default_rng(2)
    cloud = np.concatenate([rng.normal(0, 8e-3, (4000, 3)), rng.uniform(-0.05, 0.05, (300, 3))])
    surface = LevelSet.from_particles(cloud, 1e-3, voxel=0.5e-3).mean_curvature_flow(5).to_surface()
    assert is_watertight(surface)
    a, b, c = (surface.vertices[surface.triangles[:, k]].astype(float) for k in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 0.0


def test_a_mask_that_reaches_the_end_of_its_grid_is_closed(is_watertight):
    mask = np.zeros((40, 40, 40), dtype=bool)
    mask[5:, 8:30, :] = True
    level_set = LevelSet.from_mask(
        mask, origin=np.zeros(3), spacing=np.full(3, H), direction=np.eye(3), voxel=H
    )
    assert is_watertight(level_set.to_surface())
    assert is_watertight(level_set.mean_curvature_flow(5).to_surface())


def test_sphere_and_torus_have_their_topology(euler_characteristic):
    sphere = LevelSet.from_particles([[0.1, 0.2, 0.3]], 7.3e-3, voxel=H).to_surface()
    angle = np.linspace(0, 2 * np.pi, 200)
    ring = 0.02 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    torus = LevelSet.from_tube(ring, np.full(200, 5e-3), voxel=H).to_surface()
    assert euler_characteristic(sphere) == 2
    assert euler_characteristic(torus) == 0


def test_normals_point_outward():
    centre = np.array([0.1, -0.2, 0.3])
    surface = LevelSet.from_particles(centre[None], 8e-3, voxel=H).to_surface()
    radial = (surface.vertices - centre) / 8e-3
    # A triangle spans up to 1.7 voxels, 0.2 radians; its normal strays by half of that.
    assert np.einsum("ij,ij->i", radial, vertex_normals(surface)).min() > np.cos(0.1)


def test_area_and_volume_converge_at_second_order():
    """Two resolutions agree: halving the voxel quarters the error of a sphere's measures."""
    r, centre = 10e-3, [[0.01313, 0.0207, -0.4]]
    errors = []
    for voxel in (1e-3, 0.5e-3):
        surface = LevelSet.from_particles(centre, r, voxel=voxel).to_surface()
        errors.append(
            (
                1 - surface_volume(surface) / (4 / 3 * np.pi * r**3),
                1 - surface_area(surface) / (4 * np.pi * r**2),
            )
        )
    ratio = np.array(errors[0]) / np.array(errors[1])
    assert (np.array(errors[0]) < 0.01).all()
    assert (np.abs(np.log2(ratio) - 2) < 0.3).all()  # where the grid cuts the poles is chance


def test_vertices_lie_on_the_sphere():
    surface = LevelSet.from_particles(np.zeros((1, 3)), 10e-3, voxel=H).to_surface()
    off = np.abs(np.linalg.norm(surface.vertices, axis=1) - 10e-3)
    assert off.max() < H**2 / (8 * 10e-3) * 1.5  # linear interpolation: h² / 8R, and the clamp


@pytest.mark.parametrize("count", [1, 2])
def test_mesh_is_the_same_on_every_run(count, with_threads):
    with_threads(count)
    cloud = np.random.default_rng(4).normal(0, 5e-3, (500, 3))
    first, second = (
        LevelSet.from_particles(cloud, 1e-3, voxel=0.5e-3).to_surface() for _ in range(2)
    )
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()
