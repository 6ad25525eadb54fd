"""Where a voxel lies does not depend on the file format, its space, units or axis order."""

from __future__ import annotations

from pathlib import Path

import nibabel
import numpy as np
import pytest

from vulnus.core.errors import InputFileError
from vulnus.imaging import ImagingParameters, load_labels

from . import volumes as v

TOLERANCE_MM = 2e-4
"""NIfTI keeps its affine in float32: 3e-5 mm at 300 mm, seven voxel steps added."""


def expected() -> dict[int, np.ndarray]:
    return v.points_by_label_mm(v.asymmetric_labels(), v.oblique_axes_mm(), v.ORIGIN_MM)


def found(path: Path) -> dict[int, np.ndarray]:
    with_arteries_warned = ImagingParameters(source=path)
    with pytest.warns(UserWarning, match="artery_centrelines"):
        volume = load_labels(with_arteries_warned)
    return v.points_by_label_mm(
        volume.labels, 1e3 * volume.direction * volume.spacing, 1e3 * volume.origin
    )


def assert_same_places(actual: dict[int, np.ndarray], wanted: dict[int, np.ndarray]) -> None:
    assert actual.keys() == wanted.keys()
    for value, points in wanted.items():
        # Order by nearest partner: rounding may change the sorted order of equal coordinates.
        gaps = np.linalg.norm(actual[value][:, None] - points[None], axis=2)
        assert actual[value].shape == points.shape
        assert gaps.min(axis=1).max() < TOLERANCE_MM
        assert gaps.min(axis=0).max() < TOLERANCE_MM


@pytest.mark.parametrize(
    ("space", "signs"),
    [
        ("left-posterior-superior", (1, 1, 1)),
        ("LPS", (1, 1, 1)),
        ("right-anterior-superior", (-1, -1, 1)),
        ("RAS", (-1, -1, 1)),
        ("left-anterior-superior", (1, -1, 1)),
        ("LAS", (1, -1, 1)),
    ],
)
def test_nrrd_spaces_mean_the_same_places(tmp_path, space, signs):
    sign = np.array(signs)
    path = v.write_nrrd(
        tmp_path / "leg.nrrd",
        space=space,
        **{
            "space directions": (sign[:, None] * v.oblique_axes_mm()).T,
            "space origin": sign * v.ORIGIN_MM,
        },
    )
    assert_same_places(found(path), expected())


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2), (2, 1, 0)])
def test_nrrd_axis_order_does_not_matter(tmp_path, order):
    labels = v.asymmetric_labels().transpose(order)
    directions = v.oblique_axes_mm().T[list(order)]
    path = v.write_nrrd(tmp_path / "leg.nrrd", labels, **{"space directions": directions})
    assert_same_places(found(path), expected())


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("m", 1e-3), ("cm", 0.1), ("um", 1e3)])
def test_nrrd_space_units_are_honoured(tmp_path, unit, factor):
    path = v.write_nrrd(
        tmp_path / "leg.nrrd",
        **{
            "space units": [unit] * 3,
            "space directions": factor * v.oblique_axes_mm().T,
            "space origin": factor * v.ORIGIN_MM,
        },
    )
    assert_same_places(found(path), expected())


@pytest.mark.parametrize("encoding", ["gzip", "raw", "bzip2", "ascii"])
def test_nrrd_encodings_hold_the_same_voxels(tmp_path, encoding):
    path = v.write_nrrd(tmp_path / "leg.nrrd", encoding=encoding)
    assert_same_places(found(path), expected())


@pytest.mark.parametrize("dtype", ["uint8", "int16", ">i2", "uint32", "float32"])
def test_nrrd_number_types_hold_the_same_labels(tmp_path, dtype):
    labels = v.asymmetric_labels().astype(dtype)
    assert_same_places(found(v.write_nrrd(tmp_path / "leg.nrrd", labels)), expected())


def test_nrrd_with_a_detached_data_file_is_read(tmp_path):
    path = v.write_nrrd(tmp_path / "leg.nhdr")
    assert (tmp_path / "leg.raw.gz").is_file()
    assert_same_places(found(path), expected())
    (tmp_path / "leg.raw.gz").unlink()
    with pytest.raises(InputFileError, match=r"leg\.raw\.gz: no such file"):
        load_labels(ImagingParameters(source=path))


def nifti_affine() -> np.ndarray:
    flip = np.diag([-1.0, -1.0, 1.0])
    affine = np.eye(4)
    affine[:3, :3] = flip @ v.oblique_axes_mm()
    affine[:3, 3] = flip @ v.ORIGIN_MM
    return affine


@pytest.mark.parametrize("name", ["leg.nii", "leg.nii.gz"])
@pytest.mark.parametrize("form", ["sform", "qform", "both"])
def test_nifti_forms_mean_the_same_places(tmp_path, name, form):
    image = nibabel.Nifti1Image(v.asymmetric_labels(), nifti_affine())
    image.set_sform(nifti_affine(), code=0 if form == "qform" else 1)
    image.set_qform(nifti_affine(), code=0 if form == "sform" else 1)
    image.header.set_xyzt_units("mm")
    nibabel.save(image, tmp_path / name)
    assert_same_places(found(tmp_path / name), expected())


def test_nifti_in_metres_is_converted(tmp_path):
    affine = nifti_affine()
    affine[:3] *= 1e-3
    image = nibabel.Nifti1Image(v.asymmetric_labels(), affine)
    image.header.set_xyzt_units("meter")
    nibabel.save(image, tmp_path / "leg.nii.gz")
    assert_same_places(found(tmp_path / "leg.nii.gz"), expected())


def test_a_flipped_volume_is_told_from_the_right_one(tmp_path):
    """The comparison of places can fail: a left-right flip moves the labels."""
    path = v.write_nrrd(tmp_path / "leg.nrrd", v.asymmetric_labels()[::-1])
    with pytest.raises(AssertionError):
        assert_same_places(found(path), expected())


def test_volumes_come_in_the_order_nearest_to_lps(tmp_path):
    path = v.write_nrrd(
        tmp_path / "leg.nrrd",
        v.asymmetric_labels()[::-1].transpose(2, 0, 1),
        **{"space directions": (v.oblique_axes_mm() * [-1, 1, 1]).T[[2, 0, 1]]},
    )
    with pytest.warns(UserWarning, match="artery_centrelines"):
        volume = load_labels(ImagingParameters(source=path))
    assert np.argmax(np.abs(volume.direction), axis=0).tolist() == [0, 1, 2]
    assert (np.diag(volume.direction) > 0).all()
    assert volume.labels.flags.c_contiguous
    np.testing.assert_allclose(volume.spacing, 1e-3 * np.array(v.SPACING_MM), rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(volume.direction, axis=0), 1.0, rtol=1e-12)
