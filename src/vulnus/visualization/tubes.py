"""Arteries as tubes: their centre-lines swept by a circle, open where they are cut."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.arrays import FloatArray
from ..core.handoff import ArteryCentreline, InjuredArtery, TriangleSurface
from .surface import empty_surface, join_surfaces

_SIDES = 16  # chosen: round at the size arteries are drawn
_CUT = 0.5  # damage above which no wall is drawn


def tube(points: FloatArray, radius: FloatArray, *, sides: int = _SIDES) -> TriangleSurface:
    """A closed tube about a polyline `points` (n, 3) [m] with `radius` (n,) [m].

    The circle is carried along by parallel transport, so that the tube does not twist.
    """
    if points.shape[0] < 2:
        return empty_surface()
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    normal = np.zeros_like(points)
    start = np.eye(3)[int(np.argmin(np.abs(tangent[0])))]
    for index in range(points.shape[0]):
        carried = start - (start @ tangent[index]) * tangent[index]
        start = carried / max(float(np.linalg.norm(carried)), 1e-12)
        normal[index] = start
    binormal = np.cross(tangent, normal)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.cos(angle)[:, None] * normal[:, None] + np.sin(angle)[:, None] * binormal[:, None]
    body = points[:, None] + radius[:, None, None] * ring
    vertices = np.concatenate([body.reshape(-1, 3), points[:1], points[-1:]])
    return TriangleSurface(vertices.astype(np.float32), _tube_triangles(points.shape[0], sides))


def artery_tubes(
    arteries: Sequence[ArteryCentreline | InjuredArtery], *, widen: float = 1.25
) -> TriangleSurface:
    """All arteries in one surface, drawn `widen` times their lumen (the wall), gaps left open."""
    parts = [empty_surface()]
    for artery in arteries:
        whole = np.ones(artery.points.shape[0], dtype=bool)
        if isinstance(artery, InjuredArtery):
            whole = artery.damage < _CUT
        edges = np.flatnonzero(np.diff(np.concatenate([[False], whole, [False]]).astype(int)))
        parts += [
            tube(artery.points[first:last], widen * artery.radius[first:last])
            for first, last in edges.reshape(-1, 2)
        ]
    return join_surfaces(parts)


def _tube_triangles(rings: int, sides: int) -> np.ndarray[tuple[int, int], np.dtype[np.int32]]:
    ring, side = np.meshgrid(np.arange(rings - 1), np.arange(sides), indexing="ij")
    a = ring * sides + side
    b = ring * sides + (side + 1) % sides
    body = np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1).reshape(-1, 3)
    around, following = np.arange(sides), (np.arange(sides) + 1) % sides
    last = (rings - 1) * sides
    first_cap = np.stack([np.full(sides, rings * sides), following, around], axis=-1)
    last_cap = np.stack(
        [np.full(sides, rings * sides + 1), last + around, last + following], axis=-1
    )
    return np.concatenate([body, first_cap, last_cap]).astype(np.int32)
