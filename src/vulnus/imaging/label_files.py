"""A label file and its centre-lines as a `LabelVolume`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vulnus.core.arrays import LabelArray
from vulnus.core.errors import InputFileError
from vulnus.core.handoff import ArteryCentreline, LabelVolume, Tissue

from .centrelines import read_centrelines
from .label_names import FIVE_LABELS, PRIORITY, tissue_of_name, tissue_of_tags
from .nifti_file import read_nifti
from .nrrd_file import read_nrrd
from .parameters import ImagingParameters
from .voxel_file import Grid, Segment, VoxelFile, nearest_to_lps, require_file

_BONES = (Tissue.BONE, Tissue.CANCELLOUS, Tissue.MARROW)
_KNOWN_NAMES = "skin, muscle (soft tissue), fat, bone, cancellous, marrow, artery"
_BESIDE = "artery_centrelines*.json"


def read_label_file(parameters: ImagingParameters) -> LabelVolume:
    """The limb in a NRRD or NIfTI label file, with arteries from JSON.

    Where no centre-line file is named and the volume shows arteries, the one file
    `artery_centrelines*.json` in the volume's folder is taken.
    """
    path = Path(parameters.source)
    file = read_voxels(path)
    labels, grid = nearest_to_lps(_to_tissues(file, parameters.label_map), file)
    _check_tissues(path, labels)
    return LabelVolume(
        labels=labels,
        origin=grid.origin,
        spacing=grid.spacing,
        direction=grid.direction,
        arteries=_arteries(path, parameters.centrelines, labels, grid),
        source=path.name,
        side=parameters.side,
    )


def read_voxels(path: Path) -> VoxelFile:
    """The voxels of a NRRD or NIfTI file, by its extension; refuses any other."""
    require_file(path)
    name = path.name.lower()
    if name.endswith((".nrrd", ".nhdr")):
        return read_nrrd(path)
    if name.endswith((".nii", ".nii.gz")):
        return read_nifti(path)
    raise InputFileError(
        str(path),
        f"has the extension {path.suffix or '(none)'}, which is no label volume's",
        "Give a .nrrd, .seg.nrrd, .nhdr, .nii or .nii.gz file, or 'builtin_leg'",
    )


def _to_tissues(file: VoxelFile, label_map: Mapping[str, int] | None) -> LabelArray:
    """Tissue codes (nx, ny, nz): each layer translated, layers merged by priority."""
    rank = np.zeros(256, dtype=np.uint8)
    rank[list(PRIORITY)] = np.arange(1, len(PRIORITY) + 1)
    merged: LabelArray | None = None
    for number, layer in enumerate(file.layers):
        codes = _translate(file, number, layer, label_map)
        merged = codes if merged is None else np.where(rank[codes] > rank[merged], codes, merged)
    if merged is None:
        raise InputFileError(str(file.path), "holds no layer of labels", "Export it again")
    return merged


def _translate(
    file: VoxelFile, number: int, layer: np.ndarray, label_map: Mapping[str, int] | None
) -> LabelArray:
    present = np.flatnonzero(np.bincount(layer.ravel(order="K")))
    table = np.zeros(int(present.max(initial=0)) + 1, dtype=np.uint8)
    segments = {segment.value: segment for segment in file.segments if segment.layer == number}
    mapped = _mapped_values(label_map)
    unknown = []
    for value in present.tolist():
        tissue = Tissue.AIR if value == 0 and value not in mapped else mapped.get(value)
        if tissue is None and file.segments:
            tissue = _tissue_of_segment(segments.get(value))
        elif tissue is None and label_map is None:
            tissue = FIVE_LABELS.get(value)
        if tissue is None:
            name = f" ({segments[value].name!r})" if value in segments else ""
            unknown.append(f"{value}{name}")
        else:
            table[value] = tissue
    if unknown:
        raise InputFileError(
            str(file.path),
            f"holds labels of unknown tissue: {', '.join(unknown)}",
            f"Name them under [imaging.labels], e.g. bone = 3; tissues are {_KNOWN_NAMES}",
        )
    codes: LabelArray = table[layer]
    return codes


def _mapped_values(label_map: Mapping[str, int] | None) -> dict[int, Tissue]:
    values: dict[int, Tissue] = {}
    for name, value in (label_map or {}).items():
        tissue = tissue_of_name(name)
        if tissue is None:
            raise InputFileError(
                f"imaging.labels.{name}",
                "is the name of no tissue",
                f"Use one of {_KNOWN_NAMES}, or a structure such as tibia or soleus",
            )
        values[int(value)] = tissue
    return values


def _tissue_of_segment(segment: Segment | None) -> Tissue | None:
    if segment is None:
        return None
    coded = tissue_of_tags(segment.tags)
    return coded if coded is not None else tissue_of_name(segment.name)


def _check_tissues(path: Path, labels: LabelArray) -> None:
    counts = np.bincount(labels.ravel(order="K"), minlength=len(Tissue))
    if not counts[1:].any():
        raise InputFileError(
            str(path), "holds nothing but air (label 0)", "Export the segmentation with its labels"
        )
    if not counts[list(_BONES)].any():
        raise InputFileError(
            str(path),
            "holds no bone, which the injury needs",
            "Segment the bones, or map their label under [imaging.labels]",
        )


def _arteries(
    path: Path, named: Path | None, labels: LabelArray, grid: Grid
) -> tuple[ArteryCentreline, ...]:
    if named is not None:
        return read_centrelines(named, labels, grid)
    if not (labels == Tissue.ARTERY).any():
        return ()
    beside = sorted(path.parent.glob(_BESIDE))
    if len(beside) > 1:
        raise InputFileError(
            str(path),
            f"has several centre-line files beside it: {', '.join(f.name for f in beside)}",
            "Name one as imaging.centrelines",
        )
    if beside:
        return read_centrelines(beside[0], labels, grid)
    warnings.warn(
        f"{path}: shows arteries, but no {_BESIDE} lies beside it and imaging.centrelines names"
        " none; no artery can be cut",
        stacklevel=2,
    )
    return ()
