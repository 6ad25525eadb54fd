"""What may change in a table of materials while a solver runs."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError

from .material_model import COLUMNS

FIXED_CONSTANTS = ("density", "network_modulus", "network_stiffening")
"""What `MpmSolver.change_materials` must leave alone."""

LARGEST_STRAIN = 2.0
"""Half of the largest difference of two principal Hencky strains after the change, or of their
mean. Chosen: the values of b_e are as 1 to 3000 there, of which single precision still keeps the
smallest to a hundredth."""


def same_bodies(before: FloatArray, after: FloatArray) -> None:
    """Refuse rows that are of other materials, not of the same with other moduli."""
    if after.shape != before.shape:
        raise ScenarioError(
            "materials",
            f"have shape {after.shape}, must have {before.shape}",
            "Give one new row for every row of the table.",
        )
    fixed = [i for i, name in enumerate(COLUMNS) if name in FIXED_CONSTANTS]
    if not np.array_equal(after[:, fixed], before[:, fixed]):
        raise ScenarioError(
            "materials", "change a density or a network", "Change moduli and strengths only."
        )


def bearable(strain: float) -> None:
    """Refuse a change after which unchanged stress needs such a strain."""
    if not strain <= LARGEST_STRAIN:
        raise ScenarioError(
            "materials",
            f"so soft that today's stress strains them by {strain:.2g}, must be at most "
            f"{LARGEST_STRAIN:g}",
            "Wait until the stress has fallen, or lower the moduli less (a higher sound_speed).",
        )
