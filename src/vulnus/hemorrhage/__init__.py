"""Blood: weakly compressible SPH in Brinkman tissue, behind barriers (Chong 2017, §2.3)."""

from __future__ import annotations

from .parameters import HemorrhageParameters, PlatformParameters

__all__ = ["HemorrhageParameters", "PlatformParameters"]
