"""What is written down while the limb bleeds: waveforms, ledger, means of the beats."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.handoff import BleedLedger, BleedWaveforms

from .beat_flow import BeatFlow
from .blood_solver import BloodSolver

_COLUMNS = 10


@dataclass(slots=True)
class RunLog:
    """Rows of samples and the mean flow of each beat [m³/s], the last of them perhaps cut short.

    A row is time, aortic, arterial and wound pressure, flow, and the five volumes of the ledger.
    """

    rows: list[tuple[float, ...]] = field(default_factory=list)
    mean_flow: list[float] = field(default_factory=list)

    def sample(
        self, beat: BeatFlow, solver: BloodSolver, pressure_injury: float, injected: float
    ) -> None:
        """Write a row at the solver's time; `injected` [m³] is the tree's integral up to now."""
        volumes = solver.volumes()
        self.rows.append(
            (
                solver.time,
                *beat.at(solver.time)[:2],
                pressure_injury,
                beat.at(solver.time)[2],
                injected,
                volumes.in_limb,
                volumes.out_of_limb,
                volumes.removed,
                volumes.pending,
            )
        )

    def table(self) -> FloatArray:
        """All rows, (n, 10)."""
        return np.array(self.rows, dtype=float).reshape(-1, _COLUMNS)

    @classmethod
    def from_table(cls, table: FloatArray, mean_flow: FloatArray) -> RunLog:
        """The log of a checkpoint."""
        return cls([tuple(float(x) for x in row) for row in table], [float(q) for q in mean_flow])

    def waveforms(self) -> BleedWaveforms:
        """The signals of the run."""
        time, aorta, artery, injury, flow = np.ascontiguousarray(self.table().T[:5])
        return BleedWaveforms(
            time=time,
            pressure_aorta=aorta,
            pressure_artery=artery,
            pressure_injury=injury,
            flow_injury=flow,
        )

    def ledger(self) -> BleedLedger:
        """The account of the blood."""
        table = np.ascontiguousarray(self.table().T)
        return BleedLedger(
            time=table[0],
            injected=table[5],
            in_limb=table[6],
            out_of_limb=table[7],
            removed=table[8],
            pending=table[9],
        )
