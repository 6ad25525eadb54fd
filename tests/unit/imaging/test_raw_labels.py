"""Label files read as they are, for experiments."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import InputFileError
from vulnus.imaging import read_labels


def nrrd(path, labels, kind):
    header = (
        f"NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {' '.join(map(str, labels.shape))}\n"
        "space: left-posterior-superior\nspace directions: (2,0,0) (0,-1,0) (0,0,1.5)\n"
        "space origin: (10,20,30)\nendian: little\nencoding: raw\n\n"
    )
    path.write_bytes(header.encode() + labels.tobytes(order="F"))
    return path


def test_codes_and_frame_are_those_of_the_file(tmp_path):
    labels = np.random.default_rng(1).integers(0, 256, (4, 5, 6)).astype(np.uint8)
    volume = read_labels(nrrd(tmp_path / "any.nrrd", labels, "uint8"))
    # The second axis runs backwards, and is turned: origin 20 mm - 4 voxels of 1 mm.
    assert np.array_equal(volume.labels, labels[:, ::-1])
    assert volume.spacing == pytest.approx([2e-3, 1e-3, 1.5e-3])
    assert volume.origin == pytest.approx([10e-3, 16e-3, 30e-3])
    assert volume.direction == pytest.approx(np.eye(3))


def test_codes_beyond_a_byte_are_refused(tmp_path):
    labels = np.full((3, 3, 3), 300, np.int16)
    with pytest.raises(InputFileError, match="must be 0 to 255"):
        read_labels(nrrd(tmp_path / "large.nrrd", labels, "int16"))


def test_another_kind_of_file_is_refused(tmp_path):
    (tmp_path / "labels.png").write_bytes(b"")
    with pytest.raises(InputFileError, match="no label volume's"):
        read_labels(tmp_path / "labels.png")
