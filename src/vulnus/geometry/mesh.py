"""Measures of triangle surfaces, and particle data carried onto their vertices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vulnus.core.arrays import AnyArray, Float32Array, FloatArray
from vulnus.core.handoff import TriangleSurface


def _corners(surface: TriangleSurface) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The triangles' three corners, each (m, 3) [m], from the mesh's own middle."""
    vertices = surface.vertices.astype(np.float64)
    if len(vertices):
        vertices -= vertices.mean(axis=0)
    a, b, c = (vertices[surface.triangles[:, k]] for k in range(3))
    return a, b, c


def surface_area(surface: TriangleSurface) -> float:
    """Area of all triangles [m²]."""
    a, b, c = _corners(surface)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def surface_volume(surface: TriangleSurface) -> float:
    """Volume [m³] that a closed surface holds (divergence theorem); negative if turned inward."""
    a, b, c = _corners(surface)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def vertex_normals(surface: TriangleSurface) -> Float32Array:
    """Outward unit normals (n, 3) at the vertices: the triangles' own, weighted by area."""
    a, b, c = _corners(surface)
    weighted = np.cross(b - a, c - a)
    normal = np.stack(
        [
            sum(
                np.bincount(surface.triangles[:, k], weighted[:, axis], len(surface.vertices))
                for k in range(3)
            )
            for axis in range(3)
        ],
        axis=1,
    )
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(normal / np.maximum(length, np.finfo(float).tiny), dtype=np.float32)


def interpolate_to_vertices(
    surface: TriangleSurface,
    position: FloatArray | Float32Array,
    point_data: Mapping[str, AnyArray],
    *,
    radius: float,
    neighbours: int = 12,
) -> TriangleSurface:
    """The surface with particle data on its vertices.

    Each vertex takes the mean of its nearest particles (at most `neighbours`) weighted by
    (1 - d²/radius²)³, the poly6 shape of the paper's kernel, `radius` [m]; a vertex with no
    particle within `radius` takes its nearest one's value.
    """
    from scipy.spatial import cKDTree

    if not len(position) or not len(surface.vertices):
        return surface
    count = min(neighbours, len(position))
    tree = cKDTree(np.asarray(position, dtype=np.float64))
    distance, nearest = tree.query(surface.vertices.astype(np.float64), k=count, workers=-1)
    distance, nearest = np.reshape(distance, (-1, count)), np.reshape(nearest, (-1, count))
    weight = np.maximum(1.0 - (distance / radius) ** 2, 0.0) ** 3
    alone = weight.sum(axis=1) == 0.0
    weight[alone, 0] = 1.0
    weight /= weight.sum(axis=1, keepdims=True)
    data = dict(surface.vertex_data)
    for name, values in point_data.items():
        carried = np.einsum("ij,ij...->i...", weight, np.asarray(values)[nearest])
        data[name] = carried.astype(np.float32)
    return replace(surface, vertex_data=data)
