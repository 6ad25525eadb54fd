"""A time-weighted mean that is gathered piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

from vulnus.core.arrays import FloatArray


@dataclass(slots=True)
class RunningMean:
    """∫ value dt and ∫ dt since the mean was last taken."""

    integral: float = 0.0
    elapsed: float = 0.0

    @classmethod
    def of(cls, parts: FloatArray) -> RunningMean:
        """The mean that had these `parts`."""
        return cls(float(parts[0]), float(parts[1]))

    @property
    def parts(self) -> tuple[float, float]:
        """Integral and elapsed time, for a checkpoint."""
        return self.integral, self.elapsed

    def add(self, value: float, duration: float) -> None:
        """Count a value that held for a duration [s]."""
        self.integral += value * duration
        self.elapsed += duration

    def take(self, otherwise: float) -> float:
        """The mean so far, or `otherwise` where nothing was counted; starts anew."""
        mean = self.integral / self.elapsed if self.elapsed > 0.0 else otherwise
        self.integral = self.elapsed = 0.0
        return mean
