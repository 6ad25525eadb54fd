"""Files that cannot be used are refused with file, value, limit and advice; never a traceback."""

from __future__ import annotations

from pathlib import Path

import nibabel
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vulnus.core.errors import InputFileError
from vulnus.imaging import ImagingParameters, LegMeasurements, load_labels

from . import volumes as v

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


def refuse(path: Path, *parts: str, **parameters) -> None:
    with pytest.raises(InputFileError) as caught:
        load_labels(ImagingParameters(source=path, **parameters))
    text = str(caught.value)
    for part in parts:
        assert part in text
    assert caught.value.exit_code != 0


def test_a_missing_file_names_its_neighbours(tmp_path):
    v.write_nrrd(tmp_path / "left_leg.nrrd")
    refuse(tmp_path / "left_lg.nrrd", "left_lg.nrrd", "no such file", "left_leg.nrrd")
    refuse(tmp_path / "nowhere" / "leg.nrrd", "does not exist")
    refuse(tmp_path, "is a folder")


def test_an_unknown_extension_is_refused(tmp_path):
    (tmp_path / "leg.stl").write_bytes(b"solid")
    refuse(tmp_path / "leg.stl", ".stl", ".seg.nrrd")


@pytest.mark.parametrize("name", ["leg.nrrd", "leg.nii", "leg.nii.gz"])
@pytest.mark.parametrize("content", [b"", b"no volume at all", b"NRRD0005\n", b"\x1f\x8b\x08\x00"])
def test_a_file_of_another_kind_is_refused(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    refuse(tmp_path / name, name)


@pytest.mark.parametrize("encoding", ["raw", "gzip", "bzip2", "ascii"])
@settings(
    max_examples=25,
    deadline=2000,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(part=st.floats(0.0, 1.0, exclude_max=True))
def test_a_truncated_nrrd_is_always_refused(tmp_path, encoding, part):
    path = v.write_nrrd(tmp_path / "whole.nrrd", encoding=encoding)
    data = path.read_bytes().rstrip(b"\n")
    cut = tmp_path / "cut.nrrd"
    cut.write_bytes(data[: int(part * (len(data) - 1))])
    refuse(cut, "cut.nrrd")


@settings(
    max_examples=60,
    deadline=2000,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(place=st.integers(0, 2**20), byte=st.integers(0, 255))
def test_a_damaged_nrrd_is_read_or_refused(tmp_path, place, byte):
    path = v.write_nrrd(tmp_path / "whole.nrrd")
    data = bytearray(path.read_bytes())
    data[place % len(data)] = byte
    damaged = tmp_path / "damaged.nrrd"
    damaged.write_bytes(bytes(data))
    try:
        volume = load_labels(ImagingParameters(source=damaged))
    except InputFileError:
        return
    assert volume.labels.max() <= 7


@pytest.mark.parametrize("name", ["leg.nii", "leg.nii.gz"])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.9, 0.99])
def test_a_truncated_nifti_is_refused(tmp_path, name, part):
    labels = np.random.default_rng(1).integers(0, 5, size=(40, 30, 20), dtype=np.uint8)
    nibabel.save(nibabel.Nifti1Image(labels, np.eye(4)), tmp_path / name)
    data = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(data[: int(part * len(data))])
    refuse(tmp_path / name, name)


def test_an_image_is_not_a_label_volume(tmp_path):
    labels = v.asymmetric_labels()
    refuse(v.write_nrrd(tmp_path / "a.nrrd", labels + np.float32(0.5)), "not whole numbers")
    refuse(v.write_nrrd(tmp_path / "b.nrrd", labels.astype(np.int16) - 1000), "-1000")
    holed = labels.astype(np.float32)
    holed[0, 0, 0] = np.nan
    refuse(v.write_nrrd(tmp_path / "c.nrrd", holed), "finite")


def test_axes_beyond_three_need_a_list_of_layers(tmp_path):
    labels = np.stack([v.asymmetric_labels()] * 2, axis=-1)
    directions = np.vstack([v.oblique_axes_mm().T, np.full(3, np.nan)])
    kinds = ["domain"] * 3 + ["time"]
    path = v.write_nrrd(
        tmp_path / "t.nrrd", labels, kinds=kinds, **{"space directions": directions}
    )
    refuse(path, "4 axes")
    flat = v.asymmetric_labels()[0]
    path = v.write_nrrd(
        tmp_path / "flat.nrrd",
        flat,
        kinds=["domain"] * 2,
        **{"space directions": np.eye(3)[:2]},
    )
    refuse(path, "2 axes")
    volume = v.write_nrrd(tmp_path / "sizes.nrrd").read_bytes()
    path.write_bytes(volume.replace(b"dimension: 3", b"dimension: 2"))
    refuse(path, "3 sizes for dimension 2")
    nibabel.save(nibabel.Nifti1Image(labels, np.eye(4)), tmp_path / "t.nii")
    refuse(tmp_path / "t.nii", "4 axes")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"space": "scanner-xyz"}, "left from right"),
        ({"space": "3D-right-handed"}, "left from right"),
        ({"space": None, "space directions": None, "space origin": None}, "no space directions"),
        ({"space directions": np.full((3, 3), np.nan)}, "not finite"),
        ({"space directions": np.zeros((3, 3))}, "0 mm"),
        ({"space directions": np.ones((3, 3))}, "right angles"),
        ({"space directions": 1e-6 * np.eye(3)}, "1e-06 mm"),
        ({"space directions": 500.0 * np.eye(3)}, "500 mm"),
        ({"space origin": np.array([np.nan, 0.0, 0.0])}, "not finite"),
        ({"space units": ["parsec"] * 3}, "parsec"),
    ],
)
def test_a_geometry_that_cannot_be_is_refused(tmp_path, changes, words):
    refuse(v.write_nrrd(tmp_path / "leg.nrrd", **changes), "leg.nrrd", words)


