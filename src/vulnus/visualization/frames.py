"""Frames of a run as pictures need them: loaded one at a time, completed where they are parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..core.arrays import Float32Array
from ..core.handoff import InjuredLimb, ParticleFrame
from .surface import TissuePoints


class Frames(Protocol):
    """Frames in their order; a list of frames is one, `FramesOnDemand` another."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int, /) -> ParticleFrame: ...


@dataclass(frozen=True, slots=True)
class FramesOnDemand:
    """Frames that lie in files: `count` of them, each read by `load` when it is asked for."""

    count: int
    load: Callable[[int], ParticleFrame]

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, index: int, /) -> ParticleFrame:
        if not -self.count <= index < self.count:
            raise IndexError(index)
        return self.load(index % self.count)


def points_in_passage(
    frame: ParticleFrame, wound: InjuredLimb
) -> tuple[TissuePoints, Float32Array]:
    """All points of the limb during the passage, and where they were before it (n, 3) [m].

    A frame may hold only the simulated part of the limb ("tissue", "damage" and "displacement_m"
    say which); what is missing stands where it stood.
    """
    count = frame.position.shape[0]
    data = frame.point_data
    damage = np.asarray(data.get("damage", np.zeros(count)), dtype=np.float32)
    if "tissue" not in data or "displacement_m" not in data:
        if count != wound.tissue.shape[0]:
            return _empty(wound.spacing), np.zeros((0, 3), np.float32)
        points = TissuePoints(frame.position, wound.tissue, damage, wound.spacing)
        return points, wound.reference_position
    reference = frame.position - np.asarray(data["displacement_m"], dtype=np.float32)
    held = _without(wound.reference_position, reference, wound.spacing)
    position = np.concatenate([frame.position, wound.reference_position[held]])
    tissue = np.concatenate([np.asarray(data["tissue"], np.uint8), wound.tissue[held]])
    damages = np.concatenate([damage, np.zeros(len(held), np.float32)])
    points = TissuePoints(position, tissue, damages, wound.spacing)
    return points, np.concatenate([reference, wound.reference_position[held]])


def _without(
    points: Float32Array, others: Float32Array, spacing: float
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Indices of `points` that are not among `others`, on a lattice far finer than `spacing`."""
    from scipy.spatial import cKDTree

    low = others.min(axis=0) - spacing
    high = others.max(axis=0) + spacing
    close = np.all((points >= low) & (points <= high), axis=1)
    distance, _ = cKDTree(others).query(points[close], distance_upper_bound=0.2 * spacing)
    missing = ~close
    missing[close] = ~np.isfinite(distance)
    return np.flatnonzero(missing)


def _empty(spacing: float) -> TissuePoints:
    none = np.zeros(0, np.float32)
    return TissuePoints(np.zeros((0, 3), np.float32), none.astype(np.uint8), none, spacing)
