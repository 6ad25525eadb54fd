"""The flow of one heartbeat as the blood's solver receives it: linear between samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vulnus.circulation import BeatSignals
from vulnus.core.arrays import FloatArray


class FlowSlice(NamedTuple):
    """The flow between two stops: `time` [s] and `flow` [m³/s], (n,), linear in between.

    `pressure_artery` [Pa] is that inside the stump at the slice's end.
    """

    time: FloatArray
    flow: FloatArray
    pressure_artery: float

    @property
    def volume(self) -> float:
        """Integral of the flow [m³]: trapezia, exact for a flow that is linear in between."""
        return float(np.sum(0.5 * (self.flow[1:] + self.flow[:-1]) * np.diff(self.time)))


@dataclass(frozen=True, slots=True, eq=False)
class BeatFlow:
    """Signals of one beat on the run's clock, closed: the last sample repeats the first.

    `time` [s], (n + 1,), from the beat's start to its end; the others as in `BeatSignals`.
    """

    time: FloatArray
    pressure_aorta: FloatArray
    pressure_artery: FloatArray
    flow_injury: FloatArray

    @classmethod
    def starting(cls, start: float, signals: BeatSignals) -> BeatFlow:
        """The beat that begins at `start` [s]."""
        return cls(
            time=start + np.append(signals.time, signals.period),
            pressure_aorta=_closed(signals.pressure_aorta),
            pressure_artery=_closed(signals.pressure_artery),
            flow_injury=_closed(signals.flow_injury),
        )

    @property
    def start(self) -> float:
        """When the beat begins [s]."""
        return float(self.time[0])

    @property
    def end(self) -> float:
        """When the beat ends [s]."""
        return float(self.time[-1])

    def aorta_at(self, time: float) -> float:
        """Pressure in the aorta [Pa] at a time of the beat."""
        return float(np.interp(time, self.time, self.pressure_aorta))

    def between(
        self, start: float, stop: float, *, pressure_outside: float, resistance: float
    ) -> FlowSlice:
        """The flow from `start` to `stop` [s] into blood at `pressure_outside` [Pa].

        Where the beat's flow would run against the difference of pressure, out of the stump
        into blood of higher pressure or back from blood of lower, the difference holds it back
        through the tree's `resistance` [Pa s/m³], Q - (p - P) / R, at most to zero: an artery
        neither fills a pocket beyond its own pressure nor sucks it empty, though the beat's flow
        was found before the pocket was full. Turning the flow is left to the exchange.
        """
        inner = self.time[(self.time > start) & (self.time < stop)]
        time = np.concatenate(([start], inner, [stop]))
        flow = np.interp(time, self.time, self.flow_injury)
        artery = np.interp(time, self.time, self.pressure_artery)
        against = np.maximum(np.sign(flow) * (pressure_outside - artery), 0.0)
        held = np.copysign(np.maximum(np.abs(flow) - against / resistance, 0.0), flow)
        raised = float(artery[-1] + resistance * (flow[-1] - held[-1]))
        return FlowSlice(time, held, raised)


def _closed(signal: FloatArray) -> FloatArray:
    return np.append(signal, signal[0])
