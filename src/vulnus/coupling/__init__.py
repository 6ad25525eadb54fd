"""The exchange of flow and pressure between the arterial tree and the blood particles."""

from __future__ import annotations

from .bleed import bleed_out
from .blood_solver import BloodSolver, BloodVolumes, TreePort
from .parameters import CouplingParameters

__all__ = ["BloodSolver", "BloodVolumes", "CouplingParameters", "TreePort", "bleed_out"]
