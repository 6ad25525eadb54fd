"""Volumes and parameters that no limb can be made from are refused with advice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vulnus.anatomy import AnatomyParameters, build_limb
from vulnus.core.errors import AnatomyError
from vulnus.core.handoff import Tissue


def refuse(labels, parameters=None):
    with pytest.raises(AnatomyError) as caught:
        build_limb(labels, parameters or AnatomyParameters())
    assert caught.value.exit_code == 4
    assert caught.value.advice
    return caught.value


def test_a_volume_without_bone(make_limb):
    labels = make_limb()
    soft = np.where(np.isin(labels.labels, (3, 6)), 2, labels.labels).astype(np.uint8)
    error = refuse(replace(labels, labels=soft))
    assert error.subject == "synthetic limb"
    assert "bone" in error.problem
    assert "skin (1)" in error.problem
    assert "[imaging.labels]" in error.advice


def test_an_empty_volume(make_limb):
    labels = make_limb()
    error = refuse(replace(labels, labels=np.zeros_like(labels.labels)))
    assert "air" in error.problem


def test_two_limbs_in_one_volume(make_limb):
    labels = make_limb()
    both = np.concatenate([labels.labels, labels.labels], axis=0)
    assert "2 separate parts" in refuse(replace(labels, labels=both)).problem


def test_a_speck_beside_the_limb_is_dropped(make_limb, caplog):
    labels = make_limb()
    specked = labels.labels.copy()
    specked[0, 0, 0] = Tissue.SKIN
    limb = build_limb(replace(labels, labels=specked), AnatomyParameters(particle_spacing=3e-3))
    assert "stray" in caplog.text
    assert np.hypot(*(limb.position[:, :2] - limb.position[:, :2].mean(axis=0)).T).max() < 0.026


@pytest.mark.parametrize(
    ("change", "subject"),
    [
        ({"particle_spacing": 5e-3}, "anatomy.particle_spacing_mm"),
        ({"particle_spacing": -1e-3}, "anatomy.particle_spacing_mm"),
        ({"skin_thickness": 0.0}, "anatomy.skin_thickness_mm"),
        ({"level_set_voxel": 4e-3}, "anatomy.level_set_voxel_mm"),
        ({"level_set_voxel": float("nan")}, "anatomy.level_set_voxel_mm"),
    ],
)
def test_spacings_that_do_not_resolve_the_skin(make_limb, change, subject):
    assert refuse(make_limb(), AnatomyParameters(**change)).subject == subject


def test_a_volume_in_the_wrong_unit(make_limb):
    labels = make_limb()
    error = refuse(replace(labels, spacing=labels.spacing * 1e-3))
    assert "mm" in error.problem
