"""Labels from NRRD files (.nrrd, .nhdr with its data file, .seg.nrrd of 3D Slicer)."""

from __future__ import annotations

import bz2
import re
import warnings
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.errors import InputFileError
from vulnus.core.units import MILLIMETRE

from .voxel_file import Segment, VoxelFile, as_labels, check_axes, check_shape, require_file

_SPACES = {
    "left-posterior-superior": (1.0, 1.0, 1.0),
    "lps": (1.0, 1.0, 1.0),
    "right-anterior-superior": (-1.0, -1.0, 1.0),
    "ras": (-1.0, -1.0, 1.0),
    "left-anterior-superior": (1.0, -1.0, 1.0),
    "las": (1.0, -1.0, 1.0),
}
"""Signs that turn a NRRD space into LPS."""

_UNITS = {"mm": MILLIMETRE, "millimeter": MILLIMETRE, "cm": 1e-2, "m": 1.0, "um": 1e-6, "µm": 1e-6}
_TYPES = {
    spelling: kind
    for kind, spellings in {
        "i1": ("signed char", "int8", "int8_t"),
        "u1": ("uchar", "unsigned char", "uint8", "uint8_t"),
        "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
        "u2": ("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"),
        "i4": ("int", "signed int", "int32", "int32_t"),
        "u4": ("uint", "unsigned int", "uint32", "uint32_t"),
        "i8": ("longlong", "long long", "long long int", "signed long long", "int64", "int64_t"),
        "u8": ("ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"),
        "f4": ("float",),
        "f8": ("double",),
    }.items()
    for spelling in spellings
}
"""NumPy's kinds by the NRRD format's names (teem.sourceforge.net/nrrd/format.html)."""

_EXPORT = "Export the volume again"
_SIDES = "Save the volume in LPS or RAS: vulnus never guesses left and right"
_CHUNK = 1 << 20


def read_nrrd(path: Path) -> VoxelFile:
    """The label layers, geometry and segments of a NRRD file.

    Errors: InputFileError for whatever is missing, cut off or contradicts itself.
    """
    import nrrd

    try:
        with path.open("rb") as file:
            header = nrrd.read_header(file)
            shape = _shape(path, header)
            values = _read_values(path, header, shape, file)
    except InputFileError:
        raise
    except MemoryError as error:
        raise InputFileError(str(path), "does not fit into memory", "Crop the volume") from error
    except Exception as error:  # a foreign parser on foreign bytes
        problem = f"is not a readable NRRD file ({str(error) or type(error).__name__})"
        raise InputFileError(str(path), problem, _EXPORT) from error
    return _assemble(path, header, values)


def _shape(path: Path, header: Mapping[str, Any]) -> tuple[int, ...]:
    sizes = header.get("sizes")
    if sizes is None or "type" not in header or "encoding" not in header:
        raise InputFileError(str(path), "its header lacks sizes, type or encoding", _EXPORT)
    shape = tuple(int(size) for size in sizes)
    dimension = int(header.get("dimension", len(shape)))
    if dimension != len(shape):
        problem = f"its header gives {len(shape)} sizes for dimension {dimension}"
        raise InputFileError(str(path), problem, _EXPORT)
    if len(shape) not in (3, 4):
        raise InputFileError(
            str(path),
            f"has {len(shape)} axes where 3 are needed (4 with one of kind 'list')",
            "Export one label volume",
        )
    check_shape(path, shape)
    return shape


