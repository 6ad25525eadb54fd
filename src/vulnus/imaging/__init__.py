"""Imaging (paper §2.1): label volumes from files, and the leg that vulnus brings with it."""

from __future__ import annotations

from vulnus.core.handoff import LabelVolume
from vulnus.core.progress import SilentProgress

from .labels import load_labels
from .parameters import BUILTIN_LEG, ImagingParameters, LegMeasurements
from .raw_labels import read_labels

__all__ = [
    "BUILTIN_LEG",
    "ImagingParameters",
    "LegMeasurements",
    "generate_leg",
    "load_labels",
    "read_labels",
]


def generate_leg(parameters: ImagingParameters | None = None) -> LabelVolume:
    """The built-in leg as labelled voxels with its arteries as centre-lines."""
    from .builtin_leg import generate_leg as generate

    return generate(parameters or ImagingParameters(), SilentProgress())
