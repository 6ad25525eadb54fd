"""The two example legs: volumes, arteries, ends (skipped without the shared data)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vulnus.anatomy import AnatomyParameters, build_limb, compare_volumes
from vulnus.anatomy.artery_paths import find_arteries
from vulnus.core.handoff import Tissue
from vulnus.imaging import ImagingParameters, load_labels

# Relative change against the labels. Skin is made anew (its label is 2 mm thick, on voxels of
# 0.75 and 1 mm); the arteries' tubes replace voxels of their own size.
CHANGE = {Tissue.SKIN: 0.02, Tissue.MUSCLE: 0.005, Tissue.BONE: 0.01, Tissue.ARTERY: 0.09}
FILES = (
    "vhf_left_lower_leg/vhf_left_lower_leg_labels5_0p75mm.seg.nrrd",
    "bp3d_left_lower_leg/bp3d_left_lower_leg_labels5_1mm.nrrd",
)


@pytest.fixture(scope="module", params=FILES)
def leg(request, shared_data):
    source = shared_data / request.param
    if not source.is_file():
        pytest.skip(f"no {source}")
    labels = load_labels(ImagingParameters(source=source))
    # Points of 3 mm on surfaces of 0.75 mm: the surfaces are those of a real run, the points few.
    parameters = AnatomyParameters(particle_spacing=3e-3, level_set_voxel=0.75e-3)
    return labels, build_limb(labels, parameters)


@pytest.mark.slow
def test_volumes_arteries_and_ends_of_a_real_leg(leg):
    labels, limb = leg
    for change in compare_volumes(labels, limb):
        assert abs(change.change_fraction) < CHANGE[change.tissue], change
    names = {artery.name for artery in limb.arteries}
    assert {"popliteal", "anterior_tibial", "posterior_tibial", "fibular"} <= names
    assert names | {"skin", "bone"} <= set(limb.surfaces)
    top = labels.origin[2] + (labels.labels.shape[2] - 0.5) * labels.spacing[2]
    assert limb.surfaces["skin"].vertices[:, 2].max() == pytest.approx(top, abs=1e-5)
    cut = limb.position[:, 2] > top - 2e-3
    assert (limb.tissue[cut] == Tissue.SKIN).mean() < 0.2  # a ring, not a lid


@pytest.mark.slow
def test_centre_lines_from_the_label_are_those_of_the_file(leg):
    labels, _ = leg
    from dataclasses import replace

    given = {artery.name: artery for artery in labels.arteries}
    found = {artery.name: artery for artery in find_arteries(replace(labels, arteries=()))}
    for name in ("anterior_tibial", "posterior_tibial", "fibular"):
        # Compared in the middle half: where a vessel begins and ends is a matter of definition.
        points = found[name].points
        middle = points[len(points) // 4 : len(points) // 2]
        assert np.median(cKDTree(given[name].points).query(middle)[0]) < 1e-3  # a voxel
        assert found[name].radius.mean() == pytest.approx(given[name].radius.mean(), rel=0.1)
