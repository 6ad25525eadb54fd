"""What a projectile left in an experiment: its path, its tract, holes, pieces of what broke."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError
from vulnus.core.wound_report import BoneReport, WoundTract

from ..bodies.rotations import Axis, axis_vector
from ..checked_values import finite, positive, vector
from ..wound.body_track import FlightPath
from ..wound.bone_fragments import bone_report
from ..wound.cavity import Cavity, find_cavity
from ..wound.skin_holes import open_area
from ..wound.tract import (
    arc_length_of,
    cavity_radius,
    destroyed_radius,
    points_in_limb,
)
from .deformation import least_spacing

if TYPE_CHECKING:
    from .fields import Fields
    from .result import RigidBodyRecord

BROKEN = 0.9
"""Damage from which tissue holds no more (PHYSICS 1.4: the barrier is what has D < 0.9)."""
REACH = 1.5
"""Distance over the particles' spacing within which a place is in tissue [chosen: between any]."""
FIRST_LOOK = 10.0
"""How far around a hole is looked first, over the particles' spacing [chosen]."""
SEEN = 0.75
"""Part of the radius that is looked at in which a hole is seen (`skin_holes.open_area`)."""
LARGEST_SHARE = 0.4
"""Part of what is seen that a hole may take, lest it reach farther [chosen: two thirds of it in
diameter]."""
LAYER = 2.0
"""Thickness over the particles' spacing of the surface in which a hole is looked for [chosen]."""


def flight_path(body: RigidBodyRecord) -> FlightPath:
    """The way of the body's foremost point from first contact to where it is deepest.

    There it stays; work that is done later counts there. Refused for a body that touched nothing.
    """
    beyond = np.flatnonzero(body.depth >= 0.0)
    if not len(beyond):
        raise ScenarioError(
            f"way of {body.name}",
            "it has not touched tissue up to the last sample",
            "Run longer, or check its direction.",
        )
    first, deepest = int(beyond[0]), int(np.nanargmax(body.depth))
    place = body.foremost.copy()
    place[deepest:] = place[deepest]
    part = 1.0
    if first > 0:
        step = body.depth[first] - body.depth[first - 1]
        part = float(body.depth[first] / step)

    last_before = max(first - 1, 0)

    def since_contact(values: FloatArray) -> FloatArray:
        contact = values[first] + part * (values[last_before] - values[first])
        return np.concatenate([[contact], values[first:]])

    return FlightPath(
        time=since_contact(body.time),
        position=since_contact(place),
        speed=since_contact(body.speed),
        work=np.concatenate([[0.0], body.work[first:]]),  # none is lost that nodes felt before
    )


def tract_of(
    body: RigidBodyRecord, states: Iterable[Fields], final: Fields, damage_threshold: float
) -> WoundTract:
    """The tract of a body; its temporary radius is that of the state with the largest cavity."""
    path = flight_path(body)
    spacing = float(np.cbrt(final.volume.mean()))
    points = points_in_limb(path, final.reference_position, REACH * spacing)
    permanent = cavity_of(final)
    temporary = max([permanent, *map(cavity_of, states)], key=lambda cavity: cavity.volume)
    broken = final.damage >= finite("damage_threshold", damage_threshold)
    return WoundTract(
        points=points,
        arc_length=arc_length_of(points),
        temporary_radius=cavity_radius(points, temporary),
        permanent_radius=cavity_radius(points, permanent),
        destroyed_radius=destroyed_radius(
            points, final.reference_position[broken], final.volume[broken]
        ),
    )


def cavity_of(fields: Fields) -> Cavity:
    """The empty space that all particles enclose."""
    spacing = float(np.cbrt(fields.volume.mean()))
    return find_cavity(fields.position, spacing, volume=fields.volume)


def fragments_of(
    fields: Fields, *, strain_rate: float | None, damage_threshold: float
) -> BoneReport:
    """The pieces of what has broken; see `Fields.fragments`."""
    if strain_rate is not None:
        positive("strain_rate", strain_rate)
    if len(fields) < 2:
        return BoneReport(mass=float(fields.mass.sum()), debris_mass=0.0, fragments=())
    return bone_report(
        fields.reference_position,
        fields.position,
        fields.mass,
        fields.damage < finite("damage_threshold", damage_threshold),
        spacing=least_spacing(fields.reference_position),
        strain_rate=strain_rate,
    )


def hole_in(
    fields: Fields,
    centre: Vector3,
    normal: Axis,
    *,
    radius: float | None,
    thickness: float | None,
    damage_threshold: float,
) -> float:
    """Area [m²] of a hole in a surface; see `Fields.hole_area`."""
    middle = np.asarray(vector("centre of the hole", centre))
    across = axis_vector("normal of the surface", normal)
    spacing = float(np.cbrt(fields.volume.mean()))
    depth = LAYER * spacing if thickness is None else positive("thickness", thickness)
    height = (fields.reference_position - middle) @ across
    surface = fields.where((height > -depth - 1e-6 * spacing) & (height < 0.5 * spacing))
    offset = np.linalg.norm(surface.reference_position - middle, axis=1)
    limit = float(offset.max(initial=0.0)) if radius is None else positive("radius", radius)
    if not (offset < max(limit, REACH * spacing)).any() or offset.min() > SEEN * limit:
        raise ScenarioError(
            "centre of the hole",
            f"{middle.round(6).tolist()} m: no tissue lay within {depth:g} m behind the surface",
            "Give a point on the undeformed surface, and the normal that points out of it.",
        )
    seen = min(limit, FIRST_LOOK * spacing)
    while True:
        area = open_area(
            surface.reference_position,
            surface.position,
            surface.damage < finite("damage_threshold", damage_threshold),
            centre=(float(middle[0]), float(middle[1]), float(middle[2])),
            radius=seen,
            spacing=spacing,
        )
        if seen >= limit or area < LARGEST_SHARE * np.pi * (SEEN * seen) ** 2:
            return area
        seen = min(1.5 * seen, limit)
