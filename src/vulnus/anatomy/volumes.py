"""Volumes of the tissues: on a fine lattice for the points, and against the labels as a check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import Float32Array, FloatArray, LabelArray
from vulnus.core.handoff import LabelVolume, LimbModel, Tissue

from .tissue_map import TissueMap

LATTICE_PITCH = 1.0e-3
"""Pitch of the lattice that measures the tissues [m]; chosen: half the skin's thickness, and a
litre then counts a million points."""

FEWEST_POINTS = 50
"""Tissues with fewer points than this share the limb's mean volume a point; chosen: below it the
quotient of volume and count is noise (14 %)."""


@dataclass(frozen=True, slots=True)
class TissueVolume:
    """One tissue's volume [m³] in the label volume and in the limb that was made from it."""

    tissue: Tissue
    in_labels: float
    in_limb: float

    @property
    def change_fraction(self) -> float:
        """(limb - labels) / labels; infinite where the labels had none."""
        if self.in_labels == 0.0:
            return float("inf")
        return self.in_limb / self.in_labels - 1.0


def measure_tissues(tissues: TissueMap) -> FloatArray:
    """Part of the limb (256,) that each tissue code takes, from a regular lattice inside it."""
    low, high = tissues.outer.bounds
    first, last = np.ceil(low / LATTICE_PITCH), np.floor(high / LATTICE_PITCH)
    x, y, z = (
        LATTICE_PITCH * np.arange(a, b + 1, dtype=np.float64)
        for a, b in zip(first, last, strict=True)
    )
    plane = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    count = np.zeros(256, dtype=np.float64)
    layers = max(1, 400_000 // max(len(plane), 1))
    for start in range(0, len(z), layers):
        heights = z[start : start + layers]
        points = np.column_stack(
            [np.tile(plane, (len(heights), 1)), np.repeat(heights, len(plane))]
        )
        inside = points[tissues.outer.sample(points) < 0.0]
        if len(inside):
            count += np.bincount(tissues.tissue_at(inside), minlength=256)
    return count / max(count.sum(), 1.0)


def point_volumes(tissue: LabelArray, fraction: FloatArray, limb_volume: float) -> Float32Array:
    """Volume (n,) [m³] of each point; the points of a tissue share its part, all sum to the limb.

    `tissue` (n,) codes, `fraction` (256,) the tissues' parts of `limb_volume` [m³].
    """
    count = np.bincount(tissue, minlength=256)
    share = np.full(256, 1.0 / len(tissue))
    enough = (count >= FEWEST_POINTS) & (fraction > 0.0)
    share[enough] = fraction[enough] / count[enough]
    volume = share[tissue]
    return np.asarray(volume * (limb_volume / volume.sum()), dtype=np.float32)


def compare_volumes(labels: LabelVolume, limb: LimbModel) -> tuple[TissueVolume, ...]:
    """Volume of each tissue in the labels and in the limb, for every tissue that either has."""
    voxel = float(np.prod(labels.spacing) * abs(np.linalg.det(labels.direction)))
    in_labels = voxel * np.bincount(labels.labels.ravel(), minlength=256)
    in_limb = np.bincount(limb.tissue, weights=limb.volume.astype(np.float64), minlength=256)
    return tuple(
        TissueVolume(tissue, float(in_labels[tissue]), float(in_limb[tissue]))
        for tissue in Tissue
        if tissue != Tissue.AIR and (in_labels[tissue] > 0.0 or in_limb[tissue] > 0.0)
    )
