"""A label file as it is, for experiments: codes without a meaning, no arteries, any object."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vulnus.core.errors import InputFileError
from vulnus.core.handoff import LabelVolume

from .label_files import read_voxels
from .voxel_file import nearest_to_lps

LARGEST_CODE = 255
"""Labels are kept as bytes."""


def read_labels(path: str | Path) -> LabelVolume:
    """The labels of a NRRD or NIfTI file on their grid [m, LPS], with the file's own codes 0-255.

    Raises `InputFileError` for a file that cannot be read, has several layers of labels that
    overlap, or codes that are no whole numbers from 0 to 255.
    """
    file = read_voxels(Path(path))
    if len(file.layers) != 1:
        raise InputFileError(
            str(path),
            f"holds {len(file.layers)} layers that overlap",
            "Export them as one label map",
        )
    codes = np.asarray(file.layers[0])
    if codes.min(initial=0) < 0 or codes.max(initial=0) > LARGEST_CODE:
        raise InputFileError(
            str(path),
            f"has labels from {codes.min()} to {codes.max()}, must be 0 to {LARGEST_CODE}",
            "Renumber the labels",
        )
    labels, grid = nearest_to_lps(codes.astype(np.uint8), file)
    return LabelVolume(
        labels=labels,
        origin=grid.origin,
        spacing=grid.spacing,
        direction=grid.direction,
        arteries=(),
        source=Path(path).name,
    )
