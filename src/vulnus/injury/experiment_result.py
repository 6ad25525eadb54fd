"""What an experiment gives back: curves over time, and all particles at chosen instants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import ParticleFrame

from .cavity import cavity_volume
from .checked_values import one_of
from .particle_reading import QUANTITIES, ParticleReading, TissueBody
from .solids import Solid

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
    strain of open voids; `body` (n,) indices into `body_names`.
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
    body: IndexArray
    body_names: tuple[str, ...]

    @property
    def displacement(self) -> FloatArray:
        """Way (n, 3) [m] from the reference position."""
        moved: FloatArray = self.position - self.reference_position
        return moved

    def __len__(self) -> int:
        return len(self.position)

    def of(self, body: str) -> Fields:
        """Only the particles of this body of tissue."""
        return self.where(self.body == self.body_names.index(one_of("body", body, self.body_names)))

    def inside(self, solid: Solid) -> Fields:
        """Only the particles that are inside the solid now."""
        return self.where(solid.contains(self.position))

    def where(self, chosen: BoolArray) -> Fields:
        """Only the particles that are chosen by (n,) of bool."""
        arrays = {name: getattr(self, name)[chosen] for name in _ARRAYS}
        return Fields(time=self.time, body_names=self.body_names, **arrays)

    def arrays(self) -> dict[str, AnyArray]:
        """All arrays and the time by name."""
        return {"time": np.array(self.time), **{name: getattr(self, name) for name in _ARRAYS}}

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner (3,) [m] of the material, half a particle around positions."""
        half = 0.5 * np.cbrt(self.volume * self.volume_ratio)[:, None]
        return (self.position - half).min(axis=0), (self.position + half).max(axis=0)

    def cavity_volume(self) -> float:
        """Volume [m³] that the particles enclose and do not fill, such as a temporary cavity.

        A hole that is open to outside, as a track, ends flush with the surface. Holes narrower than
        about two distances between particles are not seen.
        """
        spacing = float(np.cbrt(self.volume.mean()))
        return cavity_volume(self.position, spacing, volume=self.volume)

    def save(self, path: str | Path) -> Path:
        """Write all arrays to a NumPy .npz file; `np.load(path)["pressure"]` reads one."""
        return _write_arrays(Path(path), self.arrays())

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


@dataclass(frozen=True, slots=True, eq=False)
class TissueRecord:
    """A body of tissue as a whole, samples along the first axis of every array.

    `mass` [kg]; `centre_of_mass` (m, 3) [m]; `momentum` (m, 3) [kg m/s]; `velocity` (m, 3) [m/s]
    of the centre of mass; `angular_momentum` (m, 3) [kg m²/s] about the world's origin;
    `kinetic_energy` (m,) [J].
    """

    name: str
    time: FloatArray
    mass: float
    centre_of_mass: FloatArray
    momentum: FloatArray
    velocity: FloatArray
    angular_momentum: FloatArray
    kinetic_energy: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class RigidBodyRecord:
    """A rigid body, samples along the first axis of every array.

    `position` (m, 3) [m] of its centre of mass; `velocity` (m, 3) [m/s]; `rotation` (m, 3, 3) from
    its own axes to the world's; `angular_velocity` (m, 3) [rad/s]; `impulse` (m, 3) [N s] that the
    tissue has given it; `normal_impulse` (m,) [N s], the sum of the sizes of its normal parts;
    `work` (m,) [J] that it has done on the tissue; `kinetic_energy` (m,) [J], NaN without a mass;
    `depth` (m,) [m] that its foremost point has come since first contact, along the direction of
    the start: behind the surface where that is square to the flight, negative before contact, NaN
    where its line meets no tissue.
    """

    name: str
    time: FloatArray
    position: FloatArray
    velocity: FloatArray
    rotation: FloatArray
    angular_velocity: FloatArray
    impulse: FloatArray
    normal_impulse: FloatArray
    work: FloatArray
    kinetic_energy: FloatArray
    depth: FloatArray

    @property
    def speed(self) -> FloatArray:
        """Speed (m,) [m/s] of the centre of mass."""
        speed: FloatArray = np.linalg.norm(self.velocity, axis=1)
        return speed

    @property
    def residual_speed(self) -> float:
        """Speed [m/s] at the last sample."""
        return float(self.speed[-1])

    @property
    def greatest_depth(self) -> float:
        """Greatest `depth` [m] of all samples: the depth of penetration of what stopped inside."""
        return float(np.max(self.depth))


