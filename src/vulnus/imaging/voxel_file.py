"""Voxels as a file holds them, after its frame has been turned into LPS metres and checked."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, LabelArray
from vulnus.core.errors import InputFileError
from vulnus.core.units import MILLIMETRE

SPACING_LIMITS = (0.02 * MILLIMETRE, 20.0 * MILLIMETRE)
"""Voxel edges taken for sane [m]; chosen: from micro-CT to a coarse localiser."""

EXTENT_LIMIT = 3.0
"""Largest edge of a volume [m]; chosen: longer than a body."""

VOXEL_LIMIT = 4_000_000_000
"""Most voxels in a file; chosen: 4 GB as bytes, more than one limb ever needs."""

LABEL_LIMIT = 65535
"""Largest label value taken for a label."""

_SHEAR_LIMIT = 0.01
_AXIS_NAMES = "ijk"


@dataclass(frozen=True, slots=True)
class Segment:
    """One named segment of a segmentation: `tags` is Slicer's terminology text."""

    name: str
    value: int
    layer: int
    tags: str


@dataclass(frozen=True, slots=True, eq=False)
class VoxelFile:
    """Integer values on a grid.

    `layers` (n, nx, ny, nz), n = 1 where segments do not overlap; `axes` (3, 3) whose columns
    lead from a voxel to the next along i, j, k [m, LPS]; `origin` (3,) centre of voxel (0, 0, 0)
    [m, LPS]; `segments` empty where the file names none.
    """

    path: Path
    layers: AnyArray
    axes: FloatArray
    origin: FloatArray
    segments: tuple[Segment, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """A grid in LPS metres: `origin` (3,), `spacing` (3,), `direction` (3, 3) unit columns."""

    origin: FloatArray
    spacing: FloatArray
    direction: FloatArray


def require_file(path: Path) -> None:
    """Refuse a path that is no readable file; name the files that it may have meant."""
    if path.is_file():
        return
    if path.is_dir():
        raise InputFileError(
            str(path),
            "is a folder, not a label volume",
            "Name one .nrrd, .seg.nrrd, .nhdr, .nii or .nii.gz file",
        )
    if not path.parent.is_dir():
        raise InputFileError(
            str(path), f"the folder {path.parent} does not exist", "Check the path in the scenario"
        )
    names = sorted(entry.name for entry in path.parent.iterdir() if entry.is_file())
    near = difflib.get_close_matches(path.name, names, n=3, cutoff=0.4)
    advice = f"Did you mean {' or '.join(near)}?" if near else "Check the path in the scenario"
    raise InputFileError(str(path), "no such file", advice)


def check_shape(path: Path, shape: tuple[int, ...]) -> None:
    """Refuse grids without voxels and grids beyond any memory."""
    if any(size < 1 for size in shape):
        raise InputFileError(
            str(path), f"its grid has {_times(shape)} voxels", "Export the volume again"
        )
    count = 1
    for size in shape:
        count *= int(size)
    if count > VOXEL_LIMIT:
        raise InputFileError(
            str(path),
            f"its header promises {_times(shape)} voxels, more than {VOXEL_LIMIT}",
            "Crop the volume to one limb, or export it again",
        )


def as_labels(path: Path, values: AnyArray) -> AnyArray:
    """The values as integers; refuses what cannot be labels (fractions, NaN, negative, huge)."""
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    if values.dtype.kind not in "iuf":
        raise _not_labels(path, f"its values are of type {values.dtype}")
    low, high = values.min(), values.max()
    if not (np.isfinite(low) and np.isfinite(high)):
        raise _not_labels(path, "its values are not all finite numbers")
    if low < 0 or high > LABEL_LIMIT:
        raise _not_labels(path, f"its values run from {low} to {high}, not within 0-{LABEL_LIMIT}")
    labels = values.astype(np.uint8 if high <= 255 else np.uint16)
    if values.dtype.kind == "f" and not np.array_equal(labels, values):
        raise _not_labels(path, "its values are not whole numbers")
    return labels


def _not_labels(path: Path, problem: str) -> InputFileError:
    return InputFileError(
        str(path),
        f"{problem}, so it is not a label volume",
        "Export the segmentation (labels), not the image",
    )


def _times(shape: tuple[int, ...]) -> str:
    return " x ".join(str(int(size)) for size in shape)


def check_axes(path: Path, axes: FloatArray, origin: FloatArray) -> None:
    """Refuse axes that are not finite, of no sane length, or not square to each other."""
    if not (np.isfinite(axes).all() and np.isfinite(origin).all()):
        raise InputFileError(
            str(path),
            "its voxel spacing, directions or origin are not finite numbers",
            "Export the volume again with its geometry",
        )
    spacing = np.linalg.norm(axes, axis=0)
    low, high = (limit / MILLIMETRE for limit in SPACING_LIMITS)
    for name, length in zip(_AXIS_NAMES, spacing, strict=True):
        if not SPACING_LIMITS[0] <= length <= SPACING_LIMITS[1]:
            raise InputFileError(
                str(path),
                f"its voxel spacing along {name} is {length / MILLIMETRE:g} mm, not within"
                f" {low:g}-{high:g} mm",
                "Check the file's units and spacing, and export it again",
            )
    direction = axes / spacing
    skew = np.abs(direction.T @ direction - np.eye(3)).max()
    if skew > _SHEAR_LIMIT:
        raise InputFileError(
            str(path),
            f"its axes are not at right angles (cosine {skew:.3f}, limit {_SHEAR_LIMIT})",
            "Resample the volume onto a rectangular grid",
        )


def nearest_to_lps(labels: LabelArray, file: VoxelFile) -> tuple[LabelArray, Grid]:
    """The labels with axes reordered and flipped so that i, j, k run nearest to +x, +y, +z."""
    spacing = np.linalg.norm(file.axes, axis=0)
    check_extent(file.path, labels.shape, spacing)
    order = _axis_order(file.axes / spacing)
    axes = file.axes[:, order]
    labels = labels.transpose(order)
    origin = file.origin.astype(np.float64)
    for axis in range(3):
        if axes[axis, axis] < 0:
            origin = origin + axes[:, axis] * (labels.shape[axis] - 1)
            axes = axes.copy()
            axes[:, axis] *= -1.0
            labels = np.flip(labels, axis)
    spacing = np.linalg.norm(axes, axis=0)
    return np.ascontiguousarray(labels), Grid(origin, spacing, axes / spacing)


def check_extent(path: Path, shape: tuple[int, ...], spacing: FloatArray) -> None:
    """Refuse a volume that is larger than a body: its units are most likely wrong."""
    extent = float(np.max(np.asarray(shape) * spacing))
    if extent > EXTENT_LIMIT:
        raise InputFileError(
            str(path),
            f"is {extent:.3g} m long, more than {EXTENT_LIMIT:g} m",
            "Check the file's units and spacing, and export it again",
        )


def _axis_order(direction: FloatArray) -> list[int]:
    """Which array axis runs nearest to x, y and z: the permutation of the largest product."""
    orders = ([0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0])
    size = np.abs(direction)
    return max(
        orders, key=lambda order: float(size[0, order[0]] * size[1, order[1]] * size[2, order[2]])
    )
