"""Points of tissue as little balls for the ray tracer, as the paper draws them (Fig. 2)."""

from __future__ import annotations

import functools

import numpy as np

from ..core.arrays import BoolArray, Float32Array, FloatArray, IntArray, LabelArray
from ..core.handoff import Tissue, TriangleSurface
from .camera import Camera
from .surface import TissuePoints

FIGURE_2_LIGHT: dict[Tissue, tuple[float, float, float]] = {
    Tissue.SKIN: (0.78, 0.50, 0.055),  # yellow, red and white as in the paper's Fig. 2
    Tissue.FAT: (0.80, 0.30, 0.045),
    Tissue.MUSCLE: (0.42, 0.022, 0.020),
    Tissue.BONE: (0.86, 0.82, 0.74),
    Tissue.CANCELLOUS: (0.80, 0.70, 0.55),
    Tissue.MARROW: (0.74, 0.47, 0.36),
    Tissue.ARTERY: (0.80, 0.03, 0.12),
}
"""Linear RGB reflectance of each tissue's balls."""

_BALL_RADIUS = 0.62  # spacings; chosen: neighbours just touch, no light falls through whole tissue
_DARK = 0.45  # chosen: how much darker a ball of destroyed tissue is
_PLACE_WIDTH = 2.0  # spacings; chosen: no place of whole tissue is without a point
_OPAQUE_COUNT = 8  # points; chosen: two layers of whole tissue in one place
_KEPT_DEPTH = 12.0  # spacings behind the foremost ball; chosen: closes the gaps of a torn wall


def ball_surface(points: TissuePoints, *, round_balls: bool = True) -> TriangleSurface:
    """One mesh of a ball for each point, in the colours of the paper's Fig. 2.

    Without `round_balls` they have 20 sides in place of 80; smoothly shaded, a ball a few pixels
    wide looks the same.
    """
    corner, triangle = _unit_ball(round_balls=round_balls)
    count, corners = points.position.shape[0], corner.shape[0]
    radius = _BALL_RADIUS * points.spacing
    vertices = points.position[:, None, :] + np.float32(radius) * corner
    first = corners * np.arange(count, dtype=np.int32)
    triangles = first[:, None, None] + triangle
    colour = np.repeat(ball_colours(points.tissue, points.damage), corners, axis=0)
    return TriangleSurface(
        vertices.reshape(-1, 3).astype(np.float32),
        triangles.reshape(-1, 3).astype(np.int32),
        {"colour": colour, "roughness": np.full(count * corners, 0.42, np.float32)},
    )


def ball_colours(tissue: LabelArray, damage: Float32Array) -> Float32Array:
    """Linear RGB (n, 3): the paper's yellow, red and white, darker where torn."""
    table = np.full((256, 3), 0.5, np.float32)
    for code, colour in FIGURE_2_LIGHT.items():
        table[int(code)] = colour
    dark = 1.0 - _DARK * np.clip(damage, 0.0, 1.0)
    colours: Float32Array = np.take(table, tissue, axis=0) * dark[:, None].astype(np.float32)
    return colours


def seen_from(points: TissuePoints, camera: Camera) -> BoolArray:
    """Which points (n,) a camera may see.

    Points well behind the foremost ones of their place in the picture are left out, which spares
    the ray tracer millions of triangles.
    """
    if points.position.shape[0] == 0:
        return np.zeros(0, np.bool_)
    depth = (points.position - np.asarray(camera.origin)) @ camera.axes[2]
    before = depth < 0.0
    focal = 0.5 * camera.width / np.tan(0.5 * camera.field_of_view)
    distance = float(np.linalg.norm(np.subtract(camera.target, camera.origin)))
    cell = _PLACE_WIDTH * points.spacing * focal / distance
    pixels = camera.project(points.position[before])
    column, row = (_places(pixels[:, axis], cell) for axis in range(2))
    opaque = _opaque_depth(row, column, depth[before])
    # What a place hides is bounded by the least deep of its neighbours: light comes in aslant.
    padded = np.pad(opaque, 1, constant_values=-np.inf)
    shape = opaque.shape
    shifted = [padded[i : i + shape[0], j : j + shape[1]] for i in range(3) for j in range(3)]
    least = np.min(shifted, axis=0)
    seen = np.zeros(len(before), np.bool_)
    seen[before] = depth[before] > least[row, column] - _KEPT_DEPTH * points.spacing
    return seen


def _opaque_depth(row: IntArray, column: IntArray, depth: FloatArray) -> FloatArray:
    """How near (rows, columns) the eighth foremost point of each place is; -inf without points.

    Fewer points before whole tissue are debris, through which it is seen.
    """
    shape = (row.max(initial=0) + 1, column.max(initial=0) + 1)
    place = row.astype(np.int64) * shape[1] + column
    order = np.lexsort((-depth, place))
    first = np.flatnonzero(np.diff(place[order], prepend=-1))
    count = np.diff(first, append=len(order))
    chosen = order[first + np.minimum(count, _OPAQUE_COUNT) - 1]
    opaque = np.full(shape, -np.inf)
    opaque.flat[place[chosen]] = depth[chosen]
    return opaque


def _places(coordinate: FloatArray, cell: float) -> IntArray:
    places: IntArray = np.floor((coordinate - np.min(coordinate, initial=0.0)) / cell).astype(
        np.int32
    )
    return places


@functools.cache
def _unit_ball(*, round_balls: bool) -> tuple[Float32Array, IntArray]:
    """Corners and triangles of an icosahedron, its sides halved once for `round_balls`."""
    from scipy.spatial import ConvexHull

    golden = 0.5 * (1.0 + np.sqrt(5.0))
    signs = [(s, t * golden) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    corner = np.array(
        [(0.0, s, t) for s, t in signs]
        + [(s, t, 0.0) for s, t in signs]
        + [(t, 0.0, s) for s, t in signs]
    )
    if round_balls:
        faces = ConvexHull(corner).simplices
        sides = np.unique(
            np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0
        )
        corner = np.concatenate([corner, corner[sides].sum(axis=1)])
    corner /= np.linalg.norm(corner, axis=1, keepdims=True)
    hull = ConvexHull(corner).simplices
    side = corner[hull]
    outward = np.cross(side[:, 1] - side[:, 0], side[:, 2] - side[:, 0])
    inside_out = np.einsum("fc,fc->f", outward, side[:, 0]) < 0.0
    hull[inside_out] = hull[inside_out, ::-1]
    return corner.astype(np.float32), hull.astype(np.int32)
