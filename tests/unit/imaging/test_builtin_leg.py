"""The built-in leg has the girths, volumes, bones and arteries of its table, at any voxel size."""

from __future__ import annotations

import cc3d
import numpy as np
import pytest

from vulnus.core.handoff import LabelVolume, Tissue
from vulnus.imaging import ImagingParameters, LegMeasurements, generate_leg
from vulnus.imaging.leg_shape import GIRTH_LEVELS, HIGHEST_LEVEL, LegShape
from vulnus.imaging.leg_tables import read_table
from vulnus.imaging.measurements import read_measurements

LEG = LegMeasurements()
BONES = (Tissue.BONE, Tissue.CANCELLOUS, Tissue.MARROW)


@pytest.fixture(scope="module")
def leg() -> LabelVolume:
    return generate_leg(ImagingParameters(voxel=1.5e-3))


@pytest.fixture(scope="module")
def shape() -> LegShape:
    return LegShape(LEG)


def volumes_ml(volume: LabelVolume) -> np.ndarray:
    counts = np.bincount(volume.labels.ravel(), minlength=len(Tissue))
    return counts * np.prod(volume.spacing) * 1e6


def labels_at(volume: LabelVolume, points: np.ndarray) -> np.ndarray:
    index = np.rint((points - volume.origin) / volume.spacing).astype(int)
    index = np.clip(index, 0, np.array(volume.labels.shape) - 1)
    return volume.labels[tuple(index.T)]


def test_every_number_of_the_table_has_a_source():
    for name, entry in read_measurements().items():
        assert entry.value > 0, name
        assert len(entry.source) > 20, name


def test_girths_are_those_asked_for(shape):
    for level, girth in zip(
        GIRTH_LEVELS, (LEG.ankle_girth, LEG.calf_girth, LEG.knee_girth), strict=True
    ):
        # The scale is found by fixed-point iteration; 1e-6 is far below a voxel.
        assert shape.section(level).skin.girth == pytest.approx(girth, rel=1e-6)


def test_the_calf_is_the_widest_and_the_ankle_the_narrowest_place(shape):
    levels = np.linspace(0.0, HIGHEST_LEVEL, 80)
    girths = np.array([shape.section(level).skin.girth for level in levels])
    # The table's greatest and least girths hold over the whole leg within 1 % (tape error 3-5 mm).
    assert girths.max() == pytest.approx(LEG.calf_girth, rel=0.01)
    assert girths.min() == pytest.approx(LEG.ankle_girth, rel=0.01)
    assert 0.65 < levels[girths.argmax()] < 0.80
    assert 0.08 < levels[girths.argmin()] < 0.22
    # No step: girth changes by less than 12 mm per 1.25 % of the tibia (4.6 mm).
    assert np.abs(np.diff(girths)).max() < 12e-3


def test_bones_have_the_section_areas_of_the_literature(shape):
    tibia, fibula = shape.section(0.5).bones
    # Adult men at mid-shaft: tibia 380-520 mm² in all, 260-380 mm² of cortex; fibula 90-140 mm².
    assert 380e-6 < tibia.outer.area < 520e-6
    assert 260e-6 < tibia.outer.area - tibia.inner.area < 380e-6
    assert 90e-6 < fibula.outer.area < 140e-6
    breadth = np.ptp(shape.section(0.965).bones[0].outer.points[:, 0])
    assert breadth == pytest.approx(read_measurements()["plateau_breadth"].value, rel=0.04)


def test_volumes_do_not_depend_on_the_voxel_size(leg):
    other = generate_leg(ImagingParameters(voxel=1.1e-3))
    fine, coarse = volumes_ml(other), volumes_ml(leg)
    # The cut under the knee falls on a whole voxel, so each volume may miss half a slice there.
    top = np.bincount(leg.labels[:, :, -1].ravel(), minlength=len(Tissue)) * 1.5**2 * 1e-3
    cut = 0.5 * (1.5 + 1.1) * top
    # Counting voxel centres errs by well under 1 % for a shape of many voxels; the lumina are one
    # or two voxels wide, and the voxels on the centre-line are always counted.
    part = np.where(np.arange(len(Tissue)) == Tissue.ARTERY, 0.10, 0.01)
    difference = np.abs(coarse - fine)[1:]
    assert (difference <= (part * fine + cut)[1:]).all(), (coarse, fine)
    # A man's lower leg without foot: 2.4-3.2 l (Dempster 1955: 4.5 % of 75 kg is 3.4 kg).
    assert 2.2e3 < fine[1:].sum() < 3.4e3


