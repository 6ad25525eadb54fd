"""All particles of an experiment at one instant: arrays, parts of them, and what they show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, IndexArray, Vector3
from vulnus.core.errors import ScenarioError, StorageError
from vulnus.core.handoff import ParticleFrame
from vulnus.core.wound_report import BoneReport

from ..bodies.rotations import Axis
from ..bodies.solids import Solid
from ..checked_values import is_a, one_of
from ..particle_reading import QUANTITIES, ParticleReading, TissueBody
from .deformation import deformation_gradient
from .symmetry import Mirror
from .wound_readings import BROKEN, cavity_of, fragments_of, hole_in

FRAME_NAMES = {
    "velocity": "velocity_m_per_s",
    "displacement": "displacement_m",
    "pressure": "pressure_pa",
    "damage": "damage",
    "plastic_strain": "plastic_strain",
}
"""Quantities that a frame for files carries, with their units in the name."""


@dataclass(frozen=True, slots=True, eq=False)
class Fields:
    """All particles, or some, at one instant; arrays in step, in the order they were added.

    `position`, `reference_position`, `displacement` (n, 3) [m]; `velocity` (n, 3) [m/s];
    `volume` (n,) [m³] and `mass` (n,) [kg] before the start; `stress` (n, 3, 3) [Pa], Cauchy's,
    tension positive; `pressure` (n,) [Pa], compression positive; `volume_ratio` (n,) present over
    reference volume; `damage` (n,) 0-1; `plastic_strain` (n,); `opening` (n,) logarithmic volume
    strain of open voids; `elastic_left_cauchy_green` (n, 3, 3) of the elastic part of the
    deformation, V_e squared; `body` (n,) indices into `body_names`.
    """

    time: float
    position: FloatArray
    reference_position: FloatArray
    velocity: FloatArray
    volume: FloatArray
    mass: FloatArray
    stress: FloatArray
    pressure: FloatArray
    volume_ratio: FloatArray
    damage: FloatArray
    plastic_strain: FloatArray
    opening: FloatArray
    elastic_left_cauchy_green: FloatArray
    body: IndexArray
    body_names: tuple[str, ...]

    @property
    def displacement(self) -> FloatArray:
        """Way (n, 3) [m] from the reference position."""
        moved: FloatArray = self.position - self.reference_position
        return moved

    @property
    def elastic_strain(self) -> FloatArray:
        """Hencky strain ln V_e (n, 3, 3) that the elasto-plastic part carries.

        After `slow_waves` it is that of the lowered moduli.
        """
        value, axis = np.linalg.eigh(self.elastic_left_cauchy_green)
        strain: FloatArray = np.einsum("nia,na,nja->nij", axis, 0.5 * np.log(value), axis)
        return strain

    def deformation_gradient(self) -> FloatArray:
        """F (n, 3, 3) from the start until now, by least squares over neighbours before the start.

        Of every material, with plastic and elastic parts; NaN for particles without neighbours.
        """
        return deformation_gradient(self.reference_position, self.position, self.body)

    def __len__(self) -> int:
        return len(self.position)

    def of(self, body: str) -> Fields:
        """Only the particles of this body of tissue."""
        return self.where(self.body == self.body_names.index(one_of("body", body, self.body_names)))

    def inside(self, solid: Solid) -> Fields:
        """Only the particles that are inside the solid now."""
        is_a("solid", solid, Solid, "Give a Block, Ball, Rod or other Solid.")
        return self.where(solid.contains(self.position))

    def where(self, chosen: BoolArray) -> Fields:
        """Only the particles that are chosen by (n,) of bool."""
        mask = np.asarray(chosen)
        if mask.dtype != np.bool_ or mask.shape != (len(self),):
            raise ScenarioError(
                "chosen",
                f"has the shape {mask.shape} of {mask.dtype}, must be ({len(self)},) of bool",
                "Compare an array of these fields, as fields.damage > 0.5.",
            )
        arrays = {name: getattr(self, name)[mask] for name in _ARRAYS}
        return Fields(time=self.time, body_names=self.body_names, **arrays)

    def arrays(self) -> dict[str, AnyArray]:
        """All arrays and the time by name."""
        return {"time": np.array(self.time), **{name: getattr(self, name) for name in _ARRAYS}}

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner (3,) [m] of the material, half a particle around positions."""
        self._refuse_nothing("extent")
        half = 0.5 * np.cbrt(self.volume * self.volume_ratio)[:, None]
        return (self.position - half).min(axis=0), (self.position + half).max(axis=0)

    def cavity_volume(self) -> float:
        """Volume [m³] that the particles enclose and do not fill, such as a temporary cavity.

        A hole that is open to outside, as a track, ends flush with the surface. Holes narrower than
        about two distances between particles are not seen.
        """
        return cavity_of(self).volume if len(self) else 0.0

    def hole_area(
        self,
        centre: Vector3,
        normal: Axis,
        *,
        radius: float | None = None,
        thickness: float | None = None,
        damage_threshold: float = BROKEN,
    ) -> float:
        """Area [m²] of the hole nearest to `centre` that nothing covers, seen along the surface.

        `centre` [m] lies on the surface as it was, `normal` points out of it; material up to
        `thickness` [m] behind it counts (default: two particles; the whole thickness of a sheet for
        a hole through it), where its damage is below `damage_threshold`. `radius` [m] is how far is
        looked at most, 4/3 of how far a hole may reach (default: as far as the surface goes). Gaps
        no wider than between particles are no holes. A quarter or half model: `mirrored` first.
        """
        self._refuse_nothing("hole_area")
        return hole_in(
            self,
            centre,
            normal,
            radius=radius,
            thickness=thickness,
            damage_threshold=damage_threshold,
        )

    def fragments(
        self, *, strain_rate: float | None = None, damage_threshold: float = BROKEN
    ) -> BoneReport:
        """Pieces that no longer hang together with a main part, heaviest first.

        `mass` [kg] of all, `fragments` with `mass` [kg], `position` [m] and `points` of each, and
        `debris_mass` [kg] of what is destroyed (damage from `damage_threshold`) or in pieces of
        fewer than four particles. A piece of a tenth of the whole is a main part, no fragment.
        With the `strain_rate` [1/s] of the blow, about speed over diameter, `debris_piece_mass`
        [kg] is that of a typical piece of crushed cortical bone; without, 0.
        """
        return fragments_of(self, strain_rate=strain_rate, damage_threshold=damage_threshold)

    def mirrored(self, point: Vector3, normal: Axis) -> Fields:
        """With the mirror image at a plane: the whole of which a half was computed.

        `point` [m] is on the plane, `normal` across it. Sums of mass and volume double.
        """
        mirror = Mirror(point, normal)
        images = {
            name: change(getattr(self, name))
            for names, change in (
                (("position", "reference_position"), mirror.places),
                (("velocity",), mirror.vectors),
                (("stress", "elastic_left_cauchy_green"), mirror.tensors),
            )
            for name in names
        }
        arrays = {
            name: np.concatenate([getattr(self, name), images.get(name, getattr(self, name))])
            for name in _ARRAYS
        }
        return Fields(time=self.time, body_names=self.body_names, **arrays)

    def _refuse_nothing(self, what: str) -> None:
        if not len(self):
            raise ScenarioError(
                what, "there are no particles in these fields", "Choose among more of them."
            )

    def save(self, path: str | Path) -> Path:
        """Write all arrays to a NumPy .npz file; `np.load(path)["pressure"]` reads one."""
        return write_arrays(path, self.arrays())

    def frame(self, index: int = 0) -> ParticleFrame:
        """The particles for `vulnus.storage.FrameSeries`, which writes VTKHDF for ParaView."""
        data = {name: getattr(self, key).astype(np.float32) for key, name in FRAME_NAMES.items()}
        return ParticleFrame(
            index=index,
            time=self.time,
            position=self.position.astype(np.float32),
            point_data={**data, "body": self.body.astype(np.int32)},
        )


