"""What the shot did to the arteries: which are torn through or holed, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, Vector3
from vulnus.core.handoff import (
    ArteryCentreline,
    InjuredArtery,
    VesselInjury,
    VesselKind,
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


def destroyed_wall_share(
    stations: CentrelineStations,
    *,
    stretch: FloatArray,
    approach: FloatArray,
    wall_damage: FloatArray,
    failure_stretch: float,
) -> FloatArray:
    """Part (m,) of the wall's circumference that is destroyed at every station, 0-1.

    The largest of three. Stretch: the largest (m - 1,) that the pieces between stations have had,
    from half of the failure strain on, as the wall law softens, to all of it at failure. Contact:
    the arc that a straight edge cuts off the circular wall where the projectile's surface has come
    to within `approach` (m,) [m] of its middle,

        share = arccos(1 - 2 c) / pi,   c = (radius - approach) / (2 radius).

    And `wall_damage` (m,) of the wall's own material points.
    """
    largest = np.maximum(np.append(stretch, 1.0), np.insert(stretch, 0, 1.0))
    strain = np.log(np.maximum(largest, 1e-12)) / np.log(failure_stretch)
    by_stretch = np.clip((strain - YIELD_SHARE) / (1.0 - YIELD_SHARE), 0.0, 1.0)
    depth = np.clip((stations.radius - approach) / (2.0 * stations.radius), 0.0, 1.0)
    by_contact = np.arccos(1.0 - 2.0 * depth) / np.pi
    share: FloatArray = np.maximum(np.maximum(by_stretch, by_contact), wall_damage)
    return share


def swept_approach(stations: CentrelineStations, path: FloatArray, radius: float) -> FloatArray:
    """Least distance (m,) [m] of the undeformed stations to a tube of `radius` around `path`.

    `path` (k, 3) [m] is the way of the projectile's middle. At ballistic speeds tissue has not
    moved yet when the projectile's nose arrives, so that a vessel in its way does not slip aside.
    """
    if len(path) < 2:
        return np.full(len(stations.points), np.inf)
    begin, along = path[:-1], np.diff(path, axis=0)
    length = np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
    nearest = np.full(len(stations.points), np.inf)
    for start, step, square in zip(begin, along, length, strict=True):
        offset = stations.points - start
        where = np.clip(offset @ step / square, 0.0, 1.0)
        apart = np.linalg.norm(offset - where[:, None] * step, axis=1)
        nearest = np.minimum(nearest, apart)
    return nearest - radius


def piece_lengths(points: FloatArray) -> FloatArray:
    """Distances (m - 1,) [m] between successive stations, at least a picometre."""
    length: FloatArray = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.maximum(length, 1e-12)


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


@dataclass(frozen=True, slots=True, kw_only=True)
class WallThresholds:
    """Destroyed shares of the wall from which an artery is lacerated, and is transected."""

    lacerated: float
    transected: float


def find_injuries(
    stations: CentrelineStations, deformed: FloatArray, share: FloatArray, limit: WallThresholds
) -> list[VesselInjury]:
    """Every contiguous range of stations whose wall is torn through, or holed.

    A holed range that reaches a transection is the torn edge of that, no injury of its own.
    """
    torn = share >= limit.transected
    holed = share >= limit.lacerated
    found = [
        _vessel_injury(stations, deformed, share, ends, "transected") for ends in _ranges(torn)
    ]
    for first, last in _ranges(holed):
        if not torn[first : last + 1].any():
            found.append(_vessel_injury(stations, deformed, share, (first, last), "lacerated"))
    return found


def _ranges(chosen: BoolArray) -> list[tuple[int, int]]:
    """First and last index of every run of chosen stations."""
    padded = np.concatenate([[False], chosen, [False]])
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _vessel_injury(
    stations: CentrelineStations,
    deformed: FloatArray,
    share: FloatArray,
    ends: tuple[int, int],
    kind: VesselKind,
) -> VesselInjury:
    """The injury from station `ends[0]` to `ends[1]`; stumps are the stations next to it."""
    first, last = ends
    end = len(deformed) - 1
    proximal, distal = max(first - 1, 0), min(last + 1, end)
    arc = stations.arc_length
    begin_arc = 0.5 * (arc[proximal] + arc[first])
    end_arc = 0.5 * (arc[last] + arc[distal])
    middle = 0.5 * (begin_arc + end_arc)
    radius = float(np.interp(middle, arc, stations.radius))
    inside = slice(first, last + 1)
    around = 2.0 * np.pi * float(np.mean(share[inside] * stations.radius[inside]))
    stump_proximal, stump_distal = deformed[proximal], deformed[distal]
    return VesselInjury(
        artery=stations.name,
        arc_length=float(middle),
        arc_fraction=float(middle / arc[-1]),
        gap=float(end_arc - begin_arc),
        lumen_radius=radius,
        position=_vector(0.5 * (stump_proximal + stump_distal)),
        position_proximal=_vector(stump_proximal),
        position_distal=_vector(stump_distal),
        axis_proximal=_axis(deformed, stations.points, proximal, -1),
        axis_distal=_axis(deformed, stations.points, distal, +1),
        kind=kind,
        hole_area=np.pi * radius**2 if kind == "transected" else around * (end_arc - begin_arc),
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
    """Transections before lacerations, then by lumen area, then by destroyed length."""
    return tuple(
        sorted(injuries, key=lambda i: (i.kind != "transected", -i.lumen_radius, -i.gap, i.artery))
    )


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


def _vector(values: AnyArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
