"""The projectile's straight line: where it enters and leaves the limb."""

from __future__ import annotations

import math

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import AnatomyError, ProjectileError
from vulnus.core.handoff import ArteryCentreline, LimbModel, ShotLine, TriangleSurface
from vulnus.core.units import MILLIMETRE

from ..parameters import AimParameters, ProjectileParameters


def aim(
    limb: LimbModel, aim: AimParameters, projectile: ProjectileParameters | None = None
) -> ShotLine:
    """Line of flight through the skin surface of `limb`.

    Entry is its first crossing of the skin, from `start` on where that is given, exit its last, so
    that a limb with a fold is crossed whole. Where only the projectile's edge meets the limb, they
    are the first and the last place of the skin that it touches. Raises `ProjectileError` where it
    misses, with the distance, and where it starts inside the limb.
    """
    projectile = projectile or ProjectileParameters()
    for name, value in (("diameter", projectile.diameter), ("speed", projectile.speed)):
        if not (math.isfinite(value) and value > 0.0):
            raise ProjectileError(
                f"injury.projectile.{name}",
                f"is {value:g} in SI units, must be > 0",
                "Give a positive number.",
            )
    skin = limb.surfaces.get("skin")
    if skin is None or len(skin.triangles) == 0:
        raise AnatomyError(
            "limb", "has no skin surface to aim at", "Check that the label volume holds a limb."
        )
    point = aim_point(limb, aim)
    direction = _direction_from(aim.start, point) if aim.start else flight_direction(aim)
    crossings = crossing_distances(skin, point, direction)
    if aim.start is not None:
        begin = float((np.array(aim.start) - point) @ direction)
        _refuse_bad_start(skin, np.array(aim.start), crossings - begin)
        crossings = crossings[crossings > begin]
    if len(crossings) >= 2:
        first, last = point + crossings[0] * direction, point + crossings[-1] * direction
        beside = np.zeros(3)
    else:
        first, last, beside = _graze(skin, point, direction, projectile.diameter)
    return ShotLine(
        entry_point=_vector(first),
        exit_point=_vector(last),
        direction=_vector(direction),
        diameter=projectile.diameter,
        speed=projectile.speed,
        beside=_vector(beside),
    )


def line_point(shot: ShotLine) -> FloatArray:
    """The point (3,) [m] on the line of the projectile's middle that is nearest to the entry."""
    point: FloatArray = np.asarray(shot.entry_point) + np.asarray(shot.beside)
    return point


def _direction_from(start: Vector3, point: FloatArray) -> FloatArray:
    """Unit vector (3,) of flight from `start` [m] through the point."""
    along = point - np.array(start, dtype=np.float64)
    length = float(np.linalg.norm(along))
    if not (math.isfinite(length) and length > 0.0):
        raise ProjectileError(
            "injury.aim.start",
            f"{start} gives no direction to the point that is aimed at",
            "Give another place.",
        )
    return np.asarray(along / length)


def _refuse_bad_start(skin: TriangleSurface, start: FloatArray, crossings: FloatArray) -> None:
    """Raise where the limb's crossings [m] from the start on show that it is behind skin.

    An odd number of them lies ahead then; and where all lie behind, it flies away from the limb.
    """
    ahead = crossings[crossings > 0.0]
    if len(crossings) and not len(ahead):
        raise ProjectileError(
            "injury.aim.start",
            f"lies {-float(crossings[-1]) / MILLIMETRE:.1f} mm behind the limb: the projectile "
            "flies away from the limb",
            "Put start_mm on the other side.",
        )
    distinct = 1 + int(np.count_nonzero(np.diff(ahead) > 1e-9)) if len(ahead) else 0
    if distinct % 2 == 0:
        return
    deep = float(np.min(np.linalg.norm(np.asarray(skin.vertices, np.float64) - start, axis=1)))
    raise ProjectileError(
        "injury.aim.start",
        f"lies inside the limb, about {deep / MILLIMETRE:.1f} mm below the skin: what is there "
        "already would overlap the projectile",
        "Put start_mm outside the skin, or leave it out.",
    )


def flight_direction(aim: AimParameters) -> FloatArray:
    """Unit vector of flight (3,): `direction`, or away from the side of azimuth and elevation."""
    if aim.direction is None:
        values: tuple[float, ...] = (aim.azimuth, aim.elevation)
        flat = math.cos(aim.elevation)
        vector = -np.array(
            [
                flat * math.sin(aim.azimuth),
                -flat * math.cos(aim.azimuth),
                math.sin(aim.elevation),
            ]
        )
    else:
        values = aim.direction
        vector = np.array(aim.direction, dtype=np.float64)
    if not (all(map(math.isfinite, values)) and np.any(vector)):
        raise ProjectileError(
            "injury.aim.direction", f"{values} has no direction", "Give a vector that is not zero."
        )
    vector /= np.abs(vector).max()  # so that no length overflows or vanishes when squared
    along: FloatArray = vector / np.linalg.norm(vector)
    return along


