"""Pulsatile flow of a viscous fluid in a thin elastic tube (Womersley 1957), per frequency.

    α   = R √(ρ ω / μ),            z = α i^(3/2)
    M   = 1 - 2 J1(z) / (z J0(z)) = -J2(z) / J0(z)
    c0² = E h / (2 ρ R (1 - ν²)),  φ = φ0 (1 - e^(-2ω))
    γ   = i ω e^(-iφ/2) / (c0 √M),  Zc = ρ c0 e^(iφ/2) / (π R² √M)

One line of length L carries P and Q by its two-port with cosh γL and Zc sinh γL, whose
determinant is 1; at ω = 0 it is Poiseuille's resistance 8 μ L / (π R⁴). The wall's lag φ is
Avolio's (1980). The sign is that of signals e^(+iωt).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vulnus.core.arrays import FloatArray

from .arrays import ComplexArray
from .parameters import CirculationParameters
from .segments import SegmentTable

HARMONICS_AT_A_TIME = 128
"""Width of a block of harmonics: 91 segments of it stay in the processor's cache."""

_I_TO_THREE_HALVES = complex(np.exp(0.75j * np.pi))
_TABLE_INTERVALS = 8192
_TABLE_ALPHA_MAX = 2000.0


@dataclass(frozen=True, slots=True, eq=False)
class LineConstants:
    """What every segment does to a harmonic wave; rows are segments, columns harmonics 1..H.

    `propagation` γ [1/m], `impedance` Zc [Pa s/m³], both (n, H); `resistance` (n,) [Pa s/m³], the
    Poiseuille resistance of the whole length, for the mean.
    """

    propagation: ComplexArray
    impedance: ComplexArray
    resistance: FloatArray


def womersley_number(
    radius: FloatArray, angular_frequency: FloatArray, *, density: float, viscosity: float
) -> FloatArray:
    """Womersley number α = R √(ρ ω / μ) [1], broadcast over radius [m] and frequency [rad/s]."""
    return radius * np.sqrt(density * angular_frequency / viscosity)


def inertia_factor(alpha: FloatArray) -> ComplexArray:
    """Womersley's M = 1 - 2 J1(z) / (z J0(z)) [1] of the Womersley number, by Bessel functions.

    Written as -J2/J0, which loses no digits at small α: M → i α²/8 there, and → 1 for large α.
    """
    from scipy.special import jve

    z = _I_TO_THREE_HALVES * np.asarray(alpha, dtype=float)
    return np.asarray(-jve(2, z) / jve(0, z))


def inverse_root_factor(alpha: FloatArray) -> ComplexArray:
    """1/√M [1] of the Womersley number α > 0, from a table made once in the process.

    g = α/(1+α) / √M is smooth in log(1+α) from 0 to infinity; a cubic Hermite table of it with the
    exact slopes is within 1e-11 of the Bessel functions. Beyond α = 2000 the first two terms of
    the asymptotic series, 1/√M = 1 + e^(-iπ/4)/α, have an error below 1e-6.
    """
    step, value, slope = _inverse_root_table()
    place = np.log1p(np.minimum(alpha, _TABLE_ALPHA_MAX)) / step
    index = np.minimum(place.astype(np.int64), _TABLE_INTERVALS - 1)
    s = place - index
    left, right = value[index], value[index + 1]
    rise = right - left
    bend_left = slope[index] - rise
    bend_right = slope[index + 1] - rise
    g = left + s * (rise + (1.0 - s) * (bend_left * (1.0 - s) - bend_right * s))
    factor = g * ((1.0 + alpha) / alpha)
    beyond = alpha > _TABLE_ALPHA_MAX
    if np.any(beyond):
        factor[beyond] = 1.0 + np.exp(-0.25j * np.pi) / alpha[beyond]
    return np.asarray(factor)


@lru_cache(maxsize=1)
def _inverse_root_table() -> tuple[float, ComplexArray, ComplexArray]:
    """Step in log(1+α), g at the nodes and its slope times the step."""
    from scipy.special import jve

    t = np.linspace(0.0, np.log1p(_TABLE_ALPHA_MAX), _TABLE_INTERVALS + 1)
    alpha = np.expm1(t[1:])
    z = _I_TO_THREE_HALVES * alpha
    factor = -jve(2, z) / jve(0, z)
    ratio = jve(1, z) / jve(0, z)
    factor_slope = -(2.0 / alpha) * (factor + ratio**2)  # dM/dα from J1/J0's Riccati equation
    root = 1.0 / np.sqrt(factor)
    at_zero = np.sqrt(8.0) * np.exp(-0.25j * np.pi)
    value = np.asarray(np.concatenate(([at_zero], alpha / (1.0 + alpha) * root)), dtype=complex)
    slope = root / (1.0 + alpha) - 0.5 * alpha * root / factor * factor_slope
    step = float(t[1])
    slopes = np.asarray(step * np.concatenate(([-at_zero], slope)), dtype=complex)
    return step, value, slopes


def wave_speed(segments: SegmentTable, *, density: float, poisson_ratio: float) -> FloatArray:
    """Moens-Korteweg speed c0 = √(E h / (2 ρ R (1 - ν²))) [m/s], (n,)."""
    stiffness = segments.youngs_modulus * segments.thickness
    return np.asarray(
        np.sqrt(stiffness / (2.0 * density * segments.radius * (1.0 - poisson_ratio**2)))
    )


def line_constants(
    segments: SegmentTable, angular_frequency: FloatArray, parameters: CirculationParameters
) -> LineConstants:
    """γ and Zc of every segment at the harmonics ω [rad/s] > 0, and the resistance of the mean."""
    density = parameters.density
    speed = wave_speed(segments, density=density, poisson_ratio=parameters.poisson_ratio)
    radius, row = np.unique(segments.radius, return_inverse=True)
    propagation = np.empty((len(segments.ids), len(angular_frequency)), dtype=complex)
    impedance = np.empty_like(propagation)
    per_speed = 1.0 / speed[:, np.newaxis]
    plain_impedance = (density * speed / (np.pi * segments.radius**2))[:, np.newaxis]
    for start in range(0, len(angular_frequency), HARMONICS_AT_A_TIME):
        block = slice(start, start + HARMONICS_AT_A_TIME)
        omega = angular_frequency[block]
        alpha = womersley_number(
            radius[:, np.newaxis], omega, density=density, viscosity=parameters.viscosity
        )
        inverse_root = inverse_root_factor(alpha)
        lag = np.exp(0.5j * parameters.wall_phase * (1.0 - np.exp(-2.0 * omega)))
        np.multiply((inverse_root * (1j * omega / lag))[row], per_speed, out=propagation[:, block])
        np.multiply((inverse_root * lag)[row], plain_impedance, out=impedance[:, block])
    resistance = poiseuille_resistance(segments.length, segments.radius, parameters.viscosity)
    return LineConstants(propagation, impedance, resistance)


def poiseuille_resistance(length: FloatArray, radius: FloatArray, viscosity: float) -> FloatArray:
    """Resistance 8 μ L / (π R⁴) [Pa s/m³] of a tube to steady flow."""
    return 8.0 * viscosity * length / (np.pi * radius**4)
