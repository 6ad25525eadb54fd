"""At which times an experiment is sampled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from vulnus.core.errors import ScenarioError

from ..checked_values import finite, positive

DEFAULT_SAMPLES = 100
MOST_SAMPLES = 1_000_000
"""Samples of a run at most [chosen: a column of 8 MB, and more than any curve shows]."""
ROUND_OFF = 1e-6  # of an interval: what counts as a whole multiple [chosen: far above round-off]


@dataclass(frozen=True, slots=True)
class SampleSchedule:
    """Samples at whole multiples of `sample_interval` [s] and at `until` [s].

    Every `samples_per_snapshot`-th of them is a snapshot; 0: none is.
    """

    until: float
    sample_interval: float
    samples_per_snapshot: int

    @classmethod
    def of(
        cls,
        now: float,
        until: float,
        sample_interval: float | None,
        snapshot_interval: float | None,
    ) -> SampleSchedule:
        """The schedule that these times [s] describe, refused where they make none."""
        until = finite("until", until)
        if not until > now:
            raise ScenarioError(
                "until",
                f"is {until:g} s, must be after the present {now:g} s",
                "Give a later time.",
            )
        interval = until / DEFAULT_SAMPLES
        if sample_interval is not None:
            interval = positive("sample_interval", sample_interval)
        if (until - now) / interval > MOST_SAMPLES:
            raise ScenarioError(
                "sample_interval",
                f"is {interval:g} s: {(until - now) / interval:.2g} samples, must be at most "
                f"{MOST_SAMPLES}",
                "Choose a longer one.",
            )
        if snapshot_interval is None:
            return cls(until, interval, 0)
        ratio = positive("snapshot_interval", snapshot_interval) / interval
        whole = round(ratio)
        if whole < 1 or abs(ratio - whole) > ROUND_OFF * ratio:
            raise ScenarioError(
                "snapshot_interval",
                f"is {ratio:g} sample intervals, must be a whole number of them",
                "Choose a sample_interval that divides it.",
            )
        return cls(until, interval, whole)

    def numbers(self) -> dict[str, float]:
        """What the schedule consists of, by the name that `Experiment.run` has for it."""
        return {
            "until": self.until,
            "sample_interval": self.sample_interval,
            "samples_per_snapshot": float(self.samples_per_snapshot),
        }

    def after(self, now: float) -> Iterator[tuple[float, float]]:
        """Times [s] of the samples after `now`, each with the next one; none where that is over.

        The last is at `until`, and its own next one.
        """
        index = math.floor(now / self.sample_interval + ROUND_OFF)
        time = now
        while time < self.until:
            index += 1
            following = self._time(index)
            if time > now:
                yield time, following
            time = following
        if time > now:
            yield time, time

    def _time(self, index: int) -> float:
        time = index * self.sample_interval
        return time if time < self.until - ROUND_OFF * self.sample_interval else self.until

    def is_snapshot(self, time: float) -> bool:
        """Whether the sample at this time [s] is a snapshot."""
        if self.samples_per_snapshot == 0:
            return False
        ratio = time / (self.samples_per_snapshot * self.sample_interval)
        return abs(ratio - round(ratio)) * self.samples_per_snapshot < ROUND_OFF
