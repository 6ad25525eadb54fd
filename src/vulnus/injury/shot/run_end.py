"""When a run saves frames, and when it ends: at a given time, or when the cavity has collapsed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import CavityHistory
from vulnus.core.units import MILLISECOND

from ..parameters import InjuryParameters

PASSAGE_TIME = 1e-3
"""Length [s] of a run in the mode "paper" (section 2.2)."""

LEAST_TIME = 10e-3
"""Time [s] before which no run in the mode "full" ends by itself (10-20 ms, PHYSICS heading 3)."""

LONGEST_TIME = 20e-3
"""Time [s] at which it ends all the same, collapsed or not (the same)."""

COLLAPSED_SHARE = 0.1
"""Part of its largest volume at which a cavity has collapsed; chosen: as small as what lost tissue
and the hollows of a rough tract leave for ever."""

STEADY_TIME = 3e-3
"""Time [s] over which a volume is compared to tell that it does not change any more; chosen: a
cavity that turns at its largest, with pulses of 10-20 ms, changes by a tenth in it."""

STEADY_SHARE = 0.02
"""Change in that time over the largest volume below which a cavity is steady; chosen: twice what
the measured volume of a resting cavity trembles by."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """Frames at `times` [s]; the run may end at any from `earliest` on, and does at the last.

    `earliest` [s] is the last time itself where the run has a fixed length.
    """

    times: tuple[float, ...]
    earliest: float

    @property
    def latest(self) -> float:
        """The time [s] of the last frame."""
        return self.times[-1]


def schedule(parameters: InjuryParameters, thrust_end: float = 0.0) -> Schedule:
    """Of a run whose guided blades are out of the limb at `thrust_end` [s], 0 without one.

    Frames lie close during `phase_one` (in the mode "paper": during its millisecond), and far
    apart after it. Raises `ScenarioError` where a given duration ends before the thrust.
    """
    paper, given = parameters.mode == "paper", parameters.duration
    if given is not None and given < thrust_end * (1.0 - 1e-9):
        raise ScenarioError(
            "injury.duration_ms",
            f"is {given / MILLISECOND:g} ms, but the blade is out of the limb at "
            f"{thrust_end / MILLISECOND:.4g} ms",
            f"Give at least {math.ceil(1.001e2 * thrust_end / MILLISECOND) / 100:g}, "
            "or leave it out.",
        )
    if given is not None:
        earliest = latest = given
    elif paper:
        earliest = latest = max(PASSAGE_TIME, thrust_end)
    else:
        earliest = max(LEAST_TIME, thrust_end)
        latest = max(LONGEST_TIME, thrust_end + STEADY_TIME)
    dense_end = (given or PASSAGE_TIME) if paper else parameters.phase_one
    return Schedule(_frame_times(parameters, min(dense_end, latest), latest), earliest)


def _frame_times(parameters: InjuryParameters, dense_end: float, end: float) -> tuple[float, ...]:
    """Times [s] of all frames after the first, close up to `dense_end`."""
    dense = math.ceil(dense_end / parameters.frame_interval - 1e-9)
    times = [index * parameters.frame_interval for index in range(1, dense)]
    if 0.0 < dense_end < end:
        times.append(dense_end)
    sparse = math.ceil((end - dense_end) / parameters.relaxation_frame_interval - 1e-9)
    times += [
        dense_end + index * parameters.relaxation_frame_interval for index in range(1, sparse)
    ]
    return (*times, end)


def collapse_time(history: CavityHistory) -> float | None:
    """Since when [s] the cavity has collapsed for good, None where it has not at the end.

    Collapsed is a volume of at most `COLLAPSED_SHARE` of the largest until then, or one that has
    changed by less than `STEADY_SHARE` of it in the last `STEADY_TIME`.
    """
    since = None
    for count in range(len(history.time), 0, -1):
        if not _is_collapsed(history, count):
            break
        since = float(history.time[count - 1])
    return since


def _is_collapsed(history: CavityHistory, count: int) -> bool:
    """Whether the cavity had collapsed at the last of the first `count` times."""
    time, volume = history.time[:count], history.volume[:count]
    largest = float(volume.max())
    if volume[-1] <= COLLAPSED_SHARE * largest:
        return True
    recent = volume[time >= time[-1] - STEADY_TIME * (1.0 + 1e-9)]
    long_enough = time[-1] - time[0] >= STEADY_TIME
    return long_enough and float(np.ptp(recent)) <= STEADY_SHARE * largest
