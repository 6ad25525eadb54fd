"""How large the holes in the skin are: what is destroyed, and what stands open."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, Vector3
from vulnus.core.handoff import TriangleSurface

GAP_SLACK = 1.25
"""How much wider than before the shot a gap between skin points may be before it is a hole;
chosen: unbroken skin around a collapsed cavity is hardly stretched."""

RIM = 0.25
"""How far skin reaches beyond its outermost points, over the spacing; chosen: half the distance of
neighbours in a skin two points thick, seen from outside."""

PIXELS_PER_SPACING = 4
"""Pixels a spacing of the points, for open areas; chosen: a hole of three spacings to 3 %."""


def open_area(
    reference: AnyArray,
    position: AnyArray,
    whole: BoolArray,
    *,
    centre: Vector3,
    radius: float,
    spacing: float,
) -> float:
    """Area [m²] around `centre` that no skin covers, seen along the skin's normal.

    `reference` and `position` (n, 3) [m] of skin points before and now, `whole` (n,) which of them
    hold. Gaps between points close by as much as they were wide before the shot (a morphological
    closing); skin farther than `radius` [m] from the centre is not looked at.
    """
    middle = np.asarray(centre, np.float64)
    offset = np.asarray(reference, np.float64) - middle
    near = np.linalg.norm(offset, axis=1) < radius
    if np.count_nonzero(near) < 4:
        return 0.0
    _, _, basis = np.linalg.svd(offset[near] - offset[near].mean(axis=0), full_matrices=False)
    before = offset[near] @ basis[:2].T
    now = (np.asarray(position, np.float64)[near] - middle) @ basis[:2].T
    pixel = spacing / PIXELS_PER_SPACING
    # Near the rim of what is looked at, skin that was drawn in leaves a gap that is no hole.
    seen = _distance_to(np.zeros((1, 2)), radius, pixel) < 0.75 * radius
    reach = GAP_SLACK * float(_distance_to(before, radius, pixel)[seen].max(initial=0.0))
    holding = now[np.asarray(whole)[near]]
    if len(holding) == 0:
        return float(np.count_nonzero(seen)) * pixel**2
    away = _distance_to(holding, radius, pixel)
    return _hole_in_raster(away > reach, seen, reach - RIM * spacing, pixel)


def _hole_in_raster(core: BoolArray, seen: BoolArray, growth: float, pixel: float) -> float:
    """Area [m²] of the hole nearest to the raster's middle: its `core`, grown by `growth` [m]."""
    from scipy.ndimage import distance_transform_edt, label

    if not (core & seen).any():
        return 0.0
    hole = (distance_transform_edt(~core) * pixel < growth) & seen
    pieces, _ = label(hole)
    half = len(seen) // 2
    axis = (np.arange(len(seen)) - half) * pixel
    from_middle = np.hypot(axis[:, None], axis[None, :])
    nearest = pieces.ravel()[int(np.argmin(np.where(hole, from_middle, np.inf)))]
    return float(np.count_nonzero(pieces == nearest)) * pixel**2


def _distance_to(points: FloatArray, radius: float, pixel: float) -> FloatArray:
    """Distance [m] of each pixel of a square of half side `radius` to the nearest point (n, 2)."""
    from scipy.spatial import cKDTree

    half = int(np.ceil(radius / pixel))
    axis = pixel * np.arange(-half, half + 1)
    raster = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)
    distance, _ = cKDTree(points).query(raster.reshape(-1, 2))
    return np.asarray(distance).reshape(raster.shape[:2])


def destroyed_skin(
    reference: AnyArray, position: AnyArray, damage: AnyArray, *, spacing: float, threshold: float
) -> BoolArray:
    """Which skin points (n,) are a barrier no more.

    Those with damage >= threshold, and those that the intact skin has left behind: fewer than half
    as many intact skin points within two spacings as skin points there were (the paper's
    "sufficiently dispersed").
    """
    from scipy.spatial import cKDTree

    failed = np.asarray(damage) >= threshold
    reach = 2.0 * spacing
    before = cKDTree(reference).query_ball_point(reference, reach, return_length=True)
    if not np.any(~failed):
        return np.ones(len(failed), np.bool_)
    after = cKDTree(position[~failed]).query_ball_point(position, reach, return_length=True)
    result: BoolArray = failed | (after < 0.5 * before)
    return result


def hole_area(
    skin_reference: AnyArray,
    skin_volume: AnyArray,
    destroyed: BoolArray,
    surface: TriangleSurface,
    *,
    centre: Vector3,
    radius: float,
) -> float:
    """Area [m²] of the hole in the skin around `centre`, measured on the undeformed skin.

    The share of the skin's volume within `radius` [m] that is destroyed, times the area of the skin
    surface within that radius; equal to the destroyed volume over the local thickness.
    """
    near = np.linalg.norm(skin_reference - np.asarray(centre), axis=1) < radius
    total = float(np.sum(skin_volume[near], dtype=np.float64))
    if total == 0.0:
        return 0.0
    share = float(np.sum(skin_volume[near & destroyed], dtype=np.float64)) / total
    return share * surface_area_near(surface, centre, radius)


def surface_area_near(surface: TriangleSurface, centre: Vector3, radius: float) -> float:
    """Area [m²] of a surface within `radius` of `centre`.

    Triangles across the edge are split until they are small against the radius.
    """
    corner = np.asarray(surface.vertices, np.float64)[surface.triangles]
    area = 0.0
    small = 0.1 * radius
    while len(corner):
        middle = corner.mean(axis=1)
        size = np.max(np.linalg.norm(corner - middle[:, None], axis=2), axis=1)
        distance = np.linalg.norm(middle - np.asarray(centre), axis=1)
        inside = (distance < radius) & ((size < small) | (distance + size < radius))
        edge = np.cross(
            corner[inside, 1] - corner[inside, 0], corner[inside, 2] - corner[inside, 0]
        )
        area += 0.5 * float(np.sum(np.linalg.norm(edge, axis=1)))
        corner = _split(corner[~inside & (size >= small) & (distance - size < radius)])
    return area


def _split(corner: FloatArray) -> FloatArray:
    """Every triangle (n, 3, 3) as its four halves."""
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
