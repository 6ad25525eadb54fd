"""The flow of one heartbeat as the blood's solver receives it: linear between samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.circulation import BeatSignals
from vulnus.core.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class BeatFlow:
    """Signals of one beat on the run's clock, closed: the last sample repeats the first.

    `time` [s], (n + 1,), from the beat's start to its end; the others as in `BeatSignals`.
    `injected` [m³], (n + 1,), is the integral of the flow since the beat's start: trapezia, which
    are exact for a flow that is linear between samples.
    """

    time: FloatArray
    pressure_aorta: FloatArray
    pressure_artery: FloatArray
    flow_injury: FloatArray
    injected: FloatArray

    @classmethod
    def starting(cls, start: float, signals: BeatSignals) -> BeatFlow:
        """The beat that begins at `start` [s]."""
        time = start + np.append(signals.time, signals.period)
        flow = _closed(signals.flow_injury)
        slices = 0.5 * (flow[1:] + flow[:-1]) * np.diff(time)
        return cls(
            time=time,
            pressure_aorta=_closed(signals.pressure_aorta),
            pressure_artery=_closed(signals.pressure_artery),
            flow_injury=flow,
            injected=np.concatenate(([0.0], np.cumsum(slices))),
        )

    @property
    def start(self) -> float:
        """When the beat begins [s]."""
        return float(self.time[0])

    @property
    def end(self) -> float:
        """When the beat ends [s]."""
        return float(self.time[-1])

    @property
    def rate(self) -> tuple[FloatArray, FloatArray]:
        """Times [s] and flows [m³/s] for `BloodSolver.advance`."""
        return self.time, self.flow_injury

    def at(self, time: float) -> tuple[float, float, float]:
        """Aortic and arterial pressure [Pa] and the flow [m³/s] at a time of the beat."""
        aorta = np.interp(time, self.time, self.pressure_aorta)
        artery = np.interp(time, self.time, self.pressure_artery)
        return float(aorta), float(artery), float(np.interp(time, self.time, self.flow_injury))

    def volume(self, time: float) -> float:
        """Integral of the flow [m³] from the beat's start to a time of the beat."""
        last = len(self.time) - 2
        k = min(max(int(np.searchsorted(self.time, time, side="right")) - 1, 0), last)
        flow = float(np.interp(time, self.time, self.flow_injury))
        begun = 0.5 * (float(self.flow_injury[k]) + flow) * (time - float(self.time[k]))
        return float(self.injected[k]) + begun


def _closed(signal: FloatArray) -> FloatArray:
    return np.append(signal, signal[0])
