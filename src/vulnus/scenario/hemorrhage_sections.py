"""The scenario's tables about the blood particles: resolution, tissue, gravity, platform."""

from __future__ import annotations

import math
from typing import Any, Literal

from pydantic import field_validator

from vulnus.core.arrays import Vector3
from vulnus.core.constants import STANDARD_GRAVITY
from vulnus.hemorrhage.parameters import (
    BarrierModel,
    HemorrhageParameters,
    KernelSet,
    PermeabilityModel,
    PlatformParameters,
    PressureModel,
)

from .quantity import Section, choice, quantity, to_parameters

DIRECTIONS: dict[str, Vector3] = {
    "distal": (0.0, 0.0, -1.0),
    "proximal": (0.0, 0.0, 1.0),
    "anterior": (0.0, -1.0, 0.0),
    "posterior": (0.0, 1.0, 0.0),
    "left": (1.0, 0.0, 0.0),
    "right": (-1.0, 0.0, 0.0),
}
"""Names of the axes of the patient frame (LPS) for a leg."""


class PlatformSection(Section):
    """[hemorrhage.platform]: a slab across gravity just below the limb, on which blood pools."""

    enabled: bool = choice(default=False, meaning="put it there (the paper's Fig. 6)")
    gap_mm: float = quantity(
        PlatformParameters,
        "gap",
        "mm",
        "from the limb's lowest point to its face",
        ge=0,
        le=500,
    )
    half_extent_mm: float = quantity(
        PlatformParameters, "half_extent", "mm", "half the side of the square", gt=0, le=2000
    )

    def parameters(self) -> PlatformParameters | None:
        """The platform in SI, or None."""
        return to_parameters(self, PlatformParameters) if self.enabled else None


class HemorrhageSection(Section):
    """[hemorrhage]: blood as particles in porous, injured tissue (equations 2-13)."""

    particle_spacing_mm: float = quantity(
        HemorrhageParameters,
        "particle_spacing",
        "mm",
        "rest spacing of blood particles; one stands for its cube of blood",
        ge=0.2,
        le=10,
    )
    smoothing_ratio: float = quantity(
        HemorrhageParameters,
        "smoothing_ratio",
        "",
        "smoothing radius over particle spacing",
        ge=1.2,
        le=4,
    )
    kernels: KernelSet = quantity(
        HemorrhageParameters,
        "kernels",
        "",
        'of the sums: "wendland_c2" for all, or the paper\'s three, "mueller2003"',
    )
    sound_speed_m_per_s: float = quantity(
        HemorrhageParameters,
        "sound_speed",
        "m/s",
        "numerical speed of sound; at least ten times the fastest blood",
        ge=1,
        le=2000,
    )
    density_kg_per_m3: float = quantity(
        HemorrhageParameters, "density", "kg/m³", "rest density of blood", ge=900, le=1200
    )
    viscosity_mpa_s: float = quantity(
        HemorrhageParameters, "viscosity", "mPa s", "dynamic viscosity of blood", ge=0.1, le=100
    )
    gravity_direction: Any = choice(
        "distal",
        "where down is: distal (the leg upright), proximal, anterior, posterior (lying on the "
        "back), left, right, or a vector [x, y, z] (patient's left, posterior, superior)",
    )
    permeability_model: PermeabilityModel = quantity(
        HemorrhageParameters,
        "permeability_model",
        "",
        '"kozeny_carman": from porosity and damage; "constant": permeability_m2 everywhere',
    )
    permeability_m2: float = quantity(
        HemorrhageParameters,
        "permeability_constant",
        "m²",
        "of all tissue in the constant model",
        gt=0,
        le=1e-2,
    )
    porosity_intact: float = quantity(
        HemorrhageParameters, "porosity_intact", "", "porosity of intact tissue", gt=0, lt=1
    )
    tissue_cell_mm: float = quantity(
        HemorrhageParameters,
        "tissue_cell",
        "mm",
        "cell of the tissue grid; 0: the spacing of the limb's material points",
        ge=0,
        le=20,
    )
    source_radius_mm: float = quantity(
        HemorrhageParameters,
        "source_radius",
        "mm",
        "of the spherical shell on which blood appears",
        gt=0,
        le=20,
    )
    barrier_model: BarrierModel = quantity(
        HemorrhageParameters,
        "barrier_model",
        "",
        'which skin and bone holds blood back: "damage": what is not destroyed; "presence": all',
    )
    barrier_damage: float = quantity(
        HemorrhageParameters,
        "barrier_damage",
        "",
        "damage from which a point of skin or bone is debris",
        gt=0,
        le=1,
    )
    pressure_model: PressureModel = quantity(
        HemorrhageParameters,
        "pressure_model",
        "",
        'whether the pressure of equation (7) may be negative: "unclamped"; or not: "clamped"',
    )
    equations: Literal["corrected", "as_printed"] = choice(
        "corrected", "the paper's equations with its slips corrected, or as it prints them"
    )
    courant_number: float = quantity(
        HemorrhageParameters, "courant_number", "", "of the time step", gt=0, le=1
    )
    removal_distance_mm: float = quantity(
        HemorrhageParameters,
        "removal_distance",
        "mm",
        "blood farther than this from the limb is taken out and booked as removed",
        gt=0,
        le=5000,
    )
    platform: PlatformSection = PlatformSection()

    @field_validator("gravity_direction", mode="plain")
    @classmethod
    def _known_direction(cls, value: Any) -> str | list[float]:
        if isinstance(value, str) and value in DIRECTIONS:
            return value
        if isinstance(value, list) and len(value) == len(DIRECTIONS["distal"]):
            numbers = [float(x) for x in value if type(x) in (int, float) and abs(x) <= 1e6]
            if len(numbers) == len(value) and any(abs(x) > 1e-6 for x in numbers):
                return numbers
        raise ValueError(
            f"must be one of {', '.join(DIRECTIONS)}, or three numbers [x, y, z], not all zero"
        )

    def gravity(self) -> Vector3:
        """Acceleration of gravity [m/s²], LPS."""
        given = self.gravity_direction
        x, y, z = DIRECTIONS[given] if isinstance(given, str) else given
        length = math.hypot(x, y, z)
        factor = STANDARD_GRAVITY / length
        return (x * factor + 0.0, y * factor + 0.0, z * factor + 0.0)

    def parameters(self, *, seed: int, threads: int) -> HemorrhageParameters:
        """The stage's parameters in SI."""
        return to_parameters(
            self,
            HemorrhageParameters,
            gravity=self.gravity(),
            platform=self.platform.parameters(),
            as_printed=self.equations == "as_printed",
            seed=seed,
            threads=threads,
        )
