"""What a run keeps while it goes on: the tracks, the largest stretch and cavity, and that state.

All of it goes into the checkpoint, so that a killed run resumes with the same maxima.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, Float32Array, FloatArray
from vulnus.core.checkpoint import CheckpointData, CheckpointValue
from vulnus.core.handoff import CavityHistory

from ..bodies.rigid_body import BodyState
from ..solver import MpmSolver
from ..wound.artery_wall import piece_lengths
from ..wound.body_track import BodyTrack


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The simulated limb at `time` [s], in the limb's order.

    `position` (n, 3) [m], `damage` (n,); `tracers` (m, 3) [m], their least distance `approach`
    (m,) [m] to a projectile's surface and the largest `stretch` (m - 1,) between two, so far;
    `bodies` (b, 12) how the projectiles lie, as `poses` says.
    """

    time: float
    steps: int
    position: Float32Array
    damage: Float32Array
    tracers: FloatArray
    approach: FloatArray
    stretch: FloatArray
    bodies: FloatArray

    def entries(self, name: str) -> dict[str, CheckpointValue]:
        """Its fields for a checkpoint, each name with a prefix."""
        return {f"{name}.{field}": getattr(self, field) for field in self.__slots__}

    @classmethod
    def from_entries(cls, data: CheckpointData, name: str) -> Snapshot | None:
        """What `entries` gave, or None where it is not there."""
        if f"{name}.time" not in data:
            return None
        return cls(
            time=float(data[f"{name}.time"]),
            steps=int(data[f"{name}.steps"]),
            **{
                field: np.asarray(data[f"{name}.{field}"])
                for field in ("position", "damage", "tracers", "approach", "stretch", "bodies")
            },
        )


def poses(bodies: Sequence[BodyState]) -> FloatArray:
    """Where bodies are and how they lie, (b, 12): the middle [m], and the rows of the rotation."""
    rows = [np.concatenate([body.position, np.ravel(body.rotation)]) for body in bodies]
    return np.array(rows, np.float64).reshape(-1, 12)


class RunRecord:
    """The history of one run, from its bodies and tracers at the end of every epoch."""

    def __init__(self, solver: MpmSolver, connected: BoolArray) -> None:
        """`connected` (m - 1,): whether tracers m and m + 1 belong to the same artery."""
        tracers, _ = solver.tracers
        self._connected = connected
        self._lengths = piece_lengths(tracers)
        self.stretch = np.ones(len(self._lengths))
        self.tracks = [BodyTrack() for _ in solver.bodies]
        self.cavity: list[tuple[float, float]] = []
        self.largest: Snapshot | None = None
        self.flight_steps = 0
        self.relaxed = False
        self.wall = 0.0
        self._note_bodies(solver.time, solver.bodies)

    def follow(self, solver: MpmSolver) -> None:
        """Take note of the end of an epoch."""
        tracers, _ = solver.tracers
        ratio = np.where(self._connected, piece_lengths(tracers) / self._lengths, 1.0)
        self.stretch = np.maximum(self.stretch, ratio)
        self._note_bodies(solver.time, solver.bodies)
        if not self.relaxed:
            self.flight_steps = solver.steps

    def note_cavity(self, solver: MpmSolver, volume: float) -> None:
        """Take note of a cavity's volume [m³], and keep the state where it is the largest."""
        if self.cavity and solver.time <= self.cavity[-1][0]:
            return
        largest = max((known for _, known in self.cavity), default=0.0)
        self.cavity.append((solver.time, volume))
        if volume > largest:
            self.largest = self.snapshot(solver)

    def snapshot(self, solver: MpmSolver) -> Snapshot:
        """The state now."""
        tracers, approach = solver.tracers
        return Snapshot(
            time=solver.time,
            steps=solver.steps,
            position=solver.position.astype(np.float32),
            damage=np.asarray(solver.damage, np.float32),
            tracers=tracers,
            approach=approach,
            stretch=self.stretch.copy(),
            bodies=poses(solver.bodies),
        )

    @property
    def history(self) -> CavityHistory:
        """The cavity's volume over time, less what was there before the shot (folds of skin)."""
        rows = np.array(self.cavity, np.float64).reshape(-1, 2)
        return CavityHistory(
            time=rows[:, 0].copy(), volume=np.maximum(rows[:, 1] - rows[:1, 1], 0.0)
        )

    def entries(self) -> dict[str, CheckpointValue]:
        """All of it for a checkpoint."""
        kept: dict[str, CheckpointValue] = {
            "record.stretch": self.stretch,
            "record.cavity": np.array(self.cavity, np.float64).reshape(-1, 2),
            "record.tracks": np.array([track.rows for track in self.tracks], np.float64),
            "record.flight_steps": self.flight_steps,
            "record.relaxed": int(self.relaxed),
            "record.wall": self.wall,
        }
        if self.largest is not None:
            kept |= self.largest.entries("largest")
        return kept

    def resume(self, data: CheckpointData) -> None:
        """Go on from what `entries` gave."""
        self.stretch = np.asarray(data["record.stretch"], np.float64)
        self.cavity = [(float(t), float(v)) for t, v in _rows(data["record.cavity"])]
        self.tracks = [BodyTrack(rows) for rows in np.asarray(data["record.tracks"])]
        self.flight_steps = int(data["record.flight_steps"])
        self.relaxed = bool(int(data["record.relaxed"]))
        self.wall = float(data["record.wall"])
        self.largest = Snapshot.from_entries(data, "largest")

    def _note_bodies(self, time: float, bodies: tuple[BodyState, ...]) -> None:
        for track, body in zip(self.tracks, bodies, strict=True):
            track.note(time, body)


def _rows(values: CheckpointValue) -> AnyArray:
    return np.asarray(values, np.float64)
