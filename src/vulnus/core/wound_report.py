"""What a shot did to the limb, as far as it can be counted: vessels, tract, bone, energy, cavity.

Positions are metres, LPS, in the limb before the injury unless said otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .arrays import Float32Array, FloatArray, Vector3

VesselKind = Literal["intact", "lacerated", "transected"]
"""What became of an artery: whole, holed in its side, or torn through."""

ProjectileFate = Literal["left", "stopped", "inside"]
"""Where the projectile was at the end: out of the limb, at rest in it, or still on its way."""


@dataclass(frozen=True, slots=True, eq=False)
class VesselReport:
    """One artery after the shot; `kind` is that of its worst injury.

    `destroyed_share` is the largest part of the wall's circumference that is gone anywhere, 0-1;
    `stretch` the largest that its centre-line has had; `nearest_distance` [m] the least between
    its wall and the projectile's surface, negative where they met; `hole_area` [m²] of its holes.
    """

    artery: str
    kind: VesselKind
    destroyed_share: float
    stretch: float
    nearest_distance: float
    hole_area: float
    injury_count: int


@dataclass(frozen=True, slots=True, eq=False)
class WoundTract:
    """The way of the projectile's middle through the limb, from the skin to the skin or its stop.

    `points` (n, 3) [m] at `arc_length` (n,) [m]. Radii (n,) [m] of circles of the same section:
    `temporary_radius` and `permanent_radius` of the cavity in the two states, 0 where it is
    closed; `destroyed_radius` of the tissue that was destroyed, as it lay before.
    """

    points: FloatArray
    arc_length: FloatArray
    temporary_radius: FloatArray
    permanent_radius: FloatArray
    destroyed_radius: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class SkinHole:
    """A hole in the skin: `position` [m] on it, `destroyed_area` [m²] of the skin that is gone.

    `open_area` [m²] is the gap between what still holds, at the end; skin that has sprung back
    makes it smaller than the area destroyed.
    """

    position: Vector3
    open_area: float
    destroyed_area: float


@dataclass(frozen=True, slots=True, eq=False)
class BoneFragment:
    """A piece of bone that hangs on no main bone: `mass` [kg], its middle [m] after the shot."""

    mass: float
    position: Vector3
    points: int


@dataclass(frozen=True, slots=True, eq=False)
class BoneReport:
    """What became of bone [kg]: `mass` of all that is simulated, `fragments` heaviest first.

    `debris_mass` is destroyed, or in pieces too small for the material points to tell;
    `debris_piece_mass` [kg] estimates one of its pieces, 0 without debris.
    """

    mass: float
    debris_mass: float
    fragments: tuple[BoneFragment, ...]
    debris_piece_mass: float = 0.0

    @property
    def debris_piece_count(self) -> int:
        """Estimate of how many pieces the debris is."""
        return round(self.debris_mass / self.debris_piece_mass) if self.debris_piece_mass else 0


@dataclass(frozen=True, slots=True, eq=False)
class EnergyDeposit:
    """Energy left in the limb along the projectile's path.

    `edges` (n + 1,) [m] of path since first contact; `energy` (n,) [J] between them, whose sum is
    the whole of it: what the projectile lost, or the work of one that keeps its velocity.
    """

    edges: FloatArray
    energy: FloatArray

    @property
    def total(self) -> float:
        """All of it [J]."""
        return float(self.energy.sum())


@dataclass(frozen=True, slots=True, eq=False)
class CavityHistory:
    """Volume (n,) [m³] of the cavity over `time` (n,) [s]."""

    time: FloatArray
    volume: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class TissueField:
    """Damaged tissue around the tract at the end, at nodes `origin + cell * (i, j, k)` [m].

    `damage` (nx, ny, nz) 0-1, the mean of the tissue there; `void` (nx, ny, nz) 0-1, the share of
    space that tissue has left: porosity on top of that of intact tissue.
    """

    origin: Vector3
    cell: float
    damage: Float32Array
    void: Float32Array


@dataclass(frozen=True, slots=True, eq=False)
class ProjectileReport:
    """One projectile and its way through the limb.

    `position` [m], speeds [m/s] and energies [J] (None where it has no mass) at first contact and
    at the end; `exit` is None where it stays in the limb or leaves as it came. `cells_across` is
    its diameter, or a blade's width, over the grid's cells.
    """

    name: str
    fate: ProjectileFate
    position: Vector3
    speed_before: float
    speed_after: float
    energy_before: float | None
    energy_after: float | None
    tract: WoundTract
    entry: SkinHole
    exit: SkinHole | None
    energy: EnergyDeposit
    cells_across: float = np.inf


@dataclass(frozen=True, slots=True, eq=False)
class WoundReport:
    """The wound in numbers, at the end of the run.

    `temporary_time` [s] is when the cavity was largest. `particle_count` and `steps` say what was
    simulated; `flight_steps` of them with the tissues' true moduli. `collapse_time` [s] is since
    when the temporary cavity has collapsed, None where it has not at the end. `notes` say what a
    reader of the numbers has to know.
    """

    projectiles: tuple[ProjectileReport, ...]
    vessels: tuple[VesselReport, ...]
    bone: BoneReport
    cavity: CavityHistory
    field: TissueField
    temporary_time: float
    particle_count: int
    steps: int
    flight_steps: int
    collapse_time: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def collapsed(self) -> bool:
        """Whether the temporary cavity has collapsed by the end of the run."""
        return self.collapse_time is not None
