"""What decides how an experiment runs, piece by piece as texts, to tell experiments apart."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.errors import StorageError

from ..bodies.rigid_body import RigidBody
from ..bodies.solids import Solid
from ..boundaries import Boundary
from .particles import ParticleStore
from .sensors import Sensor

WRITTEN_OUT = 9
"""Numbers of an array up to which they are written out; of more the digest is kept."""
PROBES_ALONG = 7
"""Points along each edge of a box at which a solid is probed [chosen: 343 see any change of it]."""
NOT_DECIDING = ("name", "source")
"""Fields that only tell where something comes from."""


def experiment_fingerprint(
    settings: object,
    store: ParticleStore,
    bodies: Sequence[RigidBody],
    boundaries: Sequence[Boundary],
    sensors: Mapping[str, Sensor],
) -> dict[str, str]:
    """Everything that decides the run and its columns, by a name that a user knows."""
    texts = dict(_described("", settings))
    texts["names of the bodies"] = repr([filling.name for filling in store.fillings])
    for filling in store.fillings:
        texts |= {
            f"{filling.name}: {key}": _array_text(getattr(filling, key))
            for key in ("position", "volume", "velocity")
        }
        if filling.state is not None:
            texts[f"{filling.name}: state"] = _array_text(filling.state)
        material = store.materials[filling.material_row]
        texts |= _described(f"{filling.name}: material", material)
    texts["names of the rigid bodies"] = repr([body.name for body in bodies])
    for body in bodies:
        texts |= _described(body.name, body)
    for number, boundary in enumerate(boundaries, 1):
        texts |= _described(f"boundary {number}", boundary)
    for name, sensor in sensors.items():
        texts |= _described(f"sensor {name}", sensor)
    return texts


def refuse_another(saved: Mapping[str, str], present: Mapping[str, str]) -> None:
    """Refuse a checkpoint whose experiment differs from the present one; names the first piece."""
    for key in [*saved, *present]:
        before, now = saved.get(key), present.get(key)
        if before == now:
            continue
        if before is None or now is None:
            told = f"{key} {'was not there' if before is None else 'is not there any more'}"
        elif "digest" in before or "digest" in now:
            told = f"{key} differs"
        else:
            told = f"{key} was {before}, is {now}"
        raise StorageError(
            "experiment checkpoint",
            f"it is of another experiment: {told}",
            "Set the experiment up as it was, delete the checkpoint, or use another file.",
        )


def _described(name: str, value: Any) -> Iterator[tuple[str, str]]:
    """Name and text of a value, or of each of its parts."""
    if isinstance(value, Solid):
        yield name, f"{type(value).__name__}, digest {_solid_digest(value)}"
    elif is_dataclass(value) and not isinstance(value, type):
        yield f"{name}: kind" if name else "kind", type(value).__name__
        for field in fields(value):
            if field.name not in NOT_DECIDING:
                key = f"{name}: {field.name}" if name else field.name
                yield from _described(key, getattr(value, field.name))
    elif value is None or isinstance(value, bool | str):
        yield name, repr(value)
    else:
        yield name, _value_text(value)


def _value_text(value: Any) -> str:
    """Numbers as numbers, texts as texts; of anything else its type."""
    if isinstance(value, tuple | list) and any(isinstance(item, str) for item in value):
        return repr(list(value))
    try:
        return _array_text(np.asarray(value, np.float64))
    except (TypeError, ValueError):
        return type(value).__qualname__


def _array_text(array: AnyArray) -> str:
    if array.size <= WRITTEN_OUT:
        return repr(array.tolist())
    digest = hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
    return f"{array.shape}, digest {digest}"


def _solid_digest(solid: Solid) -> str:
    """Of the solid's distances from points in and around it, whatever it is made of."""
    lower, upper = (np.clip(corner, -1.0, 1.0) for corner in solid.bounds)
    axes = [np.linspace(low, high, PROBES_ALONG) for low, high in zip(lower, upper, strict=True)]
    probes: FloatArray = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    seen = [np.ravel(solid.bounds), solid.signed_distance(probes)]
    return hashlib.sha256(np.concatenate(seen).tobytes()).hexdigest()
