"""Building the limb: surfaces, points, tissues, volumes."""

from __future__ import annotations

import numpy as np

from vulnus.core.errors import AnatomyError
from vulnus.core.handoff import LabelVolume, LimbModel, Tissue, TriangleSurface
from vulnus.core.progress import Progress, SilentProgress
from vulnus.geometry import sample_poisson_disk
from vulnus.geometry.poisson_disk import EXPECTED_DENSITY

from .artery_paths import find_arteries
from .checks import LOG, check_labels, drop_stray_parts, report_limb
from .parameters import AnatomyParameters
from .tissue_map import TissueMap, map_tissues
from .volumes import measure_tissues, point_volumes

SILENT = SilentProgress()


class _Points:
    """Passes the sampler's progress on as the middle part of the stage's own bar."""

    def __init__(self, progress: Progress, expected: float) -> None:
        self._progress = progress
        self._expected = max(expected, 1.0)

    def begin(self, stage: str, total: float, unit: str) -> None:
        """The stage has begun already."""

    def update(self, completed: float, note: str = "") -> None:
        """Pass on `completed` points of those expected."""
        self._progress.update(30.0 + 40.0 * min(completed / self._expected, 1.0), note)

    def end(self) -> None:
        """The stage goes on."""


def build_limb(
    labels: LabelVolume, parameters: AnatomyParameters, progress: Progress = SILENT
) -> LimbModel:
    """The limb as one Poisson-disk set of material points with a tissue and a volume each.

    Where the image cuts the limb (labels on a face of the volume) the limb ends in a plane without
    skin: the surface goes on beyond it when distances are measured, so the cut shows the tissues.
    `surfaces` holds "skin" (the closed outer surface with the cut planes), "bone", "muscle" and
    one tube for each artery. A volume with an artery label and no centre-lines gets them from the
    label where that works (`find_arteries`). Raises `AnatomyError` for volumes without bone,
    without labelled voxels, with several limbs, and for spacings that do not resolve the skin.
    """
    progress.begin("anatomy", 100.0, "%")
    check_labels(labels, parameters)
    limb_labels = drop_stray_parts(labels)
    if not (limb_labels.labels == Tissue.SKIN).any():
        LOG.warning("%s: no skin label; the skin is made as a shell", labels.source)
    progress.update(5.0, "surfaces")
    arteries = limb_labels.arteries or find_arteries(limb_labels)
    tissues = map_tissues(limb_labels, arteries, parameters)
    limb_volume = tissues.outer.volume()
    expected = EXPECTED_DENSITY * limb_volume / parameters.particle_spacing**3
    progress.update(30.0, "points")
    position = sample_poisson_disk(
        tissues.outer,
        spacing=parameters.particle_spacing,
        seed=parameters.seed,
        progress=_Points(progress, expected),
    )
    if not len(position):
        raise AnatomyError(
            labels.source,
            f"no point fits in a limb of {1e6 * limb_volume:.3g} ml",
            "Check the volume's spacing, or take a smaller particle_spacing_mm.",
        )
    progress.update(70.0, "tissues")
    tissue = tissues.tissue_at(position)
    volume = point_volumes(tissue, measure_tissues(tissues), limb_volume)
    progress.update(90.0, "meshes")
    limb = LimbModel(
        position=position,
        tissue=tissue,
        volume=volume,
        spacing=parameters.particle_spacing,
        arteries=arteries,
        surfaces=_surfaces(tissues),
        side=labels.side,
        source=labels.source,
    )
    report_limb(limb_labels, limb)
    progress.end()
    return limb


def _surfaces(tissues: TissueMap) -> dict[str, TriangleSurface]:
    under_skin = tissues.muscle
    if under_skin is None:
        under_skin = tissues.outer.offset(-tissues.skin_thickness)
    level_sets = {
        "skin": tissues.outer,
        "bone": tissues.bone,
        "muscle": under_skin,
        **tissues.tubes,
    }
    meshes = {name: level_set.to_surface() for name, level_set in level_sets.items()}
    return {name: mesh for name, mesh in meshes.items() if np.size(mesh.triangles)}