def aim_point(limb: LimbModel, aim: AimParameters) -> FloatArray:
    """The point (3,) [m] that the line goes through: the target, or a point on an artery."""
    if aim.target is not None:
        if not all(map(math.isfinite, aim.target)):
            raise ProjectileError("injury.aim.target", f"is {aim.target}", "Give finite numbers.")
        return np.array(aim.target, dtype=np.float64)
    names = [artery.name for artery in limb.arteries]
    if aim.artery is None or aim.artery not in names:
        known = ", ".join(names) or "none"
        raise ProjectileError(
            "injury.aim.artery",
            f"{aim.artery!r} is not an artery of this limb ({known})",
            "Name one of them or give target_mm.",
        )
    if not 0.0 <= aim.fraction <= 1.0:
        raise ProjectileError(
            "injury.aim.fraction", f"is {aim.fraction}, must be 0 to 1", "Correct the fraction."
        )
    return point_at_fraction(limb.arteries[names.index(aim.artery)], aim.fraction)


def point_at_fraction(artery: ArteryCentreline, fraction: float) -> FloatArray:
    """Point (3,) [m] at a fraction of the centre-line's length from its proximal end."""
    points = np.asarray(artery.points, np.float64)
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    where = fraction * arc[-1]
    return np.array([np.interp(where, arc, points[:, a]) for a in range(3)])


def crossing_distances(
    surface: TriangleSurface, point: FloatArray, direction: FloatArray
) -> FloatArray:
    """Signed distances [m] along the line, ascending, where it crosses the surface.

    Möller & Trumbore 1997. An edge hit counts for both of its triangles; the first and the last
    crossing are right all the same.
    """
    corner = np.asarray(surface.vertices, np.float64)[surface.triangles]
    edge1 = corner[:, 1] - corner[:, 0]
    edge2 = corner[:, 2] - corner[:, 0]
    normal = np.cross(direction, edge2)
    determinant = np.einsum("ij,ij->i", edge1, normal)
    usable = np.abs(determinant) > 1e-30
    inverse = np.where(usable, 1.0 / np.where(usable, determinant, 1.0), 0.0)
    offset = point - corner[:, 0]
    u = np.einsum("ij,ij->i", offset, normal) * inverse
    across = np.cross(offset, edge1)
    v = (across @ direction) * inverse
    slack = 1e-9  # of an edge: a line through a shared edge must not slip between the triangles
    hit = usable & (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack)
    distance: FloatArray = np.sort((np.einsum("ij,ij->i", edge2, across) * inverse)[hit])
    return distance


def _graze(
    skin: TriangleSurface, point: FloatArray, direction: FloatArray, diameter: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """First and last place (3,) [m] of the skin within the projectile's radius of the line.

    And the vector from the first to the line. Raises `ProjectileError` where there is none.
    """
    nearest = _nearest_on_edges(skin, point, direction)
    offset = nearest - point
    along = offset @ direction
    away = offset - along[:, None] * direction
    distance = np.linalg.norm(away, axis=1)
    miss, radius = float(distance.min()), 0.5 * diameter
    if miss >= radius:
        raise ProjectileError(
            "injury.aim",
            f"the projectile passes {miss / MILLIMETRE:.1f} mm beside the limb "
            f"(its radius is {radius / MILLIMETRE:.1f} mm)",
            "Move target_mm into the limb, or turn azimuth_deg, elevation_deg or direction.",
        )
    touched = np.flatnonzero(distance < radius)
    first = touched[int(np.argmin(along[touched]))]
    last = touched[int(np.argmax(along[touched]))]
    return nearest[first], nearest[last], -away[first]


def _nearest_on_edges(
    skin: TriangleSurface, point: FloatArray, direction: FloatArray
) -> FloatArray:
    """The place (3 m, 3) [m] of every triangle's three edges that is nearest to the line."""
    corner = np.asarray(skin.vertices, np.float64)[skin.triangles]
    begin = corner.reshape(-1, 3)
    step = np.roll(corner, -1, axis=1).reshape(-1, 3) - begin
    flat_begin = (begin - point) - ((begin - point) @ direction)[:, None] * direction
    flat_step = step - (step @ direction)[:, None] * direction
    square = np.maximum(np.einsum("ij,ij->i", flat_step, flat_step), 1e-30)
    where = np.clip(-np.einsum("ij,ij->i", flat_begin, flat_step) / square, 0.0, 1.0)
    return np.asarray(begin + where[:, None] * step)


def _vector(values: FloatArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
