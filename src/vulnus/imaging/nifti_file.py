"""Labels from NIfTI files (.nii, .nii.gz); their RAS millimetres become LPS metres here."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.errors import InputFileError
from vulnus.core.units import MILLIMETRE

from .voxel_file import VoxelFile, as_labels, check_axes, check_shape

_RAS_TO_LPS = np.array([-1.0, -1.0, 1.0])
_UNITS = {"mm": MILLIMETRE, "meter": 1.0, "micron": 1e-6, "unknown": MILLIMETRE}
_AGREEMENT = 0.1
"""Part of a voxel by which sform and qform may differ."""


def read_nifti(path: Path) -> VoxelFile:
    """The labels and geometry of a NIfTI file; sform before qform, as nibabel and ITK do.

    Errors: InputFileError for whatever is missing, cut off or contradicts itself.
    """
    import nibabel

    try:
        image: Any = nibabel.load(path)
        shape = tuple(int(size) for size in image.shape)
        values = _read_values(path, image, shape)
        axes, origin = _geometry(path, image.header)
    except InputFileError:
        raise
    except MemoryError as error:
        raise InputFileError(str(path), "does not fit into memory", "Crop the volume") from error
    except Exception as error:  # a foreign parser on foreign bytes
        problem = f"is not a readable NIfTI file ({str(error) or type(error).__name__})"
        raise InputFileError(str(path), problem, "Copy or export the file again") from error
    check_axes(path, axes, origin)
    return VoxelFile(path, as_labels(path, values)[None], axes, origin)


def _read_values(path: Path, image: Any, shape: tuple[int, ...]) -> AnyArray:
    check_shape(path, shape)
    while len(shape) > 3 and shape[-1] == 1:
        shape = shape[:-1]
    if len(shape) != 3:
        raise InputFileError(
            str(path), f"has {len(shape)} axes where 3 are needed", "Export one label volume"
        )
    values: AnyArray = np.asanyarray(image.dataobj).reshape(shape)
    return values


def _geometry(path: Path, header: Any) -> tuple[FloatArray, FloatArray]:
    """Voxel axes (3, 3) and origin (3,) in LPS metres."""
    sform = header.get_sform(coded=True)[0]
    qform = header.get_qform(coded=True)[0]
    if sform is None and qform is None:
        raise InputFileError(
            str(path),
            "has neither sform nor qform, so it does not tell left from right",
            "Save the volume with its orientation",
        )
    affine = np.asarray(sform if sform is not None else qform, dtype=np.float64)
    if sform is not None and qform is not None:
        spacing = float(np.max(np.linalg.norm(affine[:3, :3], axis=0)))
        if np.abs(np.asarray(qform) - affine).max() > _AGREEMENT * spacing:
            warnings.warn(f"{path}: sform and qform differ; the sform is taken", stacklevel=2)
    name = header.get_xyzt_units()[0]
    if name not in _UNITS:
        raise InputFileError(str(path), f"has the length unit {name!r}", "Save it in millimetres")
    scale = _UNITS[name] * _RAS_TO_LPS
    return scale[:, None] * affine[:3, :3], scale * affine[:3, 3]
