"""The branch through which a cut artery bleeds, solved over one heartbeat.

The tree around the cut is linear, so that all of it is a pressure P_open behind an impedance Z
per harmonic. The flow through the stump also pays a loss of head,

    P_open - Z * Q - R_branch Q - k Q |Q| = p_injury,   k = K ρ / (2 A²),   A = π r²

(* a convolution over the cycle), where K = 1.5 stands for contraction and exit. With K = 0 and
the small R_branch it is the paper's branch of low impedance (Chong 2017, section 2.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import CirculationError

from .aortic_signal import signal_of, spectrum_of
from .arrays import ComplexArray

FLOW_TOLERANCE = 1e-10
"""Largest change of the flow in the last iteration, as a fraction of its largest value."""

_MOST_ITERATIONS = 5000
_DAMPING_MARGIN = 1.1  # > 1: contraction even where the tree has no resistance of its own


@dataclass(frozen=True, slots=True, eq=False)
class BeatSignals:
    """One heartbeat at even times from 0, (n,) each; periodic in `period` [s].

    `time` [s]; `pressure_aorta`, `pressure_artery` (inside the stump), `pressure_injury` (around
    the wound) [Pa]; `flow_injury` [m³/s], positive out of the artery.
    """

    time: FloatArray
    pressure_aorta: FloatArray
    pressure_artery: FloatArray
    pressure_injury: FloatArray
    flow_injury: FloatArray
    period: float

    @property
    def mean_flow(self) -> float:
        """Mean flow out of the artery over the beat [m³/s]."""
        return float(np.mean(self.flow_injury))


@dataclass(frozen=True, slots=True, eq=False)
class InjuryPort:
    """The tree seen from a cut: P = P_open - Z Q inside the stump, for the harmonics 0..H.

    `open_pressure` [Pa] and `impedance` [Pa s/m³], (H + 1,); `pressure_aorta` [Pa], (2 H,);
    `loss` k [Pa s²/m⁶] of the exit, `branch_resistance` R [Pa s/m³].
    """

    period: float
    pressure_aorta: FloatArray
    open_pressure: ComplexArray
    impedance: ComplexArray
    lumen_radius: float
    loss: float
    branch_resistance: float

    @classmethod
    def between(
        cls,
        *,
        period: float,
        pressure_aorta: FloatArray,
        open_pressure: ComplexArray,
        impedance: ComplexArray,
        lumen_radius: float,
        density: float,
        exit_loss_coefficient: float,
        branch_resistance: float,
    ) -> InjuryPort:
        """Port with the loss of head of a stump of the given lumen radius [m]."""
        for name, value in (
            ("lumen_radius", lumen_radius),
            ("density", density),
        ):
            if not 0.0 < value < np.inf:
                raise _unphysical(name, value, "must be positive and finite")
        for name, value in (
            ("exit_loss_coefficient", exit_loss_coefficient),
            ("branch_resistance", branch_resistance),
        ):
            if not 0.0 <= value < np.inf:
                raise _unphysical(name, value, "must not be negative")
        area = np.pi * lumen_radius**2
        return cls(
            period=period,
            pressure_aorta=pressure_aorta,
            open_pressure=open_pressure,
            impedance=impedance,
            lumen_radius=lumen_radius,
            loss=float(exit_loss_coefficient * density / (2.0 * area**2)),
            branch_resistance=branch_resistance,
        )

    @property
    def time(self) -> FloatArray:
        """Times of the samples [s], (2 H,)."""
        samples = len(self.pressure_aorta)
        return np.asarray(np.arange(samples) * (self.period / samples), dtype=float)

    @property
    def resistance(self) -> float:
        """Resistance of tree and branch to the mean flow [Pa s/m³], without the loss of head."""
        return float(self.impedance[0].real) + self.branch_resistance

    def bleed(self, pressure_injury: FloatArray | float) -> BeatSignals:
        """The periodic heartbeat that bleeds against a pressure [Pa], constant or (2 H,).

        The flow reverses while the pressure around the wound is above the artery's.
        """
        samples = len(self.pressure_aorta)
        outside = np.asarray(pressure_injury, dtype=float)
        if outside.shape not in ((), (samples,)) or not np.all(np.isfinite(outside)):
            raise CirculationError(
                "pressure at the wound",
                f"has shape {outside.shape} or is not finite",
                f"Pass a finite number or {samples} samples of one beat [Pa]",
            )
        outside = np.broadcast_to(outside, (samples,)).copy()
        driving = signal_of(self.open_pressure) - outside
        flow = self._flow(driving)
        taken = signal_of(self.impedance * spectrum_of(flow, samples // 2))
        return BeatSignals(
            time=self.time,
            pressure_aorta=self.pressure_aorta,
            pressure_artery=signal_of(self.open_pressure) - taken,
            pressure_injury=outside,
            flow_injury=flow,
            period=self.period,
        )

    def _flow(self, driving: FloatArray) -> FloatArray:
        """Flow (2 H,) for a driving pressure P_open - p_injury (2 H,).

        Splits the loss k Q|Q| into a resistance c Q, solved exactly per harmonic, and the rest,
        iterated: Q ← (Z + R + c)⁻¹ (driving - k Q|Q| + c Q). With c at half the largest slope
        2 k |Q| this contracts because Re Z >= 0 (the tree is passive). No linear algebra: the
        result has the same bits whatever the number of threads.
        """
        samples = len(driving)
        impedance = self.impedance + self.branch_resistance
        if self.loss == 0.0:
            if np.any(impedance == 0.0):
                raise _unphysical("impedance of the injury branch", 0.0, "must not vanish")
            return np.asarray(np.fft.irfft(np.fft.rfft(driving) / impedance, samples))
        steady = max(float(impedance[0].real), 0.0)
        root = np.sqrt(steady**2 + 4.0 * self.loss * np.abs(driving))
        flow = np.copysign(2.0 * np.abs(driving) / (steady + root + np.finfo(float).tiny), driving)
        for _ in range(_MOST_ITERATIONS):
            magnitude = np.abs(flow)
            damping = _DAMPING_MARGIN * self.loss * float(np.max(magnitude))
            if damping == 0.0:
                return flow
            rest = driving - self.loss * flow * magnitude + damping * flow
            update = np.fft.irfft(np.fft.rfft(rest) / (impedance + damping), samples)
            change = float(np.max(np.abs(update - flow)))
            flow = update
            if change <= FLOW_TOLERANCE * float(np.max(np.abs(flow))):
                return flow
        raise CirculationError(
            "injury port",
            f"flow did not settle in {_MOST_ITERATIONS} iterations (change {change:.3g} m³/s)",
            "Cut further from the heart or use fewer harmonics",
        )


def _unphysical(name: str, value: float, limit: str) -> CirculationError:
    return CirculationError(f"injury port, {name}", f"is {value:g}, {limit}", "Correct the port")
