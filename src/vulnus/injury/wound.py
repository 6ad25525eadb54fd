"""What the shot did: which arteries are cut and where, and how large the holes in the skin are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, Vector3
from vulnus.core.handoff import (
    ArteryCentreline,
    InjuredArtery,
    TriangleSurface,
    VesselInjury,
)

YIELD_SHARE = 0.5
"""Part of the failure strain where stretch begins to damage the wall; chosen: half."""


@dataclass(frozen=True, slots=True, eq=False)
class CentrelineStations:
    """An artery resampled for the simulation: its own points and stations between them.

    `points` (m, 3) [m] and `radius` (m,) [m] of all stations, `arc_length` (m,) [m], and `original`
    (n,) the stations that are points of the centre-line.
    """

    name: str
    points: FloatArray
    radius: FloatArray
    arc_length: FloatArray
    original: AnyArray


def resample(artery: ArteryCentreline, spacing: float) -> CentrelineStations:
    """Stations at most `spacing` [m] apart that keep every point of the centre-line."""
    points = np.asarray(artery.points, np.float64)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    pieces = np.maximum(1, np.ceil(length / spacing - 1e-6).astype(int))
    original = np.concatenate([[0], np.cumsum(pieces)])
    parameter = np.concatenate(
        [i + np.arange(n) / n for i, n in enumerate(pieces)] + [np.array([float(len(pieces))])]
    )
    number = np.arange(len(points), dtype=np.float64)
    dense = np.stack([np.interp(parameter, number, points[:, a]) for a in range(3)], axis=1)
    steps = np.linalg.norm(np.diff(dense, axis=0), axis=1)
    return CentrelineStations(
        name=artery.name,
        points=dense,
        radius=np.interp(parameter, number, np.asarray(artery.radius, np.float64)),
        arc_length=np.concatenate([[0.0], np.cumsum(steps)]),
        original=original,
    )


def station_damage(
    stations: CentrelineStations,
    deformed: FloatArray,
    gap: FloatArray,
    wall_damage: FloatArray,
    failure_stretch: float,
) -> FloatArray:
    """Damage (m,) of the arterial wall at every station, 0 intact to 1 destroyed.

    The largest of three: the stretch of the centre-line (from half of the failure strain on, as the
    wall law softens), the part of the lumen's diameter that the projectile ran through (`gap` [m]
    is the smallest distance to its surface that the station came to), and `wall_damage` (m,) of the
    wall's own material points.
    """
    reference = np.linalg.norm(np.diff(stations.points, axis=0), axis=1)
    stretch = np.linalg.norm(np.diff(deformed, axis=0), axis=1) / np.maximum(reference, 1e-12)
    largest = np.maximum(np.append(stretch, 0.0), np.insert(stretch, 0, 0.0))
    strain = np.log(np.maximum(largest, 1e-12)) / np.log(failure_stretch)
    by_stretch = (strain - YIELD_SHARE) / (1.0 - YIELD_SHARE)
    by_contact = (stations.radius - gap) / (2.0 * stations.radius)
    damage: FloatArray = np.clip(np.maximum(by_stretch, by_contact), 0.0, 1.0)
    return np.maximum(damage, wall_damage)


def wall_point_damage(
    stations: CentrelineStations,
    wall_reference: AnyArray,
    damage: AnyArray,
    grid_spacing: float,
) -> FloatArray:
    """Mean damage (m,) of the artery's material points around each station, 0 where none is near.

    Near means within one and a half radii of the station, in the undeformed limb. Only where the
    vessel is two cells wide: in a thinner one the points feel what crushes the tissue around them,
    and a vessel that is pushed together is not torn.
    """
    if len(wall_reference) == 0:
        return np.zeros(len(stations.points))
    from scipy.spatial import cKDTree

    near = cKDTree(wall_reference).query_ball_point(stations.points, 1.5 * stations.radius)
    mean = np.array([np.mean(damage[index]) if index else 0.0 for index in near])
    return np.where(stations.radius >= grid_spacing, mean, 0.0)


def find_injuries(
    stations: CentrelineStations, deformed: FloatArray, damage: FloatArray, threshold: float
) -> list[VesselInjury]:
    """Every contiguous range of stations whose wall is destroyed (damage >= threshold)."""
    cut = np.concatenate([[False], damage >= threshold, [False]])
    edges = np.flatnonzero(cut[1:] != cut[:-1])
    return [
        _vessel_injury(stations, deformed, int(first), int(last) - 1)
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]


def _vessel_injury(
    stations: CentrelineStations, deformed: FloatArray, first: int, last: int
) -> VesselInjury:
    """The injury from station `first` to `last`; stumps are the intact stations next to it."""
    end = len(deformed) - 1
    proximal, distal = max(first - 1, 0), min(last + 1, end)
    arc = stations.arc_length
    begin_arc = 0.5 * (arc[proximal] + arc[first])
    end_arc = 0.5 * (arc[last] + arc[distal])
    middle = 0.5 * (begin_arc + end_arc)
    stump_proximal, stump_distal = deformed[proximal], deformed[distal]
    return VesselInjury(
        artery=stations.name,
        arc_length=float(middle),
        arc_fraction=float(middle / arc[-1]),
        gap=float(end_arc - begin_arc),
        lumen_radius=float(np.interp(middle, arc, stations.radius)),
        position=_vector(0.5 * (stump_proximal + stump_distal)),
        position_proximal=_vector(stump_proximal),
        position_distal=_vector(stump_distal),
        axis_proximal=_axis(deformed, stations.points, proximal, -1),
        axis_distal=_axis(deformed, stations.points, distal, +1),
    )


def _axis(deformed: FloatArray, reference: FloatArray, stump: int, inward: int) -> Vector3:
    """Unit vector out of the lumen of a stump whose vessel goes on to stump + inward."""
    behind = min(max(stump + 3 * inward, 0), len(deformed) - 1)
    vector = deformed[stump] - deformed[behind]
    if np.linalg.norm(vector) < 1e-9:  # the vessel ends here: its direction before the injury
        ahead = min(max(stump - inward, 0), len(reference) - 1)
        vector = reference[ahead] - reference[stump]
    length = float(np.linalg.norm(vector))
    return _vector(vector / length if length > 0.0 else np.array([0.0, 0.0, -float(inward)]))


def worst_first(injuries: list[VesselInjury]) -> tuple[VesselInjury, ...]:
    """By lumen area, then by destroyed length."""
    return tuple(sorted(injuries, key=lambda i: (-i.lumen_radius, -i.gap, i.artery)))


def injured_artery(
    artery: ArteryCentreline, stations: CentrelineStations, deformed: FloatArray, damage: FloatArray
) -> InjuredArtery:
    """The artery at its own points."""
    return InjuredArtery(
        name=artery.name,
        reference_points=np.asarray(artery.points, np.float64),
        points=np.ascontiguousarray(deformed[stations.original]),
        radius=np.asarray(artery.radius, np.float64),
        damage=np.ascontiguousarray(damage[stations.original]),
    )


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


def _vector(values: AnyArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
