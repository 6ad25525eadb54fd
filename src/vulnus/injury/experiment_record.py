"""What an experiment writes down at every sample, as columns that grow by a row a time.

A column's name says what it holds: `time`, `energy/kinetic`, `tissue/gel/momentum`,
`rigid/ball/position`, `sensor/probe/pressure`. Columns are plain arrays, so that checkpoints and
files hold them as they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.checkpoint import CheckpointData

from .particle_reading import ParticleReading, TissueBody
from .sensors import AttachedSensor
from .solver import MpmSolver

PREFIX = "record/"


class Record:
    """The columns of one experiment."""

    def __init__(
        self,
        *,
        gravity: Vector3,
        bodies: Sequence[TissueBody],
        sensors: Mapping[str, AttachedSensor],
    ) -> None:
        self._gravity = np.asarray(gravity)
        self._bodies = bodies
        self._sensors = sensors
        self._columns: dict[str, list[AnyArray]] = {}

    @property
    def columns(self) -> dict[str, AnyArray]:
        """Every column as one array, samples along the first axis."""
        return {name: np.array(rows) for name, rows in self._columns.items()}

    @property
    def count(self) -> int:
        """How many samples there are."""
        return len(self._columns.get("time", ()))

    def add(self, solver: MpmSolver, reading: ParticleReading) -> None:
        """Write down one sample."""
        row: dict[str, AnyArray] = {"time": np.float64(reading.time)}
        row |= {f"energy/{name}": value for name, value in self._energies(solver, reading).items()}
        for body in self._bodies:
            values = _of_tissue(reading, body)
            row |= {f"tissue/{body.name}/{name}": value for name, value in values.items()}
        for name, sensor in self._sensors.items():
            values = sensor.read(reading)
            row |= {f"sensor/{name}/{quantity}": value for quantity, value in values.items()}
        for name, value in row.items():
            self._columns.setdefault(name, []).append(np.asarray(value, np.float64))

    def _energies(self, solver: MpmSolver, reading: ParticleReading) -> dict[str, AnyArray]:
        stored = {"kinetic": solver.totals()["kinetic_energy"], "elastic": 0.0}
        if hasattr(solver, "energies"):
            stored = solver.energies()
        height = -(reading["position"] @ self._gravity)
        energies = {
            "kinetic": np.float64(stored["kinetic"]),
            "elastic": np.float64(stored["elastic"]),
            "gravity": np.float64(reading.mass @ height),
        }
        return energies | {"total": np.sum(list(energies.values()))}

    def state(self) -> CheckpointData:
        """The columns for a checkpoint."""
        return {PREFIX + name: values for name, values in self.columns.items()}

    def restore(self, data: CheckpointData) -> None:
        """Go on with the columns of a checkpoint."""
        self._columns = {
            name.removeprefix(PREFIX): list(np.asarray(values))
            for name, values in data.items()
            if name.startswith(PREFIX)
        }


def _of_tissue(reading: ParticleReading, body: TissueBody) -> dict[str, AnyArray]:
    """Totals of one body of tissue."""
    part = body.particles
    mass, velocity = reading.mass[part], reading["velocity"][part]
    position: FloatArray = reading["position"][part]
    total = float(mass.sum())
    momentum = mass @ velocity
    return {
        "mass": np.float64(total),
        "centre_of_mass": mass @ position / total,
        "momentum": momentum,
        "velocity": momentum / total,
        "angular_momentum": mass @ np.cross(position, velocity),
        "kinetic_energy": np.float64(0.5 * mass @ np.einsum("ij,ij->i", velocity, velocity)),
    }