def test_skin_closes_the_leg(leg):
    """Every voxel beside air is skin, so no tissue lies bare except at the cut ends.

    It must be so wherever the skin is thicker than a voxel.
    """
    assert leg.spacing.max() < LEG.skin_thickness
    inside = leg.labels > 0
    for axis in (0, 1):
        for step in (1, -1):
            bare = inside & ~np.roll(inside, step, axis)
            assert (leg.labels[bare] == Tissue.SKIN).all()


def test_tissues_are_connected(leg):
    assert cc3d.connected_components(leg.labels > 0, connectivity=6).max() == 1
    assert cc3d.connected_components(leg.labels == Tissue.SKIN, connectivity=26).max() == 1
    assert cc3d.connected_components(leg.labels == Tissue.ARTERY, connectivity=26).max() == 1
    bones = cc3d.connected_components(np.isin(leg.labels, BONES), connectivity=6)
    sizes = np.sort(np.bincount(bones.ravel())[1:])[::-1]
    assert sizes[0] / sizes.sum() > 0.85
    assert sizes[:2].sum() == sizes.sum()


def test_arteries_lie_in_soft_tissue_clear_of_bone_and_skin(leg, shape):
    for artery in leg.arteries:
        assert (labels_at(leg, artery.points) == Tissue.ARTERY).all(), artery.name
        for point, radius in zip(artery.points, artery.radius, strict=True):
            section = shape.section(float(point[2]) / LEG.tibia_length)
            for bone in section.bones:
                away, edge = bone.outer.radius_at(point[:1], point[1:2])
                assert away[0] - edge[0] > radius, (artery.name, point)
            away, edge = section.fat.radius_at(point[:1], point[1:2])
            assert edge[0] - away[0] > radius, (artery.name, point)


def test_the_tree_begins_where_the_parent_runs(leg):
    arteries = {artery.name: artery for artery in leg.arteries}
    assert list(arteries) == ["popliteal", "anterior_tibial", "posterior_tibial", "fibular"]
    for artery in leg.arteries:
        assert artery.points[0, 2] > artery.points[-1, 2]
        if artery.parent is not None:
            parent = arteries[artery.parent].points
            gap = np.linalg.norm(parent - artery.points[0], axis=1).min()
            assert gap < arteries[artery.parent].radius.min()


def test_the_anterior_tibial_artery_lies_before_the_membrane(leg, shape):
    """Between the bones, in front of the line that joins them; the other two lie behind it."""
    arteries = {artery.name: artery for artery in leg.arteries}
    for level in np.linspace(0.25, 0.75, 11):
        tibia, fibula = (bone.outer for bone in shape.section(level).bones)
        gaps = np.linalg.norm(tibia.points[:, None] - fibula.points[None], axis=2)
        i, j = np.unravel_index(gaps.argmin(), gaps.shape)
        edge = fibula.points[j] - tibia.points[i]
        ahead = np.array([edge[1], -edge[0]]) / np.linalg.norm(edge)
        places = {}
        for name in ("anterior_tibial", "posterior_tibial", "fibular"):
            z = arteries[name].points[:, 2]
            point = arteries[name].points[np.abs(z - level * LEG.tibia_length).argmin(), :2]
            places[name] = float((point - tibia.points[i]) @ ahead)
            if name == "anterior_tibial":
                along = float((point - tibia.points[i]) @ edge) / float(edge @ edge)
        assert 0.0 < along < 1.0
        # On the membrane: not more than 8 mm in front of it (Gray's Anatomy).
        assert 0.0 < places["anterior_tibial"] < 8e-3
        assert places["posterior_tibial"] < 0.0
        assert places["fibular"] < 0.0


