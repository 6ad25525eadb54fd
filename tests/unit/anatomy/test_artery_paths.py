"""Centre-lines from the artery label: place, radius, branches, names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vulnus.anatomy import AnatomyParameters, build_limb
from vulnus.anatomy.artery_paths import find_arteries
from vulnus.core.handoff import LabelVolume, Tissue
from vulnus.geometry import LevelSet

from .conftest import ARTERY_RADIUS, LENGTH, rotation


def test_a_straight_artery_is_found_in_an_oblique_volume(make_limb):
    labels = make_limb((0.8e-3, 0.8e-3, 1.1e-3), rotation([1, 0, 2], 0.4), (0.2, 0.1, -0.3))
    (found,) = find_arteries(replace(labels, arteries=()))
    exact = labels.arteries[0]
    axis = (exact.points[-1] - exact.points[0]) / LENGTH
    off = found.points - exact.points[0]
    off -= np.outer(off @ axis, axis)
    away = np.linalg.norm(off, axis=1)
    assert away.max() < ARTERY_RADIUS  # the tip is a voxel at the wall
    assert away[1:-3].max() < 0.4e-3  # half a voxel
    assert found.radius.mean() == pytest.approx(ARTERY_RADIUS, rel=0.1)
    assert found.points[0, 2] > found.points[-1, 2]  # from proximal to distal
    assert np.linalg.norm(np.diff(found.points, axis=0), axis=1).sum() == pytest.approx(
        LENGTH, rel=0.03
    )


@pytest.fixture(scope="module", params=["left", "right"])
def tree(request):
    """A trunk with three vessels as in a leg of the given side, painted on 1 mm voxels."""
    sign = 1.0 if request.param == "left" else -1.0
    z = np.linspace(0, 1, 600)

    def vessel(start, end):
        return np.array(start) + z[:, None] * (np.array(end) - np.array(start))

    lines = {
        "popliteal": vessel([0, 0, 0.2], [0, 0, 0.15]),
        "anterior_tibial": vessel([0, 0, 0.17], [0.012 * sign, -0.03, 0.0]),
        "posterior_tibial": vessel([0, 0, 0.15], [-0.02 * sign, 0.005, 0.0]),
        "fibular": vessel([0, 0, 0.15], [0.02 * sign, 0.005, 0.0]),
    }
    origin, step = np.array([-0.03, -0.04, -0.005]), 1e-3
    index = np.stack(np.meshgrid(*[np.arange(n) for n in (60, 60, 212)], indexing="ij"), axis=-1)
    points = (origin + step * index).reshape(-1, 3)
    labels = np.full(len(points), Tissue.MUSCLE, dtype=np.uint8)
    for line in lines.values():
        inside = LevelSet.from_tube(line, np.full(600, 2e-3), voxel=1e-3).sample(points) < 0.0
        labels[inside] = Tissue.ARTERY
    volume = LabelVolume(
        labels.reshape(index.shape[:3]),
        origin,
        np.full(3, step),
        np.eye(3),
        (),
        "tree",
        request.param,
    )
    return volume, lines


def test_a_leg_tree_is_named_by_its_places(tree):
    volume, lines = tree
    found = {artery.name: artery for artery in find_arteries(volume)}
    assert set(found) == set(lines)
    assert found["popliteal"].parent is None
    for name in ("anterior_tibial", "posterior_tibial", "fibular"):
        assert found[name].parent == "popliteal"
        gap = cKDTree(lines[name]).query(found[name].points)[0]
        assert np.median(gap) < 0.7e-3
        assert found[name].radius.mean() == pytest.approx(2e-3, rel=0.15)


def test_other_trees_are_numbered(tree):
    volume, _ = tree
    half = volume.labels.copy()
    half[:, :20] = Tissue.MUSCLE  # takes the anterior vessel's distal part
    half[:30] = Tissue.MUSCLE
    names = [artery.name for artery in find_arteries(replace(volume, labels=half))]
    assert names
    assert names == [f"artery_{n + 1}" for n in range(len(names))]


def test_no_label_no_arteries(make_limb):
    labels = make_limb(arteries=False)
    bare = np.where(labels.labels == Tissue.ARTERY, Tissue.MUSCLE, labels.labels).astype(np.uint8)
    assert find_arteries(replace(labels, labels=bare)) == ()
    limb = build_limb(replace(labels, labels=bare), AnatomyParameters(particle_spacing=3e-3))
    assert limb.arteries == ()
    assert not (limb.tissue == Tissue.ARTERY).any()


def test_a_limb_without_centre_lines_takes_them_from_its_label(make_limb, caplog):
    limb = build_limb(make_limb(arteries=False), AnatomyParameters(particle_spacing=1.5e-3))
    assert [artery.name for artery in limb.arteries] == ["artery_1"]
    assert (limb.tissue == Tissue.ARTERY).any()
    assert "artery_1" in limb.surfaces
    assert "made from the label" in caplog.text
