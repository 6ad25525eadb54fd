"""The way of a body through a run: of its middle as it was noted, and of its foremost point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.checkpoint import CheckpointValue

from ..bodies.contact_way import Outline
from ..bodies.rigid_body import BodyState

REST_SPEED = 1.0
"""Speed [m/s] below which a projectile has stopped; chosen: slower than tissue recoils."""

REST_SHARE = 0.1
"""The same as a part of the speed at first contact, for what is slow from the start; chosen."""

ROW = 17
"""Values of a row: time, middle (3), velocity (3), rotation (9), work."""


@dataclass(frozen=True, slots=True, eq=False)
class FlightPath:
    """Where a point of the projectile was: `time` (k,) [s], `position` (k, 3) [m].

    `speed` (k,) [m/s]; `work` (k,) [J] that the projectile has done on the tissue since first
    contact.
    """

    time: FloatArray
    position: FloatArray
    speed: FloatArray
    work: FloatArray

    @property
    def arc_length(self) -> FloatArray:
        """Length (k,) [m] of the way since the first point."""
        steps = np.linalg.norm(np.diff(self.position, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])


class BodyTrack:
    """A body at the end of every epoch, (k,) rows that grow as the run goes on."""

    def __init__(self, rows: CheckpointValue | None = None) -> None:
        """Empty, or what `rows` gave."""
        kept = np.zeros((0, ROW)) if rows is None else np.asarray(rows, np.float64)
        self._rows = [row.copy() for row in kept.reshape(-1, ROW)]

    def note(self, time: float, body: BodyState) -> None:
        """Add where the body is at `time` [s]."""
        turn = np.asarray(body.rotation).ravel()
        self._rows.append(
            np.concatenate([[time], body.position, body.velocity, turn, [float(body.work)]])
        )

    @property
    def rows(self) -> FloatArray:
        """All of it (k, 17), for a checkpoint."""
        return np.array(self._rows, np.float64).reshape(-1, ROW)

    @property
    def middle(self) -> FlightPath:
        """The way of its centre of mass."""
        rows = self.rows
        speed = np.linalg.norm(rows[:, 4:7], axis=1)
        return FlightPath(
            time=rows[:, 0], position=rows[:, 1:4].copy(), speed=speed, work=rows[:, 16].copy()
        )

    def foremost(self, outline: Outline, aimed: FloatArray) -> FlightPath:
        """The way of the point that is farthest ahead, up to where the body stops or turns back.

        `aimed` (3,) is the direction at first contact. After the stop the point stands, and work
        counts there: what moves a body that has stopped is tissue, and a blade is drawn out
        through what it has cut.
        """
        path, rows = self.middle, self.rows
        heading = np.asarray(aimed, np.float64)
        rest = rest_speed(float(path.speed[:2].max()))
        tip = np.empty_like(path.position)
        stop = len(rows)
        for number, row in enumerate(rows):
            if number > 0:
                if path.speed[number] < rest or row[4:7] @ heading < 0.0:
                    stop = number
                    break
                heading = row[4:7] / path.speed[number]
            ahead = outline.reach(heading, row[7:16].reshape(3, 3), float(row[0]))
            tip[number] = row[1:4] + ahead * heading
        tip[stop:] = tip[stop - 1]
        speed = np.where(np.arange(len(rows)) < stop, path.speed, 0.0)
        return FlightPath(time=path.time, position=tip, speed=speed, work=path.work)


def rest_speed(before: float) -> float:
    """Speed [m/s] below which a body that came with the speed `before` has stopped."""
    return min(REST_SPEED, REST_SHARE * before)
