"""The beds behind the ends of the tree: a matched resistance, then a resistance and a compliance.

    Z = R1 + R2 / (1 + i ω R2 C),   R1 = min(ρ c0 / (π R²), 0.9 R_total),   R2 = R_total - R1

R1 near the vessel's characteristic impedance lets fast waves leave without an echo; the total
keeps the table's resistance to the mean flow. A table may give R1 and C of a terminal itself.
"""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray

from .arrays import ComplexArray
from .parameters import CirculationParameters
from .segments import SegmentTable
from .womersley import wave_speed

_LARGEST_PROXIMAL_SHARE = 0.9  # chosen: leaves every bed a resistance behind its compliance


def terminal_admittance(
    table: SegmentTable, angular_frequency: FloatArray, parameters: CirculationParameters
) -> ComplexArray:
    """Admittance 1/Z of the bed behind every segment at ω [rad/s], (n, H); 0 inside the tree."""
    admittance = np.zeros((len(table.ids), len(angular_frequency)), dtype=complex)
    ends = np.flatnonzero(np.isfinite(table.terminal_resistance))
    total = table.terminal_resistance[ends]
    speed = wave_speed(table, density=parameters.density, poisson_ratio=parameters.poisson_ratio)[
        ends
    ]
    matched = parameters.density * speed / (np.pi * table.radius[ends] ** 2)
    proximal = np.minimum(matched, _LARGEST_PROXIMAL_SHARE * total)
    given = table.proximal_resistance[ends]
    proximal = np.where(given > 0.0, given, proximal)
    peripheral = total - proximal
    compliance = table.bed_compliance[ends]
    shared = parameters.terminal_compliance / (total * np.sum(1.0 / total))
    compliance = np.where(np.isnan(compliance), shared, compliance)
    lag = 1j * np.outer(peripheral * compliance, angular_frequency)
    bed = proximal[:, np.newaxis] + peripheral[:, np.newaxis] / (1.0 + lag)
    admittance[ends] = 1.0 / bed
    return admittance
