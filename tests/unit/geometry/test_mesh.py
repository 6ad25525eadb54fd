"""Measures of meshes and particle data on their vertices."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.handoff import TriangleSurface
from vulnus.geometry import interpolate_to_vertices, surface_area, surface_volume, vertex_normals

TETRAHEDRON = TriangleSurface(
    vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32) + 50,
    triangles=np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32),
)


def test_area_and_volume_of_a_tetrahedron_far_from_the_origin():
    assert surface_volume(TETRAHEDRON) == pytest.approx(1 / 6, rel=1e-6)
    assert surface_area(TETRAHEDRON) == pytest.approx(1.5 + np.sqrt(3) / 2, rel=1e-6)


def test_normals_are_unit_and_outward():
    normals = vertex_normals(TETRAHEDRON)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-6)
    middle = TETRAHEDRON.vertices.mean(axis=0)
    assert (np.einsum("ij,ij->i", normals, TETRAHEDRON.vertices - middle) > 0).all()


def test_a_constant_field_stays_constant_and_a_linear_one_nearly():
    rng = np.random.default_rng(0)
    points = rng.uniform(49.5, 51.5, (4000, 3))
    velocity = points @ np.diag([1.0, 2.0, 3.0])
    carried = interpolate_to_vertices(
        TETRAHEDRON, points, {"one": np.ones(4000), "velocity": velocity}, radius=0.3
    )
    np.testing.assert_allclose(carried.vertex_data["one"], 1.0, rtol=1e-6)
    # Twelve neighbours of 4000 in 8 m³ lie within 0.2 m; their mean is off by a fraction of it.
    exact = TETRAHEDRON.vertices @ np.diag([1.0, 2.0, 3.0])
    assert np.abs(carried.vertex_data["velocity"] - exact).max() < 0.3


def test_a_vertex_without_neighbours_takes_the_nearest_value():
    far = np.array([[60.0, 50.0, 50.0], [0.0, 0.0, 0.0]])
    carried = interpolate_to_vertices(TETRAHEDRON, far, {"n": np.array([7.0, 1.0])}, radius=0.1)
    np.testing.assert_allclose(carried.vertex_data["n"], 7.0)
