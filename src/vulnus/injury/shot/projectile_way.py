"""Each projectile's way through the limb, and what became of it: out, at rest, or on its way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.handoff import LimbModel
from vulnus.core.wound_report import ProjectileFate

from ..bodies.contact_way import Outline
from ..bodies.rigid_body import BodyState
from ..bodies.shape_distance import distance_to
from ..bodies.shapes import Shape
from ..wound.body_track import FlightPath, rest_speed
from ..wound.tract import points_in_limb
from .flying_bodies import OUT_CELLS
from .record import RunRecord
from .setup import ShotSetup

REACH = 1.5
"""Distance over the points' spacing within which a place is in the limb; chosen: between any."""


@dataclass(frozen=True, slots=True, eq=False)
class ProjectileWay:
    """A projectile's way: of its `middle`, of its foremost point, and that in the limb (n, 3) [m].

    `exit_place` [m] is where it has made a hole at the far side, None where it has made none.
    """

    middle: FlightPath
    foremost: FlightPath
    points: FloatArray
    fate: ProjectileFate
    exit_place: Vector3 | None


def ways_of(setup: ShotSetup, record: RunRecord) -> list[ProjectileWay]:
    """The ways of all projectiles so far."""
    return [_way(setup, record, number, fate) for number, fate in enumerate(fates_of(setup))]


def _way(setup: ShotSetup, record: RunRecord, number: int, fate: ProjectileFate) -> ProjectileWay:
    track, shot = record.tracks[number], setup.shots[number]
    outline = Outline.of(setup.bodies[number].shape)
    foremost = track.foremost(outline, np.asarray(shot.direction))
    points = points_in_limb(foremost, setup.limb.position, REACH * setup.limb.spacing)
    x, y, z = (float(c) for c in points[-1])
    return ProjectileWay(
        middle=track.middle,
        foremost=foremost,
        points=points,
        fate=fate,
        exit_place=(x, y, z) if leaves_exit(setup, number, fate) else None,
    )


def fates_of(setup: ShotSetup) -> list[ProjectileFate]:
    """What became of each projectile so far.

    Out means that its surface is farther than two cells from every point of the limb as it was;
    it begins in contact with the limb. At rest is one that moves no faster than tissue recoils.
    """
    return [_fate(setup, number) for number in range(len(setup.shots))]


def _fate(setup: ShotSetup, number: int) -> ProjectileFate:
    body = setup.solver.bodies[number]
    if is_out(
        setup.limb, setup.bodies[number].shape, body, OUT_CELLS * setup.parameters.grid_spacing
    ):
        return "left"
    if setup.solver.time < setup.thrust_end and setup.bodies[number].path is not None:
        return "inside"
    slow = rest_speed(setup.shots[number].speed)
    return "stopped" if float(np.linalg.norm(body.velocity)) < slow else "inside"


def is_out(limb: LimbModel, shape: Shape, body: BodyState, margin: float) -> bool:
    """Whether the body's surface is farther than `margin` [m] from every point of the limb."""
    local = (np.asarray(limb.position, np.float64) - body.position) @ body.rotation
    near = np.all((local > shape.lower - margin) & (local < shape.upper + margin), axis=1)
    return not near.any() or bool(distance_to(shape, local[near]).min() > margin)


def leaves_exit(setup: ShotSetup, number: int, fate: ProjectileFate) -> bool:
    """Whether projectile `number` has made a hole at the far side.

    A blade leaves as it came, and has made one where it was thrust through; what is thrown back
    out of the limb has made none.
    """
    shot, projectile = setup.shots[number], setup.projectiles[number]
    if projectile.shape == "blade":
        chord = float(np.linalg.norm(np.subtract(shot.exit_point, shot.entry_point)))
        return projectile.depth > chord
    onwards: FloatArray = setup.solver.bodies[number].velocity @ np.asarray(shot.direction)
    return fate == "left" and float(onwards) > 0.0
