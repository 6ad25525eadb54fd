"""Artery centre-lines from JSON files.

The file is an object with `space` ("LPS" or "RAS"), `units` ("mm" or "m") and `segments`, a list
of objects with `name`, `points_mm` (n, 3), `radius_mm` (n) and, where known, `parent`. A key
`voxelized_radius` names the radius that the labels were drawn with.
"""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vulnus.core.arrays import BoolArray, FloatArray, LabelArray
from vulnus.core.errors import InputFileError
from vulnus.core.handoff import ArteryCentreline, Tissue
from vulnus.core.units import MILLIMETRE

from .voxel_file import Grid, require_file

_SYNONYMS = {"peroneal": "fibular", "tibialis_anterior": "anterior_tibial"}
_SYNONYMS["tibialis_posterior"] = "posterior_tibial"
_PARENTS = {
    "anterior_tibial": "popliteal",
    "posterior_tibial": "popliteal",
    "fibular": "popliteal",
}
"""Where the leg's arteries come from when the file does not say (Gray's Anatomy)."""

_CONTACT = 4.0e-3
"""An end nearer than this [m] to another artery's centre-line leaves it; chosen: a popliteal's
radius and a voxel."""

_RADIUS_LIMITS = (0.05e-3, 15.0e-3)
_INSIDE = 0.5
"""Least part of all points that must lie in the limb, not in air."""

_SIGNS = {"LPS": (1.0, 1.0, 1.0), "RAS": (-1.0, -1.0, 1.0)}
_UNITS = {"mm": MILLIMETRE, "m": 1.0}


def artery_name(name: str) -> str:
    """The field's name in snake case without side: "Left fibular artery (x)" -> "fibular"."""
    bare = re.sub(r"\(.*?\)", " ", name)
    bare = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", bare).lower()
    words = [word for word in re.split(r"[^a-z0-9]+", bare) if word]
    kept = [word for word in words if word not in ("artery", "arteria", "a", "left", "right", "l")]
    snake = "_".join(kept)
    return _SYNONYMS.get(snake, snake)


def read_centrelines(path: Path, labels: LabelArray, grid: Grid) -> tuple[ArteryCentreline, ...]:
    """The arteries of a file, proximal to distal, cut to the part inside the volume.

    Errors: InputFileError with the key; where the lines do not lie in the limb.
    """
    require_file(path)
    arteries = _parse(path, _load(path))
    inside = [_clip(artery, labels, grid) for artery in arteries]
    kept = tuple(artery for artery in inside if artery is not None)
    lost = [a.name for a, part in zip(arteries, inside, strict=True) if part is None]
    if kept:
        _check_in_limb(path, kept, labels, grid)
    elif arteries:
        raise InputFileError(
            str(path),
            "none of its centre-lines lies in the label volume",
            "Check that both files are in LPS (or say space: RAS) and in the units they name",
        )
    if lost:
        warnings.warn(f"{path}: outside the volume: {', '.join(lost)}", stacklevel=2)
    return _orient(kept)


def _load(path: Path) -> Mapping[str, Any]:
    try:
        data = json.loads(path.read_text("utf-8"))
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise InputFileError(
            str(path), f"is not valid JSON at {place}: {error.msg}", "Correct or export it again"
        ) from error
    except (UnicodeDecodeError, RecursionError, OSError) as error:
        raise InputFileError(str(path), f"cannot be read ({error})", "Export it again") from error
    if not isinstance(data, dict):
        raise InputFileError(str(path), "is not a JSON object", "See the centre-line layout")
    return data


def _parse(path: Path, data: Mapping[str, Any]) -> list[ArteryCentreline]:
    space = _choice(path, data, "space", _SIGNS, "LPS")
    unit = _choice(path, data, "units", _UNITS, "mm")
    segments = data.get("segments")
    if not isinstance(segments, list) or not segments:
        raise _bad(path, "segments", "is missing, empty or not a list")
    drawn = data.get("voxelized_radius")
    radius_key = drawn if isinstance(drawn, str) else "radius_mm"
    arteries: list[ArteryCentreline] = []
    for number, segment in enumerate(segments):
        where = f"segments[{number}]"
        if not isinstance(segment, dict):
            raise _bad(path, where, "is not an object")
        artery = _parse_segment(path, where, segment, radius_key)
        if artery.name in {other.name for other in arteries}:
            raise _bad(path, f"{where}.name", f"repeats the artery {artery.name!r}")
        points = artery.points * (np.array(_SIGNS[space]) * _UNITS[unit])
        radius = artery.radius * _UNITS[unit]
        if not ((radius >= _RADIUS_LIMITS[0]) & (radius <= _RADIUS_LIMITS[1])).all():
            raise _bad(path, f"{where}.{radius_key}", "leaves the range 0.05-15 mm")
        arteries.append(replace(artery, points=points, radius=radius))
    return arteries


def _choice(
    path: Path, data: Mapping[str, Any], key: str, known: Mapping[str, object], default: str
) -> str:
    value = data.get(key, default)
    if not isinstance(value, str) or value not in known:
        raise _bad(path, key, f"is {value!r}, not one of {', '.join(known)}")
    return value


