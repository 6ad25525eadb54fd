"""Blood: weakly compressible SPH in Brinkman tissue, behind barriers (Chong 2017, §2.3)."""

from __future__ import annotations

from .bleeding import BleedingSolver, BloodVolumes
from .fluid import Fluid, FluidParameters
from .openings import Openings, skin_openings
from .parameters import HemorrhageParameters, PlatformParameters
from .preparation import prepare
from .scene import FluidScene

__all__ = [
    "BleedingSolver",
    "BloodVolumes",
    "Fluid",
    "FluidParameters",
    "FluidScene",
    "HemorrhageParameters",
    "Openings",
    "PlatformParameters",
    "prepare",
    "skin_openings",
]