def test_a_nifti_without_orientation_is_refused(tmp_path):
    image = nibabel.Nifti1Image(v.asymmetric_labels(), None)
    image.set_sform(None, code=0)
    image.set_qform(None, code=0)
    nibabel.save(image, tmp_path / "leg.nii")
    refuse(tmp_path / "leg.nii", "neither sform nor qform")


def test_a_header_that_promises_too_much_is_refused_at_once(tmp_path):
    path = v.write_nrrd(tmp_path / "leg.nrrd")
    data = path.read_bytes().replace(b"sizes: 11 9 7", b"sizes: 110000 90000 70000")
    path.write_bytes(data)
    refuse(path, "110000 x 90000 x 70000")
    path.write_bytes(data.replace(b"sizes: 110000 90000 70000", b"sizes: 0 9 7"))
    refuse(path, "0 x 9 x 7")


def test_air_alone_and_a_limb_without_bone_are_refused(tmp_path):
    labels = v.asymmetric_labels()
    refuse(v.write_nrrd(tmp_path / "air.nrrd", 0 * labels), "nothing but air")
    labels[labels == 3] = 2
    refuse(v.write_nrrd(tmp_path / "soft.nrrd", labels), "no bone", "soft.nrrd")


def test_unknown_labels_are_listed(tmp_path):
    labels = v.asymmetric_labels()
    labels[5, 5, 5], labels[6, 2, 1] = 9, 23
    refuse(v.write_nrrd(tmp_path / "leg.nrrd", labels), "9, 23", "[imaging.labels]")


def test_a_label_map_needs_names_of_tissues(tmp_path):
    path = v.write_nrrd(tmp_path / "leg.nrrd")
    refuse(path, "imaging.labels.gold", label_map={"gold": 3})


def test_side_and_voxel_are_checked():
    with pytest.raises(InputFileError, match=r"imaging\.side"):
        load_labels(ImagingParameters(side="middle"))
    with pytest.raises(InputFileError, match=r"imaging\.voxel_mm.*0\.2 to 6 mm"):
        load_labels(ImagingParameters(voxel=0.0))
    with pytest.raises(InputFileError, match=r"imaging\.leg\.calf_girth"):
        load_labels(ImagingParameters(leg=LegMeasurements(calf_girth=-0.3)))
