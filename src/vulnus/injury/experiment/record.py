"""What an experiment writes down at every sample, as columns that grow by a row a time.

A column's name says what it holds: `time`, `energy/kinetic`, `tissue/gel/momentum`,
`rigid/ball/position`, `sensor/probe/pressure`. Columns are plain arrays, so that checkpoints and
files hold them as they are.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.checkpoint import CheckpointData

from ..bodies.rigid_body import BodyState, RigidBody
from ..particle_reading import ParticleReading, TissueBody
from .fields import Fields, fields_from_arrays, read_fields
from .sensors import AttachedSensor
from .start import StartedExperiment

COLUMN, SNAPSHOT = "record/", "snapshot/"


class Record:
    """The columns and snapshots of one experiment."""

    def __init__(
        self,
        started: StartedExperiment,
        *,
        gravity: Vector3,
        sensors: Mapping[str, AttachedSensor],
    ) -> None:
        self._started = started
        self._gravity = np.asarray(gravity)
        self._sensors = sensors
        self._columns: dict[str, list[FloatArray]] = {}
        self._snapshots: list[Fields] = []

    @property
    def columns(self) -> dict[str, FloatArray]:
        """Every column as one array, samples along the first axis."""
        return {name: np.array(rows) for name, rows in self._columns.items()}

    @property
    def sample_count(self) -> int:
        """How many samples there are."""
        return len(self._columns.get("time", ()))

    @property
    def snapshots(self) -> tuple[Fields, ...]:
        """All particles at the chosen instants."""
        return tuple(self._snapshots)

    def add(self, reading: ParticleReading, *, snapshot: bool) -> None:
        """Write down one sample, and all particles where it is a `snapshot`."""
        row: dict[str, AnyArray | float] = {"time": reading.time}
        for tissue in self._started.tissue:
            row |= _below(f"tissue/{tissue.name}", _of_tissue(reading, tissue))
        rigid_energy, work, height = 0.0, 0.0, 0.0
        states = self._started.solver.bodies
        for body, state in zip(self._started.rigid, states, strict=True):
            kinetic = kinetic_energy(body, state)
            if body.motion == "dynamic" and body.mass is not None:
                rigid_energy += kinetic
                height -= body.mass * float(state.position @ self._gravity)
            else:
                work += state.work
            row |= _below(f"rigid/{body.name}", _of_rigid_body(body, state, kinetic))
        for flight, state in zip(self._started.flights, states, strict=True):
            row[f"rigid/{state.name}/depth"] = flight.depth(state, reading.time)
            row[f"rigid/{state.name}/foremost"] = flight.foremost(state, reading.time)
        row |= _below("energy", self._energies(reading, rigid_energy, height, work))
        for name, sensor in self._sensors.items():
            row |= _below(f"sensor/{name}", sensor.read(reading))
        for name, value in row.items():
            self._columns.setdefault(name, []).append(np.asarray(value, np.float64))
        if snapshot:
            self._snapshots.append(read_fields(reading, self._started.tissue))

    def _energies(
        self, reading: ParticleReading, rigid: float, height: float, work: float
    ) -> Mapping[str, float]:
        stored = self._started.solver.energies()
        gravity = height - float(reading.mass @ (reading["position"] @ self._gravity))
        kept = {
            "kinetic": stored["kinetic"],
            "elastic": stored["elastic"],
            "gravity": gravity,
            "rigid": rigid,
        }
        total = sum(kept.values())
        before = self._columns.get("energy/total", [np.array(total)])[0]
        softened = self._started.solver.energy_of_changes  # by slow_waves: not from the tissue
        lost = float(before) + work + softened - total
        return {**kept, "total": total, "work": work, "dissipated": lost}

    def state(self) -> CheckpointData:
        """Columns and snapshots for a checkpoint."""
        data = {COLUMN + name: values for name, values in self.columns.items()}
        for index, fields in enumerate(self._snapshots):
            data |= {f"{SNAPSHOT}{index}/{name}": a for name, a in fields.arrays().items()}
        return data

    def restore(
        self, data: CheckpointData, *, samples: int | None = None, snapshots: int | None = None
    ) -> None:
        """Go on with the columns and snapshots of a checkpoint, or with that many of the first."""
        self._columns = {
            name.removeprefix(COLUMN): list(np.asarray(values, np.float64))[:samples]
            for name, values in data.items()
            if name.startswith(COLUMN)
        }
        parts: dict[int, dict[str, AnyArray]] = {}
        for name, values in data.items():
            if name.startswith(SNAPSHOT):
                _, index, key = name.split("/")
                parts.setdefault(int(index), {})[key] = np.asarray(values)
        names = tuple(body.name for body in self._started.tissue)
        chosen = sorted(parts)[:snapshots]
        self._snapshots = [fields_from_arrays(parts[index], names) for index in chosen]


def kinetic_energy(body: RigidBody, state: BodyState) -> float:
    """Of translation and rotation [J]; NaN for a body without mass."""
    if body.mass is None:
        return float("nan")
    spin = state.rotation.T @ state.angular_velocity
    translation = 0.5 * body.mass * float(state.velocity @ state.velocity)
    return translation + 0.5 * float(spin @ body.inertia @ spin)


def _of_rigid_body(
    body: RigidBody, state: BodyState, kinetic: float
) -> dict[str, AnyArray | float]:
    mass = float("nan") if body.mass is None else body.mass
    inertia = body.inertia * (mass / (body.mass or 1.0))
    turn = state.rotation
    return {
        "mass": mass,
        "momentum": mass * state.velocity,
        "angular_momentum": turn @ inertia @ turn.T @ state.angular_velocity,
        "position": state.position,
        "velocity": state.velocity,
        "rotation": state.rotation,
        "angular_velocity": state.angular_velocity,
        "impulse": state.impulse,
        "angular_impulse": state.angular_impulse,
        "normal_impulse": state.normal_impulse,
        "work": state.work,
        "kinetic_energy": kinetic,
    }


def _of_tissue(reading: ParticleReading, body: TissueBody) -> dict[str, AnyArray | float]:
    """Totals of one body of tissue."""
    part = body.particles
    mass, velocity = reading.mass[part], reading["velocity"][part]
    position: FloatArray = reading["position"][part]
    total = float(mass.sum())
    momentum = mass @ velocity
    return {
        "mass": total,
        "centre_of_mass": mass @ position / total,
        "momentum": momentum,
        "velocity": momentum / total,
        "angular_momentum": mass @ np.cross(position, velocity),
        "kinetic_energy": float(0.5 * mass @ np.einsum("ij,ij->i", velocity, velocity)),
    }


def _below(
    prefix: str, values: Mapping[str, AnyArray | float] | Mapping[str, float]
) -> dict[str, AnyArray | float]:
    return {f"{prefix}/{name}": value for name, value in values.items()}
