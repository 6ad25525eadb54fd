"""Hand-off types as HDF5 files with a checksum, so that a damaged file is noticed, never used.

The tree of dataclasses, tuples, mappings, enums, arrays and numbers becomes a tree of groups; each
node says its kind, so that the file can be read without knowing what was written. The first 512
bytes (the HDF5 user block) hold the SHA-256 of the rest.
"""

from __future__ import annotations

import dataclasses
import enum
import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from vulnus.core import handoff

from .whole_file import write_whole

_BLOCK = 512
_MAGIC = b"vulnus hand-off 1 sha256 "
_COMPRESSED_FROM = 1 << 16
"""Bytes from which labels are compressed; chosen: there is nothing to gain below."""


class DamagedFileError(Exception):
    """The file is truncated, was altered, or holds something else than was asked for."""


class OtherVersionError(DamagedFileError):
    """The file is whole, but holds types of another version of vulnus."""


def write_handoff(path: Path, content: object, note: Mapping[str, float | int | str]) -> None:
    """Write `content` and the small mapping `note` to `path`, whole or not at all."""
    import h5py

    with h5py.File(
        path.name, "w", driver="core", backing_store=False, userblock_size=_BLOCK
    ) as file:
        _encode(file.create_group("content"), content, {})
        file["content"].attrs["note"] = np.array(_flat(note), dtype=h5py.string_dtype())
        file.flush()
        image = file.id.get_file_image()  # without the user block
    digest = hashlib.sha256(image).hexdigest().encode()
    write_whole(path, (_MAGIC + digest + b"\n").ljust(_BLOCK, b"\0") + image)


def read_handoff(path: Path) -> tuple[Any, dict[str, str]]:
    """What `write_handoff` wrote: the content, and the note as text; may raise DamagedFileError."""
    return _read(path, lambda group: (_decode(group), _note(group)))


def read_note(path: Path) -> dict[str, str]:
    """The note alone, of a file whose checksum is right."""
    return _read(path, _note)


Result = TypeVar("Result")


def _read(path: Path, interpret: Callable[[Any], Result]) -> Result:
    import io

    import h5py

    data = path.read_bytes()
    header = data[:_BLOCK]
    digest = hashlib.sha256(memoryview(data)[_BLOCK:]).hexdigest().encode()
    if header.rstrip(b"\0") != _MAGIC + digest + b"\n":
        raise DamagedFileError(f"{path} is truncated or was altered")
    try:
        with h5py.File(io.BytesIO(data), "r") as file:
            return interpret(file["content"])
    except (AttributeError, KeyError, TypeError, ValueError, OSError) as trouble:
        # The checksum is right, so nothing is damaged: the types have changed since.
        raise OtherVersionError(f"{path} does not hold what was asked for: {trouble}") from trouble


def _note(group: Any) -> dict[str, str]:
    pairs = [str(text) for text in group.attrs["note"]]
    return dict(zip(pairs[::2], pairs[1::2], strict=True))


def _flat(note: Mapping[str, float | int | str]) -> list[str]:
    return [text for name, value in note.items() for text in (name, str(value))]


def _encode(group: Any, value: object, written: dict[int, Any]) -> None:
    """Write `value`; an array that was `written` before, by identity, is linked to."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        group.attrs["kind"] = "dataclass"
        group.attrs["class"] = type(value).__name__
        for item in dataclasses.fields(value):
            _encode(group.create_group(item.name), getattr(value, item.name), written)
    elif isinstance(value, Mapping):
        group.attrs["kind"] = "mapping"
        for index, (key, item) in enumerate(value.items()):
            child = group.create_group(f"{index:06d}")
            child.attrs["key"] = key
            _encode(child, item, written)
    elif isinstance(value, tuple | list):
        group.attrs["kind"] = "tuple"
        for index, item in enumerate(value):
            _encode(group.create_group(f"{index:06d}"), item, written)
    else:
        _encode_leaf(group, value, written)


def _encode_array(group: Any, value: np.ndarray[Any, Any], written: dict[int, Any]) -> None:
    group.attrs["kind"] = "array"
    if id(value) in written:
        group["array"] = written[id(value)]  # a hard link: one array in two states of a limb
        return
    options: dict[str, Any] = {}
    if value.nbytes >= _COMPRESSED_FROM and value.dtype.itemsize == 1:
        options = {"compression": "gzip", "compression_opts": 1}
    written[id(value)] = group.create_dataset("array", data=value, **options)


def _encode_leaf(group: Any, value: object, written: dict[int, Any]) -> None:
    if value is None:
        group.attrs["kind"] = "none"
    elif isinstance(value, enum.IntEnum):
        group.attrs["kind"] = "enum"
        group.attrs["class"] = type(value).__name__
        group.attrs["value"] = int(value)
    elif isinstance(value, np.ndarray):
        _encode_array(group, value, written)
    elif isinstance(value, bool | np.bool_):
        group.attrs["kind"] = "bool"
        group.attrs["value"] = int(value)
    elif isinstance(value, int | np.integer):
        group.attrs["kind"] = "int"
        group.attrs["value"] = str(int(value))
    elif isinstance(value, float | np.floating):
        group.attrs["kind"] = "float"
        group.attrs["value"] = float(value)
    elif isinstance(value, str):
        group.attrs["kind"] = "str"
        group.attrs["value"] = value
    else:
        raise TypeError(f"a {type(value).__name__} cannot be kept in a hand-off file")


def _decode(group: Any) -> Any:
    return _DECODERS[group.attrs["kind"]](group)


def _decode_tuple(group: Any) -> tuple[Any, ...]:
    return tuple(_decode(group[name]) for name in sorted(group))


def _decode_mapping(group: Any) -> dict[str, Any]:
    return {group[name].attrs["key"]: _decode(group[name]) for name in sorted(group)}


def _decode_dataclass(group: Any) -> Any:
    known = getattr(handoff, group.attrs["class"])
    return known(**{name: _decode(group[name]) for name in group})


_DECODERS: Mapping[str, Callable[[Any], Any]] = {
    "array": lambda group: np.asarray(group["array"][()]),
    "tuple": _decode_tuple,
    "mapping": _decode_mapping,
    "dataclass": _decode_dataclass,
    "none": lambda _: None,
    "enum": lambda group: getattr(handoff, group.attrs["class"])(int(group.attrs["value"])),
    "bool": lambda group: bool(int(group.attrs["value"])),
    "int": lambda group: int(group.attrs["value"]),
    "float": lambda group: float(group.attrs["value"]),
    "str": lambda group: str(group.attrs["value"]),
}
