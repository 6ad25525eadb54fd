"""The wound report: everything that can be counted at the end of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.handoff import LimbModel, ProjectileHoles, ShotLine, Tissue
from vulnus.core.wound_report import (
    BoneReport,
    ProjectileReport,
    SkinHole,
    TissueField,
    VesselReport,
    WoundReport,
    WoundTract,
)

from ..materials import TISSUE_MATERIALS
from ..wound import skin_holes
from ..wound.bone_fragments import bone_report
from ..wound.cavity import Cavity, deposit, find_cavity, tissue_share
from ..wound.tract import arc_length_of, cavity_radius, destroyed_radius, energy_along
from .body_filling import body_filling
from .projectile_way import ProjectileWay
from .record import RunRecord, Snapshot, poses
from .report_notes import notes_of
from .run_end import collapse_time
from .setup import ShotSetup

BONE = (Tissue.BONE, Tissue.CANCELLOUS)

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


def cavity_of(setup: ShotSetup, position: AnyArray, bodies: FloatArray) -> Cavity:
    """The cavity of the simulated part with its points at `position` (n, 3) [m].

    Room that the projectiles fill, which lie as `bodies` (b, 12) says (`record.poses`), is none.
    """
    limb, spacing = setup.limb, mean_spacing(setup.limb)
    before = np.asarray(limb.position, np.float64)[setup.simulated]
    margin = 10.0 * spacing  # tissue bulges, and debris that flies off is none
    filled = [
        body_filling(body.shape, pose, spacing)
        for body, pose in zip(setup.bodies, bodies, strict=True)
    ]
    return find_cavity(
        np.concatenate([position, *(body.position for body in filled)]),
        spacing,
        volume=np.concatenate([limb.volume[setup.simulated], *(body.volume for body in filled)]),
        box=(before.min(axis=0) - margin, before.max(axis=0) + margin),
    )


def open_holes(
    setup: ShotSetup, ways: Sequence[ProjectileWay], state: LimbState
) -> tuple[ProjectileHoles, ...]:
    """Areas of the holes in the skin that each projectile has made.

    In the mode "paper" a hole is where skin points are fewer than half as dense as before,
    measured on the undeformed skin; else it is the gap between the skin that is not destroyed.
    """
    holes = []
    for shot, way in zip(setup.shots, ways, strict=True):
        entry, out = shot.entry_point, way.exit_place
        holes.append(
            ProjectileHoles(
                entry_point=entry,
                entry_area=_seen_area(setup, _hole(setup, shot, state, entry)),
                exit_point=out,
                exit_area=None
                if out is None
                else _seen_area(setup, _hole(setup, shot, state, out)),
            )
        )
    return tuple(holes)


def _seen_area(setup: ShotSetup, hole: SkinHole) -> float:
    return hole.destroyed_area if setup.parameters.mode == "paper" else hole.open_area


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
    way: ProjectileWay,
    *,
    end: LimbState,
    cavities: tuple[Cavity, Cavity],
) -> ProjectileReport:
    """What projectile `number` did, from its way and the cavities, the largest and the last."""
    limb, body, shot = setup.limb, setup.solver.bodies[number], setup.shots[number]
    projectile, points = setup.projectiles[number], way.points
    destroyed = end.damage >= setup.parameters.damage_threshold
    last = float(way.middle.speed[-1])
    mass = projectile.mass if projectile.motion == "dynamic" else None
    return ProjectileReport(
        name=body.name,
        fate=way.fate,
        position=_vector(body.position),
        speed_before=shot.speed,
        speed_after=last,
        energy_before=None if mass is None else 0.5 * mass * shot.speed**2,
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
        exit=None if way.exit_place is None else _hole(setup, shot, end, way.exit_place),
        energy=energy_along(way.foremost),
        cells_across=projectile.diameter / setup.parameters.grid_spacing,
    )


def wound_report(
    setup: ShotSetup,
    record: RunRecord,
    ways: Sequence[ProjectileWay],
    *,
    end: LimbState,
    vessels: Sequence[VesselReport],
) -> WoundReport:
    """All of the report, at the end of the run."""
    largest, now = record.largest, poses(setup.solver.bodies)
    last = cavity_of(setup, end.position[setup.simulated], now)
    first = last if largest is None else cavity_of(setup, largest.position, largest.bodies)
    projectiles = tuple(
        _projectile_report(setup, number, way, end=end, cavities=(first, last))
        for number, way in enumerate(ways)
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
        collapse_time=collapse_time(record.history),
        notes=notes_of(setup, record.history),
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
        strain_rate=max(shot.speed / shot.diameter for shot in setup.shots),
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