def test_sections_are_no_circles(shape):
    for level in np.linspace(0.02, 0.95, 20):
        skin = shape.section(level).skin
        # A circle has 1; every section of a leg is flatter or more angular.
        assert 4 * np.pi * skin.area / skin.girth**2 < 0.995
    tibia = shape.section(0.6).bones[0].outer
    # A triangle with rounded corners: well under a circle, over an equilateral triangle's 0.60.
    assert 0.60 < 4 * np.pi * tibia.area / tibia.girth**2 < 0.93


def test_the_shin_is_thinly_covered_and_the_calf_is_not(shape):
    section = shape.section(0.6)
    tibia = section.bones[0].outer
    away, edge = section.skin.radius_at(*tibia.points.T)
    assert (edge - away).min() < 8e-3
    behind = section.skin.points[:, 1].max() - tibia.points[:, 1].max()
    assert behind > 50e-3


def test_the_right_leg_is_the_left_one_mirrored():
    left, right = (generate_leg(ImagingParameters(voxel=4e-3, side=s)) for s in ("left", "right"))
    assert np.array_equal(right.labels, left.labels[::-1])
    x = left.origin[0] + left.spacing[0] * np.arange(left.labels.shape[0])
    assert right.origin[0] == pytest.approx(-x[-1], abs=1e-12)
    for a, b in zip(left.arteries, right.arteries, strict=True):
        np.testing.assert_array_equal(b.points, a.points * [-1, 1, 1])


def test_the_fibula_is_lateral_and_behind(leg, shape):
    tibia, fibula = (bone.outer.centre for bone in shape.section(0.5).bones)
    assert leg.side == "left"
    assert fibula[0] > tibia[0] + 15e-3
    assert fibula[1] > tibia[1]


@pytest.mark.parametrize(("stature", "calf"), [(1.55, 0.33), (1.95, 0.45)])
def test_measurements_shape_the_leg(stature, calf):
    leg = LegMeasurements(stature=stature, calf_girth=calf, knee_girth=0.93 * calf)
    shape = LegShape(leg)
    assert shape.section(GIRTH_LEVELS[1]).skin.girth == pytest.approx(calf, rel=1e-6)
    volume = generate_leg(ImagingParameters(voxel=4e-3, leg=leg))
    length = volume.labels.shape[2] * volume.spacing[2]
    assert length == pytest.approx(HIGHEST_LEVEL * leg.tibia_length, abs=4e-3)
    assert set(np.unique(volume.labels)) >= {1, 2, 3, 4, 5, 7}


def test_the_same_leg_twice_has_the_same_voxels():
    first, second = (generate_leg(ImagingParameters(voxel=5e-3)) for _ in range(2))
    assert np.array_equal(first.labels, second.labels)


def test_tables_cover_the_whole_leg():
    for table in ("leg_fat", "leg_cortex"):
        levels = [float(row["level"]) for row in read_table(table)]
        assert levels == sorted(levels)
        assert levels[0] == 0.0
        assert levels[-1] == 1.0


@pytest.mark.parametrize("fraction", [0.25, 0.45, 0.6])
def test_a_shot_from_antero_lateral_reaches_the_anterior_tibial_artery(leg, fraction):
    """No bone stands before the artery on a horizontal line from 30-70 degrees lateral."""
    artery = next(a for a in leg.arteries if a.name == "anterior_tibial")
    target = artery.points[int(fraction * len(artery.points))]
    for azimuth in np.radians([30.0, 50.0, 70.0]):
        origin_side = np.array([np.sin(azimuth), -np.cos(azimuth), 0.0])
        path = target + np.arange(0.0, 0.08, 5e-4)[:, None] * origin_side
        met = labels_at(leg, path)
        assert not np.isin(met, BONES).any()
        assert met[0] == Tissue.ARTERY
        assert Tissue.SKIN in met