@dataclass(frozen=True, slots=True, eq=False)
class SensorRecord:
    """What one sensor saw: `sensor["pressure"]` is (m,), of vectors (m, 3), of stress (m, 3, 3)."""

    name: str
    time: FloatArray
    values: Mapping[str, FloatArray]

    def __getitem__(self, quantity: str) -> FloatArray:
        return self.values[one_of(f"sensor {self.name}", quantity, self.values)]


@dataclass(frozen=True, slots=True, eq=False)
class ExperimentResult:
    """Curves over time since the start of the experiment, and the particles at some instants.

    `columns` holds every recorded array by its full name, samples along the first axis;
    `final` the particles at the end; `snapshots` those at the instants that were asked for;
    `steps` how many time steps were taken; `stopped_early` whether `stop_when` ended the run.
    """

    columns: Mapping[str, FloatArray]
    final: Fields
    snapshots: tuple[Fields, ...]
    steps: int
    stopped_early: bool

    @property
    def time(self) -> FloatArray:
        """Times (m,) [s] of the samples; the first is 0."""
        return self.columns["time"]

    @property
    def energies(self) -> Mapping[str, FloatArray]:
        """Energies (m,) [J] by name.

        "kinetic" and "elastic" of the tissue, "rigid" the kinetic energy of the dynamic rigid
        bodies, "gravity" the potential energy of both, "total" the sum of these four; "work" is
        what kinematic and guided bodies have put in. What plastic flow, damage, friction and the
        scheme itself have turned into heat is missing from the total.
        """
        return self._below("energy")

    @property
    def momentum(self) -> FloatArray:
        """Momentum (m, 3) [kg m/s] of all tissue."""
        found = [self._below(f"tissue/{name}")["momentum"] for name in self.body_names]
        total: FloatArray = np.sum(found, axis=0)
        return total

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies of tissue."""
        return self.final.body_names

    @property
    def rigid_body_names(self) -> tuple[str, ...]:
        """Names of the rigid bodies."""
        return self._names("rigid")

    @property
    def sensor_names(self) -> tuple[str, ...]:
        """Names of the sensors."""
        return self._names("sensor")

    def body(self, name: str) -> TissueRecord:
        """A body of tissue as a whole."""
        columns = dict(self._below(f"tissue/{one_of('body', name, self.body_names)}"))
        mass = float(columns.pop("mass")[0])
        return TissueRecord(name=name, time=self.time, mass=mass, **columns)

    def rigid_body(self, name: str) -> RigidBodyRecord:
        """A rigid body: its motion, its depth, and what it gave the tissue."""
        columns = self._below(f"rigid/{one_of('rigid body', name, self.rigid_body_names)}")
        return RigidBodyRecord(name=name, time=self.time, **columns)

    def sensor(self, name: str) -> SensorRecord:
        """What the sensor of this name saw."""
        known = one_of("sensor", name, self.sensor_names)
        return SensorRecord(name=name, time=self.time, values=self._below(f"sensor/{known}"))

    def snapshot(self, time: float) -> Fields:
        """The snapshot nearest to `time` [s]."""
        if not self.snapshots:
            raise ScenarioError(
                "snapshots", "none were taken", "Give run(snapshot_interval=...) [s]."
            )
        return min(self.snapshots, key=lambda fields: abs(fields.time - time))

    def save(self, path: str | Path) -> Path:
        """Write all curves to a NumPy .npz file under their full names, see `columns`."""
        return _write_arrays(Path(path), self.columns)

    def _below(self, prefix: str) -> dict[str, FloatArray]:
        start = prefix + "/"
        return {
            name.removeprefix(start): values
            for name, values in self.columns.items()
            if name.startswith(start)
        }

    def _names(self, kind: str) -> tuple[str, ...]:
        found = (name.split("/") for name in self.columns)
        return tuple(dict.fromkeys(parts[1] for parts in found if parts[0] == kind))


def read_fields(reading: ParticleReading, bodies: tuple[TissueBody, ...]) -> Fields:
    """All quantities of all particles now."""
    index = np.concatenate(
        [np.full(b.particles.stop - b.particles.start, i) for i, b in enumerate(bodies)]
    )
    quantities = {name: reading[name] for name in QUANTITIES if name != "displacement"}
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


def _write_arrays(path: Path, arrays: Mapping[str, AnyArray]) -> Path:
    if path.suffix != ".npz":
        raise ScenarioError("path", f"{path} does not end in .npz", "Name it NAME.npz.")
    np.savez_compressed(path, **dict(arrays))  # type: ignore[arg-type]
    return path
