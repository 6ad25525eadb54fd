"""The wound report: everything that can be counted at the end of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.handoff import LimbModel, ShotLine, Tissue
from vulnus.core.wound_report import (
    BoneReport,
    ProjectileFate,
    ProjectileReport,
    SkinHole,
    TissueField,
    VesselReport,
    WoundReport,
    WoundTract,
)

from . import skin_holes
from .bone_fragments import bone_report
from .cavity import Cavity, deposit, find_cavity, tissue_share
from .flying_bodies import shape_of
from .materials import TISSUE_MATERIALS
from .record import RunRecord, Snapshot
from .rigid_body import BodyState
from .shot_setup import ShotSetup
from .tract import (
    FlightPath,
    arc_length_of,
    cavity_radius,
    destroyed_radius,
    energy_along,
    points_in_limb,
)

BONE = (Tissue.BONE, Tissue.CANCELLOUS)

REST_SPEED = 1.0
"""Speed [m/s] below which a projectile has stopped; chosen: slower than tissue recoils."""

FIELD_MARGIN = 0.03
"""How far around the tract the field of damage reaches [m]; chosen: a temporary cavity's radius."""


@dataclass(frozen=True, slots=True, eq=False)
class LimbState:
    """The whole limb at one time: `position` (n, 3) [m] and `damage` (n,)."""

    position: AnyArray
    damage: AnyArray

    @classmethod
    def of(cls, setup: ShotSetup, snapshot: Snapshot) -> LimbState:
        """The simulated part as in the snapshot, the rest as before."""
        position = np.array(setup.limb.position, np.float32)
        position[setup.simulated] = snapshot.position
        damage = np.zeros(len(position), np.float32)
        damage[setup.simulated] = snapshot.damage
        return cls(position, damage)


def mean_spacing(limb: LimbModel) -> float:
    """Cube root of the volume that a material point stands for [m]."""
    return float(np.cbrt(np.mean(limb.volume, dtype=np.float64)))


def cavity_of(setup: ShotSetup, position: AnyArray) -> Cavity:
    """The cavity of the simulated part with its points at `position` (n, 3) [m]."""
    limb = setup.limb
    before = np.asarray(limb.position, np.float64)[setup.simulated]
    margin = 10.0 * mean_spacing(limb)  # tissue bulges, and debris that flies off is none
    return find_cavity(
        position,
        mean_spacing(limb),
        volume=limb.volume[setup.simulated],
        box=(before.min(axis=0) - margin, before.max(axis=0) + margin),
    )


def fates_of(setup: ShotSetup) -> list[ProjectileFate]:
    """What became of each projectile so far."""
    return [
        _fate(setup, body, shot)
        for body, shot in zip(setup.solver.bodies, setup.shots, strict=True)
    ]


def _fate(setup: ShotSetup, body: BodyState, shot: ShotLine) -> ProjectileFate:
    """Whether the body is out of the limb as it was, at rest in it, or still on its way.

    Out means farther than its radius and two cells from every material point.
    """
    margin = 2.0 * setup.parameters.grid_spacing
    offset = np.asarray(setup.limb.position, np.float64) - body.position
    nearest = float(np.sqrt(np.min(np.einsum("ij,ij->i", offset, offset))))
    along = float((body.position - np.asarray(shot.entry_point)) @ np.asarray(shot.direction))
    if nearest > 0.5 * shot.diameter + margin and (along > 0.0 or body.work > 0.0):
        return "left"
    return "stopped" if float(np.linalg.norm(body.velocity)) < REST_SPEED else "inside"


def makes_exit(setup: ShotSetup, number: int) -> bool:
    """Whether projectile `number` has left the limb at the far side; a blade leaves as it came."""
    shot, projectile = setup.shots[number], setup.projectiles[number]
    chord = float(np.linalg.norm(np.subtract(shot.exit_point, shot.entry_point)))
    through = projectile.shape != "blade" or projectile.depth > chord
    return through and fates_of(setup)[number] == "left"


def open_holes(setup: ShotSetup, state: LimbState) -> tuple[float, float]:
    """Areas [m²] of the holes in the skin at the entry and where the line leaves the limb.

    In the mode "paper" a hole is where skin points are fewer than half as dense as before,
    measured on the undeformed skin; else it is the gap between the skin that is not destroyed.
    """
    shot = setup.shot
    entry, exit_ = (
        _hole(setup, shot, state, point) for point in (shot.entry_point, shot.exit_point)
    )
    if setup.parameters.mode == "paper":
        return entry.destroyed_area, exit_.destroyed_area
    return entry.open_area, exit_.open_area


def _hole(setup: ShotSetup, shot: ShotLine, state: LimbState, centre: Vector3) -> SkinHole:
    limb, parameters = setup.limb, setup.parameters
    skin = np.flatnonzero(limb.tissue == Tissue.SKIN)
    if len(skin) == 0:
        return SkinHole(position=centre, open_area=0.0, destroyed_area=0.0)
    reference = np.asarray(limb.position[skin], np.float64)
    position, damage = state.position[skin], state.damage[skin]
    whole = damage < parameters.damage_threshold
    destroyed = ~whole
    if parameters.mode == "paper":
        destroyed = skin_holes.destroyed_skin(
            reference,
            position,
            damage,
            spacing=limb.spacing,
            threshold=parameters.damage_threshold,
        )
    return SkinHole(
        position=centre,
        open_area=skin_holes.open_area(
            reference,
            position,
            whole,
            centre=centre,
            radius=_seen_radius(shot, parameters.grid_spacing),
            spacing=mean_spacing(limb),
        ),
        destroyed_area=skin_holes.hole_area(
            reference,
            limb.volume[skin],
            destroyed,
            limb.surfaces["skin"],
            centre=centre,
            # Chosen: far enough for a hole of three calibres, near enough to tell entry from exit.
            radius=1.5 * shot.diameter + 3.0 * parameters.grid_spacing,
        ),
    )


