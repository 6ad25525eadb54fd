"""Anatomy (paper §2.2, first paragraph): from labelled voxels to the material points of a limb."""

from .limb import build_limb
from .parameters import AnatomyParameters
from .volumes import TissueVolume, compare_volumes

__all__ = ["AnatomyParameters", "TissueVolume", "build_limb", "compare_volumes"]
