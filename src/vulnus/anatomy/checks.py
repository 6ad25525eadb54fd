"""What a label volume must have, and what a user should know about the limb made from it."""

from __future__ import annotations

import logging

import numpy as np

from vulnus.core.errors import AnatomyError
from vulnus.core.handoff import LabelVolume, LimbModel, Tissue
from vulnus.core.units import MILLIMETRE

from .parameters import AnatomyParameters
from .tissue_map import BONE_TISSUES
from .volumes import compare_volumes

LOG = logging.getLogger("vulnus.anatomy")

COARSEST_SPACING = 2.0
"""Particle spacing over skin thickness above which the shell has holes; chosen: points fill space
to one per 1.4 spacing³, so a shell of half a spacing has one point per 2.8 spacing²."""

LARGEST_STRAY_FRACTION = 0.02
"""Labelled voxels apart from the limb, as a fraction of it, that are dropped; chosen: specks and
markers, not a second limb."""

NOTED_CHANGE = 0.10
"""Change of a tissue's volume against its label that is logged; chosen: five times what smoothing
does to bone at the usual resolution."""


def check_labels(labels: LabelVolume, parameters: AnatomyParameters) -> None:
    """Refuse volumes and parameters that no limb can be made from (`AnatomyError`)."""
    present = np.bincount(labels.labels.ravel(), minlength=256)
    if present[1:].sum() == 0:
        raise AnatomyError(
            labels.source,
            f"all {labels.labels.size} voxels are air (label 0)",
            "Check that the file holds a segmentation and that its label map is right.",
        )
    if not any(present[tissue] for tissue in BONE_TISSUES):
        names = ", ".join(
            f"{Tissue(code).name.lower()} ({code})" if code < len(Tissue) else str(code)
            for code in np.flatnonzero(present).tolist()
        )
        raise AnatomyError(
            labels.source,
            f"no voxel has a bone label (3 bone, 6 marrow, 7 cancellous); it has {names}",
            "Segment the bones, or name their label value in [imaging.labels] bone = ....",
        )
    _check_lengths(labels, parameters)


def _check_lengths(labels: LabelVolume, parameters: AnatomyParameters) -> None:
    spacing, thickness = parameters.particle_spacing, parameters.skin_thickness
    lengths = {
        "anatomy.particle_spacing_mm": spacing,
        "anatomy.skin_thickness_mm": thickness,
        "anatomy.level_set_voxel_mm": parameters.level_set_voxel,
    }
    for name, value in lengths.items():
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise AnatomyError(
                name, f"{value / MILLIMETRE:g} mm is not positive", "Give a length above 0."
            )
    if spacing > COARSEST_SPACING * thickness:
        limit = COARSEST_SPACING * thickness / MILLIMETRE
        raise AnatomyError(
            "anatomy.particle_spacing_mm",
            f"{spacing / MILLIMETRE:g} mm is too coarse for a skin of "
            f"{thickness / MILLIMETRE:g} mm (limit {limit:g} mm): its points would leave holes",
            "Take a smaller particle_spacing_mm or a larger skin_thickness_mm.",
        )
    voxel = parameters.level_set_voxel
    if voxel is not None and voxel > thickness:
        raise AnatomyError(
            "anatomy.level_set_voxel_mm",
            f"{voxel / MILLIMETRE:g} mm does not resolve a skin of {thickness / MILLIMETRE:g} mm",
            "Take a level_set_voxel_mm of at most half the skin_thickness_mm.",
        )
    extent = float(max(np.multiply(labels.labels.shape, labels.spacing)))
    if spacing > 0.1 * extent:
        raise AnatomyError(
            "anatomy.particle_spacing_mm",
            f"{spacing / MILLIMETRE:g} mm is too coarse for a volume of {extent / MILLIMETRE:g} mm",
            "Take a smaller particle_spacing_mm, and check the volume's spacing (mm or m?).",
        )


def drop_stray_parts(labels: LabelVolume) -> LabelVolume:
    """The volume with its largest connected part only; refuses volumes with more than one limb."""
    from dataclasses import replace

    import cc3d

    labelled = labels.labels != Tissue.AIR
    parts, count = cc3d.connected_components(labelled, connectivity=26, return_N=True)
    if count <= 1:
        return labels
    sizes = np.bincount(parts.ravel())[1:]
    limb = int(np.argmax(sizes)) + 1
    stray = int(sizes.sum() - sizes[limb - 1])
    if stray > LARGEST_STRAY_FRACTION * sizes[limb - 1]:
        raise AnatomyError(
            labels.source,
            f"the labelled voxels form {count} separate parts; those beside the largest have "
            f"{stray / sizes[limb - 1]:.0%} of its voxels (limit {LARGEST_STRAY_FRACTION:.0%})",
            "Crop the volume to one limb.",
        )
    LOG.warning("%s: %d stray voxels apart from the limb dropped", labels.source, stray)
    return replace(labels, labels=np.where(parts == limb, labels.labels, 0).astype(np.uint8))


def report_limb(labels: LabelVolume, limb: LimbModel) -> None:
    """Refuse a limb that lost its bone; log every tissue whose volume changed noticeably."""
    for change in compare_volumes(labels, limb):
        name = change.tissue.name.lower()
        if change.tissue in BONE_TISSUES and change.in_labels > 0.0 and change.in_limb == 0.0:
            LOG.warning("%s: no material point lies in its %s", labels.source, name)
        # The skin's volume follows from the thickness asked for, so a change is no surprise.
        surprising = change.in_labels > 0.0 and change.tissue != Tissue.SKIN
        changed = surprising and abs(change.change_fraction) > NOTED_CHANGE
        LOG.log(
            logging.WARNING if changed else logging.INFO,
            "%s: %s has %.1f ml in the labels and %.1f ml in the limb",
            labels.source,
            name,
            1e6 * change.in_labels,
            1e6 * change.in_limb,
        )
    if not np.isin(limb.tissue, BONE_TISSUES).any():
        raise AnatomyError(
            labels.source,
            f"its bone is too thin for points {limb.spacing / MILLIMETRE:g} mm apart",
            "Take a smaller particle_spacing_mm.",
        )