_ARRAYS = tuple(name for name in Fields.__dataclass_fields__ if name not in ("time", "body_names"))


def read_fields(reading: ParticleReading, bodies: tuple[TissueBody, ...]) -> Fields:
    """All quantities of all particles now."""
    index = np.concatenate(
        [np.full(b.particles.stop - b.particles.start, i) for i, b in enumerate(bodies)]
    )
    quantities = {name: reading[name] for name in QUANTITIES if name != "displacement"}
    quantities["elastic_left_cauchy_green"] = reading["elastic_left_cauchy_green"]
    return Fields(
        time=reading.time,
        reference_position=reading.reference,
        volume=reading.volume,
        mass=reading.mass,
        body=index,
        body_names=tuple(body.name for body in bodies),
        **quantities,
    )


def fields_from_arrays(arrays: Mapping[str, AnyArray], body_names: tuple[str, ...]) -> Fields:
    """What `Fields.arrays` gave, as fields again."""
    rest = {name: np.asarray(arrays[name]) for name in _ARRAYS}
    return Fields(time=float(arrays["time"]), body_names=body_names, **rest)


def write_arrays(path: str | Path, arrays: Mapping[str, AnyArray]) -> Path:
    """Write arrays to a NumPy .npz file."""
    is_a("path", path, (str, Path), "Give the path of a file NAME.npz.")
    file = Path(path)
    if file.suffix != ".npz":
        raise ScenarioError("path", f"{file} does not end in .npz", "Name it NAME.npz.")
    if not file.parent.is_dir():
        raise StorageError(
            str(file), f"the folder {file.parent} does not exist", "Make it, or name another."
        )
    try:
        np.savez_compressed(file, **dict(arrays))  # type: ignore[arg-type]
    except OSError as error:
        raise StorageError(
            str(file), f"cannot be written ({error.strerror})", "Check its folder."
        ) from error
    return file
