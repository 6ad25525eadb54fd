"""Injury by the material point method: a projectile through the limb (paper, section 2.2)."""

from __future__ import annotations

from .parameters import AimParameters, InjuryParameters, ProjectileParameters
from .passage import shoot
from .shot_line import aim
from .solver import HeldEnds, MpmSolver, RigidSphere

__all__ = [
    "AimParameters",
    "HeldEnds",
    "InjuryParameters",
    "MpmSolver",
    "ProjectileParameters",
    "RigidSphere",
    "aim",
    "shoot",
]
