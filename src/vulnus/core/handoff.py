"""The frozen, SI-valued types that stages hand to each other; nothing else crosses between them.

CT or label volume -> `LabelVolume` -> `LimbModel` -> `InjuredLimb` -> (tree and blood) ->
`BleedLedger`. Positions are metres in the patient frame, LPS: x to the patient's left,
y to posterior, z to superior. Arrays are C-contiguous and must not be written to.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from .arrays import AnyArray, Float32Array, FloatArray, IntArray, LabelArray, Vector3
from .wound_report import (
    BoneFragment,
    BoneReport,
    CavityHistory,
    EnergyDeposit,
    ProjectileReport,
    SkinHole,
    TissueField,
    VesselKind,
    VesselReport,
    WoundReport,
    WoundTract,
)

__all__ = [
    "ArteryCentreline",
    "BleedLedger",
    "BleedOutcome",
    "BleedWaveforms",
    "BoneFragment",
    "BoneReport",
    "CavityHistory",
    "EnergyDeposit",
    "InjuredArtery",
    "InjuredLimb",
    "InjuryOutcome",
    "LabelVolume",
    "LimbModel",
    "ParticleFrame",
    "ProjectileHoles",
    "ProjectileReport",
    "ShotLine",
    "SkinHole",
    "Tissue",
    "TissueField",
    "TriangleSurface",
    "VesselInjury",
    "VesselKind",
    "VesselReport",
    "WoundReport",
    "WoundTract",
]


class Tissue(IntEnum):
    """What a voxel or a material point is made of.

    0-4 are the five-label convention (air, skin, soft tissue, bone, artery); volumes that tell
    more apart use the codes behind them. `MUSCLE` stands for all soft tissue where nothing finer
    is known, `BONE` for whole or cortical bone.
    """

    AIR = 0
    SKIN = 1
    MUSCLE = 2
    BONE = 3
    ARTERY = 4
    FAT = 5
    MARROW = 6
    CANCELLOUS = 7


@dataclass(frozen=True, slots=True, eq=False)
class ArteryCentreline:
    """One artery as a polyline with radii, ordered from proximal to distal.

    `name` is the field's term in snake case without side: popliteal, anterior_tibial,
    posterior_tibial, fibular. `points` (n, 3) [m], LPS; `radius` (n,) [m], of the lumen;
    `parent` names the artery it leaves, or None.
    """

    name: str
    points: FloatArray
    radius: FloatArray
    parent: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LabelVolume:
    """A limb as labelled voxels.

    `labels` (nx, ny, nz) of `Tissue` codes, array axes i, j, k; the centre of voxel (i, j, k) lies
    at `origin + direction @ (spacing * (i, j, k))`. `origin` (3,) [m], `spacing` (3,) [m],
    `direction` (3, 3) with unit columns. `source` says where it comes from, for provenance;
    `side` is "left" or "right".
    """

    labels: LabelArray
    origin: FloatArray
    spacing: FloatArray
    direction: FloatArray
    arteries: tuple[ArteryCentreline, ...]
    source: str
    side: str = "left"


@dataclass(frozen=True, slots=True, eq=False)
class TriangleSurface:
    """A triangle mesh: `vertices` (n, 3) [m], `triangles` (m, 3) indices, outward by right hand.

    `vertex_data` maps a name to an (n,) or (n, 3) array on the vertices.
    """

    vertices: Float32Array
    triangles: IntArray
    vertex_data: Mapping[str, AnyArray] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class LimbModel:
    """The limb as material points of one Poisson-disk set, with its arteries and surfaces.

    `position` (n, 3) [m]; `tissue` (n,) of `Tissue` codes; `volume` (n,) [m³], whose sum is the
    limb's; `spacing` [m] the Poisson-disk radius (smallest distance of two points). `surfaces`
    maps "skin" (outer), "bone" and each "artery" to meshes for barriers and pictures.
    """

    position: Float32Array
    tissue: LabelArray
    volume: Float32Array
    spacing: float
    arteries: tuple[ArteryCentreline, ...]
    surfaces: Mapping[str, TriangleSurface]
    side: str
    source: str


@dataclass(frozen=True, slots=True, eq=False)
class InjuredArtery:
    """An artery after the passage: the same points as its centre-line, moved by the tissue.

    `reference_points` and `points` (n, 3) [m]; `radius` (n,) [m] before the injury; `damage` (n,)
    from 0 (intact) to 1 (no wall left).
    """

    name: str
    reference_points: FloatArray
    points: FloatArray
    radius: FloatArray
    damage: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class VesselInjury:
    """Where an artery is cut through or holed.

    `kind` is "transected" or "lacerated"; `hole_area` [m²] of what blood can leave through: the
    lumen's section where it is transected, else the part of the wall that is gone.

    `arc_length` [m] from the artery's proximal end, along the reference centre-line, to the middle
    of the gap; `arc_fraction` of its whole length; `gap` [m] the destroyed length;
    `lumen_radius` [m] there; `position_proximal` and `position_distal` [m] the two stumps in the
    injured limb, `axis_proximal` and `axis_distal` unit vectors out of each stump's lumen;
    `position` [m] the middle, the centre of the source of blood.
    """

    artery: str
    arc_length: float
    arc_fraction: float
    gap: float
    lumen_radius: float
    position: Vector3
    position_proximal: Vector3
    position_distal: Vector3
    axis_proximal: Vector3
    axis_distal: Vector3
    kind: VesselKind = "transected"
    hole_area: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class ShotLine:
    """The projectile's line of flight: entry and exit point [m] on the skin, and what flew it.

    `direction` is the unit vector of flight; `exit_point` lies where the line leaves the limb,
    whether the projectile gets there or not. The line of its middle goes through `entry_point`, or
    where it grazes the limb with its edge only, `beside` [m] it.
    """

    entry_point: Vector3
    exit_point: Vector3
    direction: Vector3
    diameter: float
    speed: float
    beside: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ProjectileHoles:
    """The open holes that one projectile has made in the skin: where [m], and their areas [m²].

    The exit's are None where the projectile has not come out at the far side.
    """

    entry_point: Vector3
    entry_area: float
    exit_point: Vector3 | None
    exit_area: float | None


@dataclass(frozen=True, slots=True, eq=False)
class InjuredLimb:
    """The limb at one time of the injury simulation; static while it bleeds (as in the paper).

    `position`, `reference_position` (n, 3) [m] deformed and original; `tissue` (n,);
    `volume` (n,) [m³], of the undeformed points; `damage` (n,) 0-1; `entry_area`, `exit_area`
    [m²] of the open holes in the skin of the first projectile, `exit_area` None where it stays
    inside; `other_holes` those of further projectiles;
    `injuries` of the arteries, worst first, empty where none is torn; `time` [s] since the
    projectile touched the skin. `surfaces` as in `LimbModel` (before
    the injury).
    """

    position: Float32Array
    reference_position: Float32Array
    tissue: LabelArray
    volume: Float32Array
    damage: Float32Array
    spacing: float
    arteries: tuple[InjuredArtery, ...]
    injuries: tuple[VesselInjury, ...]
    shot: ShotLine
    entry_area: float
    exit_area: float | None
    time: float
    steps: int
    particle_steps_per_second: float
    surfaces: Mapping[str, TriangleSurface]
    side: str
    other_holes: tuple[ProjectileHoles, ...] = ()

    @property
    def holes(self) -> tuple[ProjectileHoles, ...]:
        """The open holes of every projectile, the first projectile's first."""
        first = ProjectileHoles(
            entry_point=self.shot.entry_point,
            entry_area=self.entry_area,
            exit_point=None if self.exit_area is None else self.shot.exit_point,
            exit_area=self.exit_area,
        )
        return (first, *self.other_holes)

    @property
    def severed_segment(self) -> str | None:
        """The artery that bleeds: the first of `injuries`, or None."""
        return self.injuries[0].artery if self.injuries else None


