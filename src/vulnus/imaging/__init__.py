"""Imaging (paper §2.1): label volumes from files, and the leg that vulnus brings with it."""

from __future__ import annotations

from .parameters import BUILTIN_LEG, ImagingParameters, LegMeasurements

__all__ = ["BUILTIN_LEG", "ImagingParameters", "LegMeasurements"]
