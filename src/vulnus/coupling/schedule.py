"""The instants at which the bleeding run stops to look: frames, samples, ends of beats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

SAME_INSTANT = 1e-9
"""Instants closer than this [s] are one."""


class Stop(NamedTuple):
    """An instant of the run [s] and what falls on it."""

    time: float
    frame: bool
    sample: bool
    beat: bool
    end: bool


@dataclass(frozen=True, slots=True)
class Schedule:
    """Frames and samples at exact multiples of their intervals, beats of one period, the end."""

    duration: float
    frame_interval: float
    sample_interval: float
    period: float

    def stop_after(self, *, frames: int, samples: int, beats: int) -> Stop:
        """The next stop when so many frames, samples and whole beats are behind.

        Frame 0 and sample 0 lie at time 0. Where instants coincide up to rounding the frame's
        multiple is the time. The run's end is a sample whether or not it is a multiple.
        """
        frame = frames * self.frame_interval
        sample = samples * self.sample_interval
        beat = (beats + 1) * self.period
        time = min(frame, sample, beat, self.duration)
        if frame - time < SAME_INSTANT:
            time = frame
        end = self.duration - time < SAME_INSTANT
        return Stop(
            time=time,
            frame=frame - time < SAME_INSTANT,
            sample=end or sample - time < SAME_INSTANT,
            beat=beat - time < SAME_INSTANT,
            end=end,
        )
