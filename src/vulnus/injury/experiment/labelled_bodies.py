"""Particles for the labels of a voxel volume."""

from __future__ import annotations

from typing import Any

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import LabelVolume

from ..bodies.solids import FilledPoints
from ..checked_values import length, numbers, refuse_too_many, vector


def label_bodies(
    labels: LabelVolume | AnyArray,
    *,
    wanted: tuple[int, ...],
    spacing: Vector3 | float | None,
    origin: Vector3,
    point_spacing: float,
) -> dict[int, FilledPoints]:
    """Points on a lattice of about `point_spacing` [m] along the voxels' axes, by label.

    Every point takes the label of the voxel it is in; the points' volumes add up to the voxels'.
    """
    voxels, edge, start, direction = _geometry(labels, spacing, origin)
    positions, codes = _lattice(voxels, edge, point_spacing, wanted)
    found = {}
    for label in wanted:
        count = int(np.count_nonzero(voxels == label))
        if count == 0:
            raise ScenarioError(
                f"label {label}",
                "no voxel has it",
                f"Labels there are: {', '.join(map(str, np.unique(voxels).tolist()))}.",
            )
        local = positions[codes == label]
        if not len(local):
            raise ScenarioError(
                f"label {label}", "is smaller than the points' spacing", "Use smaller cells."
            )
        volume = count * float(np.prod(edge)) / len(local)
        found[label] = FilledPoints(local @ direction.T + start, np.full(len(local), volume))
    return found


def _geometry(
    labels: LabelVolume | AnyArray, spacing: Any, origin: Vector3
) -> tuple[AnyArray, FloatArray, FloatArray, FloatArray]:
    if isinstance(labels, LabelVolume):
        if spacing is not None:
            raise ScenarioError("spacing", "a LabelVolume has its own", "Leave it out.")
        return labels.labels, np.asarray(labels.spacing), labels.origin, labels.direction
    try:
        voxels = np.asarray(labels)
    except (TypeError, ValueError):
        voxels = np.zeros(0)
    if voxels.ndim != 3 or voxels.dtype.kind not in "iub":
        raise ScenarioError(
            "labels",
            f"have {voxels.ndim} axes of {voxels.dtype}, must be three of whole numbers",
            "Give an array (nx, ny, nz) of labels.",
        )
    if spacing is None:
        raise ScenarioError("spacing", "is missing", "Give the edges of a voxel [m].")
    given = numbers(spacing)
    edge = vector("spacing", np.full(3, given) if given.shape == () else spacing)
    for name, along in zip("xyz", edge, strict=True):
        length(f"spacing along {name}", along)
    return voxels, np.asarray(edge), np.asarray(vector("origin", origin)), np.eye(3)


def _lattice(
    voxels: AnyArray, edge: FloatArray, point_spacing: float, wanted: tuple[int, ...]
) -> tuple[FloatArray, AnyArray]:
    """Points inside the wanted voxels, from the middle of voxel (0, 0, 0), and their labels."""
    extent = edge * voxels.shape
    refuse_too_many("labels", float(np.prod(extent / point_spacing)))
    counts = np.maximum(1, np.rint(extent / point_spacing)).astype(int)
    along = [(np.arange(n) + 0.5) / n for n in counts]  # parts of the extent
    index = [
        np.minimum((f * n).astype(int), n - 1) for f, n in zip(along, voxels.shape, strict=True)
    ]
    codes = voxels[np.ix_(*index)]
    inside = np.nonzero(np.isin(codes, wanted))
    axes = [f * length - 0.5 * step for f, length, step in zip(along, extent, edge, strict=True)]
    position = np.column_stack([axes[a][inside[a]] for a in range(3)])
    return position, codes[inside]
