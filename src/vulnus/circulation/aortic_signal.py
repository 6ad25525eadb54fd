"""The heartbeat that drives the tree: pressure and flow at the root of the aorta over one cycle."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import CirculationError
from vulnus.core.units import MILLILITRE, MILLIMETRE_OF_MERCURY

from .arrays import ComplexArray
from .parameters import CirculationParameters


@dataclass(frozen=True, slots=True, eq=False)
class AorticSignal:
    """One cycle at even times from 0: `pressure` [Pa] and `flow` [m³/s], (n,); `period` [s]."""

    period: float
    pressure: FloatArray
    flow: FloatArray


@cache
def measured_signal() -> AorticSignal:
    """The published cycle of 256 samples, T = 0.8288 s (data/aortic_inlet_eldredge.csv)."""
    path = Path(str(resources.files("vulnus.circulation").joinpath("data")))
    with (path / "aortic_inlet_eldredge.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    time = np.array([float(row["t_s"]) for row in rows])
    pressure = np.array([float(row["P_mmHg"]) for row in rows]) * MILLIMETRE_OF_MERCURY
    flow = np.array([float(row["Q_ml_per_s"]) for row in rows]) * MILLILITRE
    period = float(time[-1] * len(time) / (len(time) - 1))
    return AorticSignal(period=period, pressure=pressure, flow=flow)


def scaled_signal(parameters: CirculationParameters) -> AorticSignal:
    """The published cycle at the heart rate, mean and pulse pressure asked for."""
    signal = measured_signal()
    pressure = signal.pressure
    mean = float(np.mean(pressure))
    wanted_mean = parameters.aortic_mean_pressure
    wanted_pulse = parameters.aortic_pulse_pressure
    swing = 1.0 if wanted_pulse is None else wanted_pulse / float(np.ptp(pressure))
    pressure = (mean if wanted_mean is None else wanted_mean) + swing * (pressure - mean)
    period = signal.period if parameters.heart_rate is None else 1.0 / parameters.heart_rate
    return replace(signal, period=period, pressure=pressure)


def spectrum_of(signal: FloatArray, harmonics: int) -> ComplexArray:
    """Fourier coefficients c_0..c_H of one cycle of samples, signal = c_0 + 2 Re Σ c_n e^(inωt).

    Coefficients beyond the samples' own are zero.
    """
    spectrum = np.zeros(harmonics + 1, dtype=complex)
    measured = np.fft.rfft(signal) / len(signal)
    kept = min(len(measured), harmonics + 1)
    spectrum[:kept] = measured[:kept]
    return spectrum


def signal_of(spectrum: ComplexArray) -> FloatArray:
    """One cycle of 2 H even samples from the coefficients c_0..c_H on the last axis."""
    samples = 2 * (spectrum.shape[-1] - 1)
    return np.asarray(np.fft.irfft(spectrum * samples, samples, axis=-1))


def check_parameters(parameters: CirculationParameters) -> None:
    """Raise `CirculationError` for a parameter outside its physical range."""
    positive = ("harmonics", "density", "viscosity")
    optional = ("heart_rate", "aortic_mean_pressure", "aortic_pulse_pressure")
    limits = [(name, getattr(parameters, name), 0.0, np.inf) for name in positive]
    limits += [
        (name, value, 0.0, np.inf)
        for name in optional
        if (value := getattr(parameters, name)) is not None
    ]
    for name, value, low, high in limits:
        if not low < value < high:
            raise _outside(name, value, "must be positive and finite")
    if not 0.0 <= parameters.poisson_ratio <= 0.5:
        raise _outside("poisson_ratio", parameters.poisson_ratio, "must lie in [0, 0.5]")
    if not 0.0 <= parameters.wall_phase < 0.5 * np.pi:
        raise _outside("wall_phase", parameters.wall_phase, "must lie in [0, π/2) rad")
    for name in ("exit_loss_coefficient", "shunt_resistance", "terminal_compliance"):
        value = getattr(parameters, name)
        if not 0.0 <= value < np.inf:
            raise _outside(name, value, "must not be negative")
    if not np.isfinite(parameters.venous_pressure):
        raise _outside("venous_pressure", parameters.venous_pressure, "must be finite")


def _outside(name: str, value: float, limit: str) -> CirculationError:
    return CirculationError(
        f"circulation.{name}", f"is {value:g}, {limit}", "Correct the value in the scenario"
    )
