"""Mean, systolic and diastolic value of a periodic signal."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vulnus.core.arrays import FloatArray


class CycleSummary(NamedTuple):
    """What a clinician reads off one cycle, in the signal's unit; `peak_time` [s] of its peak."""

    mean: float
    systolic: float
    diastolic: float
    pulse: float
    peak_time: float


def summarise_cycle(time: FloatArray, signal: FloatArray) -> CycleSummary:
    """Mean, largest, smallest and their difference over one cycle of even samples (n,)."""
    systolic, diastolic = float(np.max(signal)), float(np.min(signal))
    return CycleSummary(
        mean=float(np.mean(signal)),
        systolic=systolic,
        diastolic=diastolic,
        pulse=systolic - diastolic,
        peak_time=float(time[int(np.argmax(signal))]),
    )