def _read_values(
    path: Path, header: Mapping[str, Any], shape: tuple[int, ...], file: BinaryIO
) -> AnyArray:
    """The array in the file's own axis order, fastest axis first."""
    dtype = _dtype(path, header)
    size = int(np.prod(shape, dtype=np.int64)) * dtype.itemsize
    detached = header.get("data file", header.get("datafile"))
    if detached is None:
        data, owner = _decode(path, header, file, size), path
    else:
        owner = path.parent / _data_file_name(path, detached)
        require_file(owner)
        with owner.open("rb") as data_file:
            data = _decode(owner, header, data_file, size)
    if len(data) < size:
        raise InputFileError(
            str(owner),
            f"is cut off: it holds {len(data)} of {size} bytes of voxels",
            "Copy or export the file again",
        )
    return np.frombuffer(data, dtype=dtype, count=size // dtype.itemsize).reshape(shape, order="F")


def _dtype(path: Path, header: Mapping[str, Any]) -> np.dtype[Any]:
    kind = _TYPES.get(str(header["type"]).strip().lower())
    if kind is None:
        raise InputFileError(str(path), f"has voxels of type {header['type']!r}", _EXPORT)
    dtype: np.dtype[Any] = np.dtype(kind)
    if dtype.itemsize > 1 and header.get("encoding") not in ("ascii", "text", "txt"):
        endian = header.get("endian")
        if endian not in ("little", "big"):
            raise InputFileError(str(path), "its header names no byte order (endian)", _EXPORT)
        dtype = dtype.newbyteorder("<" if endian == "little" else ">")
    return dtype


def _data_file_name(path: Path, detached: object) -> str:
    name = str(detached)
    if isinstance(detached, list) or "%" in name or name.upper().startswith("LIST"):
        raise InputFileError(
            str(path), "its voxels are spread over several data files", "Save it as one .nrrd file"
        )
    return name


def _decode(path: Path, header: Mapping[str, Any], file: BinaryIO, size: int) -> bytes:
    encoding = str(header["encoding"]).lower()
    for _ in range(int(header.get("line skip", header.get("lineskip", 0)))):
        file.readline()
    skip = int(header.get("byte skip", header.get("byteskip", 0)))
    if encoding == "raw":
        if skip == -1:
            file.seek(-size, 2)
        else:
            file.seek(skip, 1)
        return file.read(size)
    if encoding in ("gzip", "gz"):
        return _inflate(path, file, size, skip)
    if encoding in ("bzip2", "bz2"):
        return bz2.decompress(file.read())[max(skip, 0) :][:size]
    if encoding in ("ascii", "text", "txt"):
        return np.array(file.read().split(), dtype=_dtype(path, header)).tobytes()
    raise InputFileError(str(path), f"has the encoding {encoding!r}", "Save it as gzip or raw")


def _inflate(path: Path, file: BinaryIO, size: int, skip: int) -> bytes:
    """Decompress gzip data to at most `size` bytes; refuses a stream without its end."""
    stream = zlib.decompressobj(wbits=31)
    want = size + max(skip, 0)
    parts: list[bytes] = []
    held = 0
    while not stream.eof:
        chunk = stream.unconsumed_tail or file.read(_CHUNK)
        if not chunk:
            raise InputFileError(
                str(path),
                f"is cut off: its compressed voxels end after {held} of {want} bytes",
                "Copy or export the file again",
            )
        part = stream.decompress(chunk, max(want - held, 1))
        held += len(part)
        if held > want:
            raise InputFileError(
                str(path), f"holds more than the {want} bytes its header promises", _EXPORT
            )
        parts.append(part)
    return b"".join(parts)[max(skip, 0) :]


def _assemble(path: Path, header: Mapping[str, Any], values: AnyArray) -> VoxelFile:
    rows = _direction_rows(path, header, values.ndim)
    spatial = [axis for axis, row in enumerate(rows) if row is not None]
    if values.ndim == 4:
        kinds = [str(kind).lower() for kind in header.get("kinds", [])]
        other = next((axis for axis in range(4) if axis not in spatial), None)
        if len(spatial) != 3 or other is None or (kinds and kinds[other] != "list"):
            raise InputFileError(
                str(path),
                "has 4 axes, and none is a list of segment layers",
                "Export one label volume (no time series, no vectors)",
            )
        layers = np.moveaxis(values, other, 0)
    else:
        layers = values[None]
    if len(spatial) != 3:
        raise InputFileError(str(path), "lacks the direction of an axis in space", _EXPORT)
    sign, unit = _space(path, header), _unit(path, header)
    axes = np.array([rows[axis] for axis in spatial], dtype=np.float64).T
    axes = unit * sign[:, None] * axes
    origin = unit * sign * _origin(path, header)
    check_axes(path, axes, origin)
    return VoxelFile(path, as_labels(path, layers), axes, origin, _segments(path, header))


def _direction_rows(path: Path, header: Mapping[str, Any], ndim: int) -> list[FloatArray | None]:
    """One direction vector per axis, None for an axis that is not in space."""
    if "space directions" in header:
        given = header["space directions"]
        rows: list[FloatArray | None] = []
        for row in given:
            vector = None if row is None else np.asarray(row, dtype=np.float64)
            absent = vector is None or bool(np.isnan(vector).all())
            if vector is not None and not absent and vector.shape != (3,):
                raise InputFileError(str(path), "its space has not three dimensions", _EXPORT)
            rows.append(None if absent else vector)
        if len(rows) != ndim:
            raise InputFileError(str(path), "has not one direction for each axis", _EXPORT)
        if ndim == 3 and any(row is None for row in rows):
            raise InputFileError(str(path), "its directions are not finite numbers", _EXPORT)
        return rows
    spacings = header.get("spacings")
    if spacings is None or len(spacings) != ndim or ndim != 3:
        raise InputFileError(str(path), "its header has no space directions", _SIDES)
    return [np.eye(3)[axis] * float(step) for axis, step in enumerate(spacings)]


def _space(path: Path, header: Mapping[str, Any]) -> FloatArray:
    space = header.get("space")
    if space is None:
        warnings.warn(
            f"{path}: its header names no space; its axes are taken for LPS", stacklevel=2
        )
        return np.ones(3)
    name = str(space).strip().strip('"').lower()
    if name not in _SPACES:
        raise InputFileError(
            str(path), f"is given in space {space!r}, which does not tell left from right", _SIDES
        )
    return np.array(_SPACES[name])


def _unit(path: Path, header: Mapping[str, Any]) -> float:
    units = header.get("space units")
    if units is None:
        return MILLIMETRE
    if isinstance(units, str):
        units = units.split()
    names = {str(unit).strip('"').strip().lower() for unit in units} or {"mm"}
    if len(names) != 1 or not names <= _UNITS.keys():
        raise InputFileError(
            str(path), f"has the space units {', '.join(sorted(names))}", "Save it in millimetres"
        )
    return _UNITS[names.pop()]


def _origin(path: Path, header: Mapping[str, Any]) -> FloatArray:
    origin = header.get("space origin")
    if origin is None:
        warnings.warn(f"{path}: its header has no space origin; (0, 0, 0) taken", stacklevel=2)
        return np.zeros(3)
    vector = np.asarray(origin, dtype=np.float64)
    if vector.shape != (3,):
        raise InputFileError(str(path), "its space origin has not three numbers", _EXPORT)
    return vector


def _segments(path: Path, header: Mapping[str, Any]) -> tuple[Segment, ...]:
    numbers = sorted(
        int(match.group(1))
        for match in (re.fullmatch(r"Segment(\d+)_ID", str(key)) for key in header)
        if match
    )
    segments = []
    for number in numbers:
        try:
            value = int(header.get(f"Segment{number}_LabelValue", number + 1))
            layer = int(header.get(f"Segment{number}_Layer", 0))
        except ValueError as error:
            raise InputFileError(
                str(path), f"Segment{number} has no whole LabelValue and Layer", _EXPORT
            ) from error
        name = str(header.get(f"Segment{number}_Name", f"Segment {number}"))
        segments.append(Segment(name, value, layer, str(header.get(f"Segment{number}_Tags", ""))))
    return tuple(segments)