@dataclass(frozen=True, slots=True, eq=False)
class InjuryOutcome:
    """The result of the injury stage: the limb's states by name, and the report.

    `states` holds "temporary", the largest cavity, and "permanent", the end; of a run in the mode
    "paper" there is "permanent" alone. `bleeds_from` names the one that bleeds.
    """

    states: Mapping[str, InjuredLimb]
    bleeds_from: str
    report: WoundReport

    @property
    def wound(self) -> InjuredLimb:
        """The state that bleeds and is drawn."""
        return self.states.get(self.bleeds_from, self.permanent)

    @property
    def temporary(self) -> InjuredLimb:
        """The limb when the cavity was largest; the end where only that was kept."""
        return self.states.get("temporary", self.permanent)

    @property
    def permanent(self) -> InjuredLimb:
        """The limb at the end."""
        return self.states["permanent"]


@dataclass(frozen=True, slots=True, eq=False)
class ParticleFrame:
    """Particles at one instant, for files and pictures.

    `position` (n, 3) [m]; `point_data` maps a name with its unit to an (n,) or (n, 3) array,
    `frame_data` one to an array of any size, for example where the projectiles are.
    """

    index: int
    time: float
    position: Float32Array
    point_data: Mapping[str, AnyArray]
    frame_data: Mapping[str, AnyArray] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class BleedLedger:
    """What became of the blood, sampled through the run.

    All (n,) arrays in step: `time` [s]; `injected` [m³] = the integral of the tree's flow;
    `in_limb`, `out_of_limb`, `removed` [m³], from the particles; `pending` [m³] not yet a whole
    particle. `injected = in_limb + out_of_limb + removed + pending` up to the error.
    """

    time: FloatArray
    injected: FloatArray
    in_limb: FloatArray
    out_of_limb: FloatArray
    removed: FloatArray
    pending: FloatArray

    @property
    def volume_error_fraction(self) -> float:
        """Largest imbalance over the run as a fraction of the injected volume, 0 if none bled."""
        accounted = self.in_limb + self.out_of_limb + self.removed + self.pending
        total = float(np.max(np.abs(self.injected), initial=0.0))
        if total == 0.0:
            return 0.0
        return float(np.max(np.abs(self.injected - accounted)) / total)


@dataclass(frozen=True, slots=True, eq=False)
class BleedWaveforms:
    """Signals of the bleeding run, all (n,) in step; SI (s, Pa, m³/s).

    `pressure_artery` is the pressure inside the injured artery at the cut, `pressure_injury` the
    pressure around the wound that the blood particles report.
    """

    time: FloatArray
    pressure_aorta: FloatArray
    pressure_artery: FloatArray
    pressure_injury: FloatArray
    flow_injury: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class BleedOutcome:
    """The result of the bleeding stage: signals, ledger and what the solver counted.

    `barrier_crossings` counts how often a blood particle was found half its spacing deep in intact
    skin, bone or the platform, and put back;
    `mean_flow_per_beat` (beats,) [m³/s], of the whole beats; of the whole run where it is shorter
    than one beat. `skin_open_area` [m²] of the holes in the skin that blood can get out through;
    `skin_sparse_area` [m²] where skin points are less than half as dense as before the shot, the
    hole of the paper's barrier.
    """

    waveforms: BleedWaveforms
    ledger: BleedLedger
    period: float
    mean_flow_per_beat: FloatArray
    barrier_crossings: int
    particle_count: int
    steps: int
    particle_steps_per_second: float
    skin_open_area: float = 0.0
    skin_sparse_area: float = 0.0
