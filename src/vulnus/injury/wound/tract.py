"""The tract: the way of the projectile's foremost point in the limb, and what it left there."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray
from vulnus.core.wound_report import EnergyDeposit

from .body_track import FlightPath
from .cavity import Cavity

STATION_SPACING = 2e-3
"""Distance of the tract's points [m]; chosen: a cell of the usual grid."""

SHORTEST = 1e-6
"""Length of a tract that has none [m], of a projectile that has hardly begun; chosen: not 0."""

ENERGY_BIN = 5e-3
"""Length of path over which energy is summed [m]; chosen: about a projectile's diameter."""

NO_MORE_WORK = 1e-3
"""Part of the energy whose place of deposit does not matter any more; chosen: far below its error.
It is counted to the last bin."""

NEAR_TRACT = 0.06
"""How far from the tract destroyed tissue is counted to it [m]; chosen: a large cavity's radius."""


def points_in_limb(path: FlightPath, limb_points: AnyArray, reach: float) -> FloatArray:
    """The path (n, 3) [m] at even steps, from where it enters the limb to where it leaves it.

    Inside is what lies within `reach` [m] of a material point of the undeformed limb. At least two
    points: where the path is nearest to the limb, if it grazes it with the projectile's edge only.
    """
    from scipy.spatial import cKDTree

    arc = path.arc_length
    if arc[-1] < SHORTEST:
        return np.stack([path.position[0], path.position[0] + np.array([SHORTEST, 0.0, 0.0])])
    count = max(2, int(np.ceil(arc[-1] / (0.25 * STATION_SPACING))) + 1)
    where = np.linspace(0.0, arc[-1], count)
    fine = _on_path(path.position, arc, where)
    distance = np.asarray(cKDTree(np.asarray(limb_points)).query(fine)[0])
    inside = np.flatnonzero(distance <= max(reach, float(distance.min()) * 1.05))
    begin, end = where[inside[0]], where[inside[-1]]
    begin = max(0.0, min(begin, end - SHORTEST))
    end = max(end, begin + SHORTEST)
    stations = max(2, round((end - begin) / STATION_SPACING) + 1)
    return _on_path(path.position, arc, np.linspace(begin, end, stations))


def arc_length_of(points: FloatArray) -> FloatArray:
    """Length (n,) [m] along points (n, 3) [m] since the first."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def cavity_radius(points: FloatArray, cavity: Cavity) -> FloatArray:
    """Radius (n,) [m] of a circle with the cavity's section at each point of the tract."""
    return _radius_of(points, cavity.centres, cavity.void)


def destroyed_radius(points: FloatArray, destroyed: AnyArray, volume: AnyArray) -> FloatArray:
    """Radius (n,) [m] of a circle with the section of destroyed tissue at each point.

    `destroyed` (m, 3) [m] are its material points as they lay before, `volume` (m,) [m³].
    """
    return _radius_of(points, np.asarray(destroyed, np.float64), np.asarray(volume, np.float64))


def _radius_of(points: FloatArray, place: FloatArray, volume: FloatArray) -> FloatArray:
    """From the volume (m,) [m³] along the tract, shared linearly between neighbouring points."""
    arc = arc_length_of(points)
    step = arc[-1] / (len(points) - 1)
    where, near = _along_tract(points, arc, place)
    within = near & (where > -0.5 * step) & (where < arc[-1] + 0.5 * step)
    number = np.clip(where[within] / step, 0.0, len(points) - 1.0)
    low = np.minimum(number.astype(np.int64), len(points) - 2)
    part = number - low
    total = np.bincount(low, volume[within] * (1.0 - part), minlength=len(points))
    total += np.bincount(low + 1, volume[within] * part, minlength=len(points))
    return np.asarray(np.sqrt(np.maximum(total, 0.0) / (np.pi * step)))


def _along_tract(
    points: FloatArray, arc: FloatArray, place: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Length along the tract [m] of the nearest place on it, and whether that is near."""
    from scipy.spatial import cKDTree

    if len(place) == 0:
        return np.zeros(0), np.zeros(0, np.bool_)
    distance, index = cKDTree(points).query(place)
    tangent = np.gradient(points, arc, axis=0)
    offset = np.einsum("ij,ij->i", place - points[index], tangent[index])
    return arc[index] + offset, np.asarray(distance) < NEAR_TRACT


def energy_along(path: FlightPath, interval: float = ENERGY_BIN) -> EnergyDeposit:
    """Work of the projectile in pieces of `interval` [m], up to where it does no more."""
    arc = path.arc_length
    last = int(np.searchsorted(path.work, path.work[-1] * (1.0 - NO_MORE_WORK)))
    end = max(float(arc[min(last, len(arc) - 1)]), interval)
    pieces = int(np.ceil(end / interval - 1e-9))
    edges = interval * np.arange(pieces + 1, dtype=np.float64)
    work = np.interp(edges, arc, path.work)
    work[-1] = path.work[-1]
    return EnergyDeposit(edges=edges, energy=np.diff(work))


def _on_path(position: FloatArray, arc: FloatArray, where: FloatArray) -> FloatArray:
    return np.stack([np.interp(where, arc, position[:, axis]) for axis in range(3)], axis=1)
