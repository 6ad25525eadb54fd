"""How an experiment goes on from a checkpoint: its runs that were over, and the one that was not.

A script may call `run` several times and `slow_waves` between. A checkpoint knows where every
finished run ended, so that the same script, started again, is given back the same results for
these runs, does again what it did between them, and goes on within the run that was cut off.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.checkpoint import Checkpoint, CheckpointData
from vulnus.core.errors import StorageError

from ..checked_values import has_methods
from ..solver import MpmSolver
from .fingerprint import refuse_another
from .record import Record
from .sample_schedule import SampleSchedule

ADVICE = "Run the script as it was, delete the checkpoint, or use another file."


@dataclass(frozen=True, slots=True, eq=False)
class FinishedRun:
    """A call of `run` that is over.

    `samples` and `snapshots` count those since the start of the experiment; `materials` is the
    table before its first step; `state` that of the solver at its end, kept with a checkpoint.
    """

    schedule: SampleSchedule
    stopped: bool
    samples: int
    snapshots: int
    materials: FloatArray
    state: CheckpointData

    def data(self, prefix: str) -> dict[str, object]:
        """As values of a checkpoint."""
        return {
            **{f"{prefix}{key}": value for key, value in self.schedule.numbers().items()},
            f"{prefix}stopped": int(self.stopped),
            f"{prefix}samples": self.samples,
            f"{prefix}snapshots": self.snapshots,
            f"{prefix}start_materials": self.materials,
            **{f"{prefix}state/{key}": value for key, value in self.state.items()},
        }


class RunHistory:
    """The finished runs of an experiment, and what its checkpoint holds of them and of the next."""

    def __init__(self, fingerprint: Callable[[], Mapping[str, str]]) -> None:
        self._make_fingerprint = fingerprint
        self._fingerprint: Mapping[str, str] = {}
        self._finished: list[FinishedRun] = []
        self._checkpoint: Checkpoint | None = None
        self._saved: CheckpointData | None = None
        self._materials: FloatArray = np.zeros(0)

    def begin(self, solver: MpmSolver, checkpoint: Checkpoint | None) -> None:
        """Note what the coming run starts from, and load the checkpoint where it is a new one."""
        self._materials = solver.materials
        if checkpoint is None or checkpoint is self._checkpoint:
            return
        has_methods("checkpoint", checkpoint, ("load", "save", "due"), "a storage.FileCheckpoint")
        self._fingerprint = self._fingerprint or self._make_fingerprint()
        saved = checkpoint.load()
        if saved is not None:
            if "run" not in saved or "fingerprint" not in saved:
                raise StorageError("experiment checkpoint", "is of something else", ADVICE)
            refuse_another(json.loads(str(saved["fingerprint"])), self._fingerprint)
            if int(saved["run"]) < len(self._finished):
                saved = None  # its run is over
        self._checkpoint, self._saved = checkpoint, saved

    def replay(
        self, schedule: SampleSchedule, solver: MpmSolver, record: Record
    ) -> FinishedRun | None:
        """Take the coming run from the checkpoint where it was finished then."""
        number = len(self._finished)
        saved = self._saved
        if saved is None or int(saved["run"]) <= number:
            return None
        prefix = f"run {number}/"
        if f"{prefix}samples" not in saved:
            raise StorageError(
                "experiment checkpoint", f"run {number + 1} was made without it", ADVICE
            )
        for key, value in schedule.numbers().items():
            before = float(saved[prefix + key])
            if before != value:
                self._refuse_run(number, f"had {key} {before:g}, has {value:g} now")
        self._same_materials(number, saved[f"{prefix}start_materials"], solver)
        state = {
            name.removeprefix(f"{prefix}state/"): value
            for name, value in saved.items()
            if name.startswith(f"{prefix}state/")
        }
        run = FinishedRun(
            schedule,
            bool(saved[f"{prefix}stopped"]),
            int(saved[f"{prefix}samples"]),
            int(saved[f"{prefix}snapshots"]),
            solver.materials,
            state,
        )
        solver.restore(state)
        record.restore(saved, samples=run.samples, snapshots=run.snapshots)
        self._finished.append(run)
        return run

    def resume(self, schedule: SampleSchedule, solver: MpmSolver, record: Record) -> None:
        """Go on within the coming run where the checkpoint was saved in it."""
        saved, number = self._saved, len(self._finished)
        if saved is None or int(saved["run"]) != number:
            return
        if float(saved["time"]) > schedule.until:
            self._refuse_run(
                number, f"was at {float(saved['time']):g} s, after until = {schedule.until:g} s"
            )
        self._same_materials(number, saved["start_materials"], solver)
        solver.restore(saved)
        record.restore(saved)
        self._saved = None

    def finish(
        self, schedule: SampleSchedule, solver: MpmSolver, record: Record, *, stopped: bool
    ) -> None:
        """The run is over."""
        state = solver.state() if self._checkpoint is not None else {}
        counts = record.sample_count, len(record.snapshots)
        self._finished.append(FinishedRun(schedule, stopped, *counts, self._materials, state))

    def data(self, solver: MpmSolver, record: Record) -> CheckpointData:
        """All that a checkpoint holds, at the end of an epoch of the present run."""
        data: dict[str, object] = {
            **solver.state(),
            **record.state(),
            "fingerprint": json.dumps(dict(self._fingerprint)),
            "run": len(self._finished),
            "start_materials": self._materials,
        }
        for number, run in enumerate(self._finished):
            if run.state:
                data |= run.data(f"run {number}/")
        return data  # type: ignore[return-value]

    def _same_materials(self, number: int, before: object, solver: MpmSolver) -> None:
        if not np.array_equal(np.asarray(before), solver.materials):
            self._refuse_run(number, "began with other moduli: slow_waves was called otherwise")

    def _refuse_run(self, number: int, told: str) -> None:
        raise StorageError("experiment checkpoint", f"run {number + 1} of it {told}", ADVICE)
