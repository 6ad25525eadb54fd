"""What an experiment gives back: curves over time, and all particles at chosen instants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError
from vulnus.core.wound_report import EnergyDeposit, WoundTract

from ..checked_values import finite, one_of, positive
from ..wound.tract import ENERGY_BIN, energy_along
from .fields import Fields, write_arrays
from .wound_readings import BROKEN, flight_path, tract_of


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

    `mass` [kg], NaN for a body without one, whose momenta and energy are NaN too; `position` (m, 3)
    [m] of its centre of mass; `foremost` (m, 3) [m] as far ahead of it as its foremost point is;
    `velocity` (m, 3) [m/s]; `rotation` (m, 3, 3) from its own axes to the world's;
    `angular_velocity` (m, 3) [rad/s]; `momentum` (m, 3) [kg m/s]; `angular_momentum` (m, 3)
    [kg m²/s] about its centre of mass; `impulse` (m, 3) [N s] and, about the centre,
    `angular_impulse` (m, 3) [N m s] that the tissue has given it; `normal_impulse` (m,) [N s], the
    sum of the sizes of its normal parts; `work` (m,) [J] that it has done on the tissue;
    `kinetic_energy` (m,) [J]; `depth` (m,) [m] of its foremost point behind the surface it was
    aimed at, along the direction of the start: negative before contact, NaN where its line meets no
    tissue.
    """

    name: str
    time: FloatArray
    mass: float
    position: FloatArray
    foremost: FloatArray
    velocity: FloatArray
    rotation: FloatArray
    angular_velocity: FloatArray
    momentum: FloatArray
    angular_momentum: FloatArray
    impulse: FloatArray
    angular_impulse: FloatArray
    normal_impulse: FloatArray
    work: FloatArray
    kinetic_energy: FloatArray
    depth: FloatArray

    @property
    def force(self) -> FloatArray:
        """Mean force (m, 3) [N] of the tissue on it since the sample before; 0 at the first."""
        return _mean_rate(self.time, self.impulse)

    @property
    def torque(self) -> FloatArray:
        """Mean torque (m, 3) [N m] about its centre since the sample before; 0 at the first."""
        return _mean_rate(self.time, self.angular_impulse)

    @property
    def axis(self) -> FloatArray:
        """Direction (m, 3) in which its nose, its own +x, points."""
        return self.rotation[:, :, 0]

    def energy_deposit(self, interval: float = ENERGY_BIN) -> EnergyDeposit:
        """Energy [J] left in each `interval` [m] of the way of its foremost point since contact.

        As fine as the samples are: take them at least every `interval`.
        """
        positive("interval", interval)
        return energy_along(flight_path(self), interval)

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
        what kinematic and guided bodies have put in. "dissipated" is what is missing since time 0,
        total(0) + work - total: what plastic flow, damage, friction, sponges and the scheme itself
        have turned into heat, less what moving walls and `slow_waves` have put in.
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
        mass = float(columns.pop("mass")[0])
        return RigidBodyRecord(name=name, time=self.time, mass=mass, **columns)

    def tract(self, name: str, *, damage_threshold: float = BROKEN) -> WoundTract:
        """The way of a rigid body through the tissue, from surface to surface or its stop.

        `points` (n, 3) [m] at `arc_length` (n,) [m], and radii (n,) [m] of circles of the same
        section: `permanent_radius` of the cavity at the end, `temporary_radius` of the largest
        among the snapshots and the end, `destroyed_radius` of tissue with damage from
        `damage_threshold`, as it lay before. As fine as the samples are.
        """
        return tract_of(self.rigid_body(name), self.snapshots, self.final, damage_threshold)

    def sensor(self, name: str) -> SensorRecord:
        """What the sensor of this name saw."""
        known = one_of("sensor", name, self.sensor_names)
        return SensorRecord(name=name, time=self.time, values=self._below(f"sensor/{known}"))

    def snapshot(self, time: float) -> Fields:
        """The snapshot nearest to `time` [s]."""
        wanted = finite("time", time)
        if not self.snapshots:
            raise ScenarioError(
                "snapshots", "none were taken", "Give run(snapshot_interval=...) [s]."
            )
        return min(self.snapshots, key=lambda fields: abs(fields.time - wanted))

    def save(self, path: str | Path) -> Path:
        """Write all curves to a NumPy .npz file under their full names, see `columns`."""
        return write_arrays(path, self.columns)

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


def _mean_rate(time: FloatArray, values: FloatArray) -> FloatArray:
    """Change (m, ...) of the values since the sample before over the time between."""
    rate = np.zeros_like(values)
    rate[1:] = np.diff(values, axis=0) / np.diff(time)[:, None]
    return rate
