"""What lies at a point of the limb: smooth surfaces first, then the labels.

Smoothing a thin label by its own signed distance deletes it (2 mm skin at 1.5 mm: all of it), so
the skin is the shell {-t < outer < 0} of the smoothed outer surface, and an artery is a tube on
its centre-line. Each point has one tissue, by priority: artery > bone > skin > soft tissue.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import BoolArray, Float32Array, FloatArray, LabelArray
from vulnus.core.handoff import ArteryCentreline, LabelVolume, Tissue
from vulnus.geometry import LevelSet

from .label_grid import CutEnd, crop_and_continue, cut_ends, nearest_label
from .parameters import AnatomyParameters

BONE_TISSUES = (Tissue.BONE, Tissue.CANCELLOUS, Tissue.MARROW)
SOFT_TISSUES = (Tissue.MUSCLE, Tissue.FAT)

STAIR_SMOOTHING = 2.0
"""Filter that takes off the stairs of the labels' voxels [voxels]. Chosen by looking: 1.5 leaves
terraces on shallow slopes, 3 rounds the toes. The surfaces are then moved evenly (0.02-0.1 mm) to
hold the volume of their labels again."""

ARTERY_VOXEL = 0.4e-3
"""Largest voxel of the tubes [m]; chosen: two voxels in the radius of a 0.8 mm artery."""


@dataclass(frozen=True, slots=True)
class TissueMap:
    """The limb's surfaces: `whole` goes on beyond the cut ends, `outer` and `bone` end there."""

    labels: LabelVolume
    whole: LevelSet
    outer: LevelSet
    bone: LevelSet
    muscle: LevelSet | None
    tubes: Mapping[str, LevelSet]
    skin_thickness: float

    def tissue_at(self, points: FloatArray | Float32Array) -> LabelArray:
        """The tissue (n,) at points (n, 3) [m] inside the limb."""
        places = np.asarray(points, dtype=np.float64)
        tissue = np.full(len(places), int(Tissue.MUSCLE), dtype=np.uint8)
        in_tube = np.zeros(len(places), dtype=bool)
        for tube in self.tubes.values():
            in_tube |= tube.sample(points) < 0.0
        in_bone = self.bone.sample(points) < 0.0
        in_skin = self.whole.sample(points) > -self.skin_thickness
        soft = ~(in_tube | in_bone | in_skin)
        tissue[in_skin] = Tissue.SKIN
        tissue[soft] = self._soft_tissue(places[soft])
        tissue[in_bone] = nearest_label(self.labels, places[in_bone], BONE_TISSUES, Tissue.BONE)
        tissue[in_tube] = Tissue.ARTERY
        return tissue

    def _soft_tissue(self, places: FloatArray) -> LabelArray:
        # Beyond the window round a place with neither, there is skin on its label side: take fat
        # where the volume tells fat from muscle.
        has_fat = bool((self.labels.labels == Tissue.FAT).any())
        return nearest_label(
            self.labels, places, SOFT_TISSUES, Tissue.FAT if has_fat else Tissue.MUSCLE
        )


def level_set_voxel(volume: LabelVolume, parameters: AnatomyParameters) -> float:
    """The voxel of the limb's level sets [m]."""
    if parameters.level_set_voxel is not None:
        return parameters.level_set_voxel
    finest = 0.5 * float(volume.spacing.min())
    return max(min(0.5 * parameters.particle_spacing, 0.5 * parameters.skin_thickness), finest)


def map_tissues(
    volume: LabelVolume,
    arteries: tuple[ArteryCentreline, ...],
    parameters: AnatomyParameters,
) -> TissueMap:
    """Smooth the outer, bone and muscle surfaces of a label volume and lay the arteries' tubes."""
    voxel = level_set_voxel(volume, parameters)
    ends = cut_ends(volume)
    margin = parameters.skin_thickness + 8.0 * voxel + 3.0 * float(volume.spacing.max())
    labels = crop_and_continue(volume, margin)
    half_width = max(3.0, parameters.skin_thickness / voxel + 1.5)
    whole = _smooth_surface(labels, labels.labels != Tissue.AIR, voxel, half_width, parameters)
    is_bone = np.isin(labels.labels, BONE_TISSUES)
    bone = _smooth_surface(labels, is_bone, voxel, 3.0, parameters)
    muscle = None
    if (labels.labels == Tissue.FAT).any():
        under_fat = ~np.isin(labels.labels, (Tissue.AIR, Tissue.SKIN, Tissue.FAT))
        muscle = _end(_smooth_surface(labels, under_fat, voxel, 3.0, parameters), ends)
    tubes = {artery.name: _end(_tube(artery, voxel), ends) for artery in arteries}
    return TissueMap(
        labels=labels,
        whole=whole,
        outer=_end(whole, ends),
        bone=_end(bone, ends),
        muscle=muscle,
        tubes=tubes,
        skin_thickness=parameters.skin_thickness,
    )


def _smooth_surface(
    labels: LabelVolume,
    mask: BoolArray,
    voxel: float,
    half_width: float,
    parameters: AnatomyParameters,
) -> LevelSet:
    level_set = LevelSet.from_mask(
        mask,
        origin=labels.origin,
        spacing=labels.spacing,
        direction=labels.direction,
        voxel=voxel,
        stair_smoothing=STAIR_SMOOTHING,
        half_width=half_width,
    )
    smooth = level_set.mean_curvature_flow(parameters.smoothing_iterations)
    return smooth.with_volume(level_set.volume())


def _tube(artery: ArteryCentreline, voxel: float) -> LevelSet:
    return LevelSet.from_tube(artery.points, artery.radius, voxel=min(voxel, ARTERY_VOXEL))


def _end(level_set: LevelSet, ends: tuple[CutEnd, ...]) -> LevelSet:
    for end in ends:
        level_set = level_set.cut(end.normal, end.offset)
    return level_set
