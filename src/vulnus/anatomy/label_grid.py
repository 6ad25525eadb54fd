"""The label volume as a grid in space: cropped, continued beyond its cut ends, looked up."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from vulnus.core.arrays import BoolArray, FloatArray, IndexArray, LabelArray, Vector3
from vulnus.core.handoff import LabelVolume, Tissue

POINTS_PER_PASS = 200_000
"""Points looked up at once; bounds the memory of the windows around them to about 200 MB."""


@dataclass(frozen=True, slots=True)
class CutEnd:
    """A plane where the image ends inside the limb: `normal · x <= offset` [m] is the image."""

    normal: Vector3
    offset: float


def cut_ends(volume: LabelVolume) -> tuple[CutEnd, ...]:
    """The faces of the volume that labelled voxels touch: there the limb goes on, unseen.

    Each lies half a voxel beyond the centres of the outermost voxels.
    """
    ends = []
    inverse = np.linalg.inv(volume.direction)
    for axis, count in enumerate(volume.labels.shape):
        normal = inverse[axis] / np.linalg.norm(inverse[axis])
        for first, sign in ((True, -1.0), (False, 1.0)):
            face = np.take(volume.labels, 0 if first else count - 1, axis=axis)
            if not face.any():
                continue
            index = np.zeros(3)
            index[axis] = -0.5 if first else count - 0.5
            point = volume.origin + volume.direction @ (volume.spacing * index)
            outward = sign * normal
            vector = (float(outward[0]), float(outward[1]), float(outward[2]))
            ends.append(CutEnd(vector, float(outward @ point)))
    return tuple(ends)


def crop_and_continue(volume: LabelVolume, margin: float) -> LabelVolume:
    """The volume around its labelled voxels, with `margin` [m] of room on every side.

    Where labels touch a face the outermost slice is repeated, so that the surface of the limb
    goes straight on and its distance does not feel the cut; elsewhere the room is air.
    """
    labelled = volume.labels != Tissue.AIR
    low, high = _box(labelled)
    room = np.ceil(margin / volume.spacing).astype(np.int64)
    first, last = np.maximum(low - room, 0), np.minimum(high + room, volume.labels.shape)
    labels = volume.labels[first[0] : last[0], first[1] : last[1], first[2] : last[2]]
    before, after = room - (low - first), room - (last - high)
    labels = np.pad(labels, list(zip(before, after, strict=True)), mode="edge")
    origin = volume.origin + volume.direction @ (volume.spacing * (first - before))
    return replace(volume, labels=np.ascontiguousarray(labels), origin=origin)


def _box(mask: BoolArray) -> tuple[IndexArray, IndexArray]:
    """Lowest index and one past the highest index of the set voxels, each (3,)."""
    low, high = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    for axis in range(3):
        others = tuple(a for a in range(3) if a != axis)
        used = np.flatnonzero(mask.any(axis=others))
        low[axis], high[axis] = used[0], used[-1] + 1
    return low, high


def nearest_label(
    volume: LabelVolume, points: FloatArray, allowed: Iterable[Tissue], otherwise: Tissue
) -> LabelArray:
    """The label (n,) of the nearest voxel that has one of the `allowed` labels.

    Looks two voxels far from the voxel that holds the point, then takes `otherwise`.
    """
    wanted = np.zeros(256, dtype=bool)
    wanted[[int(tissue) for tissue in allowed]] = True
    result = np.full(len(points), int(otherwise), dtype=np.uint8)
    to_index = np.linalg.inv(volume.direction * volume.spacing)
    for start in range(0, len(points), POINTS_PER_PASS):
        place = slice(start, start + POINTS_PER_PASS)
        index = (points[place] - volume.origin) @ to_index.T
        own = _labels_at(volume.labels, np.rint(index).astype(np.int64))
        known = wanted[own]
        result[place][known] = own[known]
        searched = np.flatnonzero(~known)
        if len(searched):
            found, label = _search_window(volume, index[searched], wanted)
            result[place][searched[found]] = label[found]
    return result


def _labels_at(labels: LabelArray, index: IndexArray) -> LabelArray:
    i, j, k = (np.clip(index[..., a], 0, labels.shape[a] - 1) for a in range(3))
    return labels[i, j, k]


def _search_window(
    volume: LabelVolume, index: FloatArray, wanted: BoolArray
) -> tuple[BoolArray, LabelArray]:
    """Nearest wanted label among the 5³ voxels around fractional indices; (found, label)."""
    reach = np.arange(-2, 3)
    steps = np.stack(np.meshgrid(reach, reach, reach, indexing="ij"), axis=-1).reshape(-1, 3)
    centre = np.rint(index).astype(np.int64)
    best = np.full(len(index), np.inf)
    label = np.zeros(len(index), dtype=np.uint8)
    for step in steps:
        there = _labels_at(volume.labels, centre + step)
        square = (((centre + step - index) * volume.spacing) ** 2).sum(axis=1)
        nearer = wanted[there] & (square < best)
        best[nearer], label[nearer] = square[nearer], there[nearer]
    return np.isfinite(best), label