def _seen_radius(shot: ShotLine, cell: float) -> float:
    """How far [m] around a hole the skin is looked at: a cavity's mouth, but not the other side."""
    chord = float(np.linalg.norm(np.subtract(shot.exit_point, shot.entry_point)))
    return max(1.5 * shot.diameter + 3.0 * cell, min(3.0 * shot.diameter + 4.0 * cell, 0.6 * chord))


def _projectile_report(
    setup: ShotSetup,
    number: int,
    *,
    path: FlightPath,
    end: LimbState,
    cavities: tuple[Cavity, Cavity],
) -> ProjectileReport:
    """What projectile `number` did, from its path and the cavities, the largest and the last."""
    limb, body, shot = setup.limb, setup.solver.bodies[number], setup.shots[number]
    projectile, fate = setup.projectiles[number], fates_of(setup)[number]
    if projectile.shape == "blade":
        reach = float(shape_of(projectile).upper[0])
        path = path.thrust(reach * np.asarray(body.rotation)[:, 0], shot.speed)
    points = points_in_limb(path, limb.position, 1.5 * limb.spacing)
    destroyed = end.damage >= setup.parameters.damage_threshold
    begin, last = float(path.speed[0]), float(path.speed[-1])
    mass = projectile.mass if projectile.motion == "dynamic" else None
    return ProjectileReport(
        name=body.name,
        fate=fate,
        position=_vector(body.position),
        speed_before=begin,
        speed_after=last,
        energy_before=None if mass is None else 0.5 * mass * begin**2,
        energy_after=None if mass is None else 0.5 * mass * last**2,
        tract=WoundTract(
            points=points,
            arc_length=arc_length_of(points),
            temporary_radius=cavity_radius(points, cavities[0]),
            permanent_radius=cavity_radius(points, cavities[1]),
            destroyed_radius=destroyed_radius(
                points, limb.position[destroyed], limb.volume[destroyed]
            ),
        ),
        entry=_hole(setup, shot, end, shot.entry_point),
        exit=_hole(setup, shot, end, _vector(points[-1])) if makes_exit(setup, number) else None,
        energy=energy_along(path),
    )


def wound_report(
    setup: ShotSetup, record: RunRecord, *, end: LimbState, vessels: Sequence[VesselReport]
) -> WoundReport:
    """All of the report, at the end of the run."""
    largest = record.largest
    last = cavity_of(setup, end.position[setup.simulated])
    first = last if largest is None else cavity_of(setup, largest.position)
    projectiles = tuple(
        _projectile_report(
            setup, number, path=record.flight(number), end=end, cavities=(first, last)
        )
        for number in range(len(setup.shots))
    )
    return WoundReport(
        projectiles=projectiles,
        vessels=tuple(vessels),
        bone=_bone(setup, end),
        cavity=record.history,
        field=tissue_field(setup.limb, end, np.concatenate([p.tract.points for p in projectiles])),
        temporary_time=setup.solver.time if largest is None else largest.time,
        particle_count=len(setup.simulated),
        steps=setup.solver.steps,
        flight_steps=record.flight_steps,
    )


def _bone(setup: ShotSetup, end: LimbState) -> BoneReport:
    limb = setup.limb
    bone = np.flatnonzero(np.isin(limb.tissue, BONE))
    density = np.array([TISSUE_MATERIALS[Tissue(code)].density for code in limb.tissue[bone]])
    return bone_report(
        limb.position[bone],
        end.position[bone],
        limb.volume[bone] * density,
        end.damage[bone] < setup.parameters.damage_threshold,
        spacing=limb.spacing,
    )


def tissue_field(limb: LimbModel, end: LimbState, tract: FloatArray) -> TissueField:
    """Mean damage and missing tissue at the nodes of a box around the tract (n, 3) [m]."""
    spacing = mean_spacing(limb)
    lower, upper = tract.min(axis=0) - FIELD_MARGIN, tract.max(axis=0) + FIELD_MARGIN
    shape = np.ceil((upper - lower) / spacing).astype(int) + 1
    points = np.asarray(end.position, np.float64)
    near = np.all((points > lower - 3 * spacing) & (points < upper + 3 * spacing), axis=1)
    grid = {"origin": lower - 3 * spacing, "cell": spacing, "shape": shape + 6}
    share = tissue_share(points[near], limb.volume[near], spacing, **grid)
    weight = np.asarray(limb.volume[near], np.float64) / spacing**3
    whole = deposit(points[near], weight, **grid)
    broken = deposit(points[near], weight * end.damage[near], **grid)
    inner = (slice(3, -3),) * 3
    return TissueField(
        origin=_vector(lower),
        cell=spacing,
        damage=np.where(whole > 0.0, broken / np.maximum(whole, 1e-6), 0.0)[inner],
        void=np.clip(1.0 - share, 0.0, 1.0)[inner],
    )


def _vector(values: AnyArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
