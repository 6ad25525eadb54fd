"""The example legs load with their tissues and arteries (skipped where the data are absent)."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import InputFileError
from vulnus.core.handoff import Tissue
from vulnus.imaging import ImagingParameters, load_labels

VHF = "vhf_left_lower_leg/vhf_left_lower_leg_labels5_0p75mm.seg.nrrd"
VHF_STRUCTURES = "vhf_left_lower_leg/vhf_left_lower_leg_structures_0p75mm.seg.nrrd"
BP3D = "bp3d_left_lower_leg/bp3d_left_lower_leg_labels5_1mm.nrrd"
MAIN = {"popliteal", "anterior_tibial", "posterior_tibial", "fibular"}


@pytest.mark.parametrize(
    ("name", "litres"), [(VHF, 2.434), (BP3D, 2.997)], ids=["visible_human", "bodyparts3d"]
)
def test_a_real_leg_comes_with_the_centrelines_beside_it(shared_data, name, litres):
    volume = load_labels(ImagingParameters(source=shared_data / name))
    cell = np.prod(volume.spacing)
    # Volumes counted from the files with numpy alone; the reader must not lose a voxel.
    assert (volume.labels > 0).sum() * cell == pytest.approx(litres * 1e-3, rel=1e-3)
    assert set(np.unique(volume.labels)) == {0, 1, 2, 3, 4}
    arteries = {artery.name: artery for artery in volume.arteries}
    assert arteries.keys() >= MAIN
    for name_of_artery in MAIN:
        artery = arteries[name_of_artery]
        index = np.rint((artery.points - volume.origin) / volume.spacing).astype(int)
        inside = volume.labels[tuple(np.minimum(index, np.array(volume.labels.shape) - 1).T)]
        assert (inside == Tissue.ARTERY).all()
        assert artery.points[0, 2] > artery.points[-1, 2]
        assert artery.parent == (None if name_of_artery == "popliteal" else "popliteal")


def test_branches_of_a_real_leg_run_away_from_their_parents(shared_data):
    volume = load_labels(ImagingParameters(source=shared_data / BP3D))
    parents = {artery.name: artery.parent for artery in volume.arteries}
    assert parents["dorsalis_pedis"] == "anterior_tibial"
    assert parents["anterior_tibial_recurrent"] == "anterior_tibial"
    assert parents["medial_plantar"] == parents["lateral_plantar"] == "posterior_tibial"


def test_the_structure_volume_is_read_by_its_segment_names(shared_data):
    volume = load_labels(ImagingParameters(source=shared_data / VHF_STRUCTURES))
    coarse = load_labels(ImagingParameters(source=shared_data / VHF))
    assert np.array_equal(volume.labels == Tissue.SKIN, coarse.labels == Tissue.SKIN)
    assert np.array_equal(volume.labels == Tissue.ARTERY, coarse.labels == Tissue.ARTERY)
    soft = np.isin(volume.labels, [Tissue.MUSCLE, Tissue.FAT])
    # Cartilage is soft tissue here and bone in part of the five labels: 0.05 ml.
    assert (soft != (coarse.labels == Tissue.MUSCLE)).sum() < 200


def test_structures_without_names_are_refused_with_the_list(shared_data):
    path = shared_data / "bp3d_left_lower_leg" / "bp3d_left_lower_leg_structures_1mm.nrrd"
    with pytest.raises(InputFileError, match="10, 11, 12"):
        load_labels(ImagingParameters(source=path))
