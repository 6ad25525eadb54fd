"""What is written down while the limb bleeds: waveforms, ledger, means of the beats."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.handoff import BleedLedger, BleedWaveforms

from .blood_solver import BloodVolumes

_COLUMNS = 10


@dataclass(slots=True)
class RunLog:
    """Rows of samples and the mean flow of each whole beat [m³/s].

    A run that ends within its first beat has the mean over what was simulated of it.

    A row is time, aortic, arterial and wound pressure, flow, and the five volumes of the ledger.
    """

    rows: list[tuple[float, ...]] = field(default_factory=list)
    mean_flow: list[float] = field(default_factory=list)

    def sample(
        self,
        time: float,
        signals: tuple[float, float, float, float],
        injected: float,
        volumes: BloodVolumes,
    ) -> None:
        """Write a row; `signals` are pressures in aorta, artery, wound [Pa] and the flow [m³/s].

        `injected` [m³] is the integral of the tree's flow up to now.
        """
        self.rows.append(
            (
                time,
                *signals,
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