def _parse_segment(
    path: Path, where: str, segment: Mapping[str, Any], radius_key: str
) -> ArteryCentreline:
    """One artery, still in the file's unit and space."""
    name = segment.get("name")
    if not isinstance(name, str) or not artery_name(name):
        raise _bad(path, f"{where}.name", "is missing or empty")
    points = _numbers(path, f"{where}.points_mm", segment.get("points_mm"))
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise _bad(path, f"{where}.points_mm", "is not a list of at least two [x, y, z]")
    key = radius_key if radius_key in segment else "radius_mm"
    radius = _numbers(path, f"{where}.{key}", segment.get(key))
    if radius.shape != (len(points),):
        raise _bad(path, f"{where}.{key}", f"is not one number for each of {len(points)} points")
    keep = np.concatenate([[True], np.any(np.diff(points, axis=0) != 0.0, axis=1)])
    if keep.sum() < 2:
        raise _bad(path, f"{where}.points_mm", "has no length")
    parent = segment.get("parent")
    if parent is not None and not isinstance(parent, str):
        raise _bad(path, f"{where}.parent", "is not the name of an artery")
    source = artery_name(parent) if parent else None
    return ArteryCentreline(artery_name(name), points[keep], radius[keep], source)


def _numbers(path: Path, key: str, value: object) -> FloatArray:
    if value is None:
        raise _bad(path, key, "is missing")
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise _bad(
            path, key, "holds something else than numbers, or rows of two lengths"
        ) from error
    if not np.isfinite(numbers).all():
        raise _bad(path, key, "holds numbers that are not finite")
    return numbers


def _bad(path: Path, key: str, problem: str) -> InputFileError:
    return InputFileError(f"{path}: {key}", problem, "Correct the centre-line file")


def _clip(artery: ArteryCentreline, labels: LabelArray, grid: Grid) -> ArteryCentreline | None:
    """The longest run of points inside the volume's box, or None."""
    inside = _in_box(_index(artery.points, grid), labels.shape)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    runs = edges.reshape(-1, 2)
    if not len(runs):
        return None
    start, stop = max(runs.tolist(), key=lambda run: run[1] - run[0])
    if stop - start < 2:
        return None
    return replace(artery, points=artery.points[start:stop], radius=artery.radius[start:stop])


def _index(points: FloatArray, grid: Grid) -> FloatArray:
    """Fractional voxel indices (n, 3) of points [m]."""
    index = np.linalg.solve(grid.direction * grid.spacing, (points - grid.origin).T).T
    return np.asarray(index, dtype=np.float64)


def _in_box(index: FloatArray, shape: tuple[int, ...]) -> BoolArray:
    inside = (index >= -0.5) & (index <= np.array(shape) - 0.5)
    return np.asarray(inside.all(axis=1), dtype=np.bool_)


def _check_in_limb(
    path: Path, arteries: Sequence[ArteryCentreline], labels: LabelArray, grid: Grid
) -> None:
    points = np.concatenate([artery.points for artery in arteries])
    index = np.rint(_index(points, grid)).astype(int)
    index = np.clip(index, 0, np.array(labels.shape) - 1)
    part = float(np.mean(labels[tuple(index.T)] != Tissue.AIR))
    if part < _INSIDE:
        raise InputFileError(
            str(path),
            f"only {100 * part:.0f} % of its centre-line points lie in the limb, the rest in air",
            "Check that both files share one frame (LPS), one patient and one unit",
        )


def _orient(arteries: tuple[ArteryCentreline, ...]) -> tuple[ArteryCentreline, ...]:
    """Order each artery from proximal to distal, and name the artery that it leaves."""
    names = {artery.name for artery in arteries}
    oriented = []
    for artery in arteries:
        parent = artery.parent or _PARENTS.get(artery.name)
        parent = parent if parent in names else None
        flipped = artery.points[-1, 2] > artery.points[0, 2]
        if artery.name != "popliteal":
            sources = [a for a in arteries if a.name == parent] or [
                a for a in arteries if a is not artery and a.radius.max() > artery.radius.min()
            ]
            contact = _contact(artery, sources)
            if contact is not None:
                flipped, parent = contact
        order = slice(None, None, -1) if flipped else slice(None)
        oriented.append(
            ArteryCentreline(
                artery.name,
                np.ascontiguousarray(artery.points[order]),
                np.ascontiguousarray(artery.radius[order]),
                parent,
            )
        )
    return tuple(oriented)


def _contact(
    artery: ArteryCentreline, sources: Sequence[ArteryCentreline]
) -> tuple[bool, str] | None:
    """(Whether the last point is the one that touches a source, the source), or None if unclear.

    Of several sources that one end touches, the widest counts.
    """
    gaps = np.array(
        [
            [np.linalg.norm(source.points - artery.points[end], axis=1).min() for end in (0, -1)]
            for source in sources
        ]
    ).reshape(-1, 2)
    if not sources:
        return None
    first, last = gaps.min(axis=0)
    if min(first, last) > _CONTACT or abs(first - last) < _CONTACT:
        return None
    end = int(last < first)
    touching = [source for source, gap in zip(sources, gaps[:, end], strict=True) if gap < _CONTACT]
    widest = max(touching, key=lambda source: float(source.radius.max()))
    return bool(end), widest.name
