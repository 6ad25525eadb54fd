"""The scenario's tables about the shot: projectile, aim and resolution of the passage."""

from __future__ import annotations

from typing import Annotated, Any

from annotated_types import Len
from pydantic import Field, field_validator, model_validator

from vulnus.core.arrays import Vector3
from vulnus.core.units import MILLIMETRE
from vulnus.injury.parameters import AimParameters, InjuryParameters, ProjectileParameters

from .quantity import Section, choice, quantity, to_parameters

Coordinate = Annotated[float, Field(ge=-5000, le=5000)]
Triple = Annotated[list[float], Len(3, 3)]


class ProjectileSection(Section):
    """[injury.projectile]: a rigid sphere that keeps its velocity."""

    diameter_mm: float = quantity(
        ProjectileParameters, "diameter", "mm", "diameter of the sphere", gt=0, le=40
    )
    speed_m_per_s: float = quantity(
        ProjectileParameters, "speed", "m/s", "speed of the sphere", gt=0, le=1500
    )
    friction: float = quantity(
        ProjectileParameters, "friction", "", "Coulomb's, against tissue", ge=0, le=2
    )


class AimSection(Section):
    """[injury.aim]: one point on the line of flight and one direction."""

    artery: str | None = choice(
        None,
        "the line of flight meets this artery's centre-line (popliteal, anterior_tibial, "
        'posterior_tibial, fibular); "auto": anterior_tibial, or target_mm where it is given',
        min_length=1,
    )
    fraction: float = quantity(
        AimParameters,
        "fraction",
        "",
        "where on the artery, as a part of its length from its proximal end",
        ge=0,
        le=1,
    )
    target_mm: Annotated[list[Coordinate], Len(3, 3)] | None = quantity(
        AimParameters,
        "target",
        "mm",
        "a point on the line of flight, instead of an artery: x to the patient's left, "
        'y posterior, z superior; "auto": the artery\'s point',
    )
    azimuth_deg: float = quantity(
        AimParameters,
        "azimuth",
        "deg",
        "side the projectile comes from, seen from above: 0 anterior, 90 the patient's left, "
        "180 posterior, 270 the patient's right",
        ge=-360,
        le=360,
    )
    elevation_deg: float = quantity(
        AimParameters,
        "elevation",
        "deg",
        "height the projectile comes from: > 0 from above",
        ge=-90,
        le=90,
    )
    direction: Triple | None = quantity(
        AimParameters,
        "direction",
        "",
        'direction of flight (x, y, z), instead of the two angles; "auto": the angles',
    )

    @field_validator("direction")
    @classmethod
    def _points_somewhere(cls, direction: list[float] | None) -> list[float] | None:
        if direction is not None and not any(direction):
            raise ValueError("must not be [0, 0, 0]: a direction has a length")
        return direction

    @model_validator(mode="after")
    def _one_point(self) -> AimSection:
        if self.artery is not None and self.target_mm is not None:
            raise ValueError("give artery or target_mm, not both: each fixes the line of flight")
        return self

    def parameters(self) -> AimParameters:
        """Artery or target, and direction, in SI."""
        chosen: dict[str, Any] = {"artery": self.artery}
        if self.artery is None and self.target_mm is None:
            chosen = {}
        return to_parameters(self, AimParameters, **chosen)


class InjurySection(Section):
    """[injury]: the projectile's passage through the limb (equation 1)."""

    grid_spacing_mm: float = quantity(
        InjuryParameters, "grid_spacing", "mm", "edge of a grid cell", ge=0.5, le=30
    )
    duration_ms: float | None = quantity(
        InjuryParameters,
        "duration",
        "ms",
        'from first contact to the end; "auto": 1 ms in the mode "paper", else 15 ms',
        gt=0,
        le=100,
    )
    courant_number: float = quantity(
        InjuryParameters,
        "courant_number",
        "",
        "part of a cell that sound and matter may cross in a step",
        gt=0,
        le=0.7,
    )
    window_length_mm: float = choice(
        round((InjuryParameters().window_length or 0.0) / MILLIMETRE, 6),
        "length of limb around the track that is simulated; 0: the whole limb",
        unit="mm",
        ge=0,
        le=2000,
    )
    held_length_mm: float = quantity(
        InjuryParameters,
        "held_length",
        "mm",
        "length at both ends of the window where the tissue is held fast",
        ge=0,
        le=100,
    )
    frame_interval_ms: float = quantity(
        InjuryParameters, "frame_interval", "ms", "between two saved frames", gt=0, le=100
    )
    bone_modulus_scale: float = quantity(
        InjuryParameters,
        "bone_modulus_scale",
        "",
        "factor on cortical bone's elastic moduli; 1: the true stiffness, at twice the steps",
        gt=0,
        le=1,
    )
    artery_failure_stretch: float = quantity(
        InjuryParameters,
        "artery_failure_stretch",
        "",
        "stretch of the centre-line at which the wall is torn through",
        gt=1,
        le=10,
    )
    damage_threshold: float = quantity(
        InjuryParameters,
        "damage_threshold",
        "",
        "damage from which tissue counts as destroyed",
        gt=0,
        le=1,
    )
    projectile: ProjectileSection = ProjectileSection()
    aim: AimSection = AimSection()

    def parameters(self, *, seed: int, threads: int, gravity: Vector3) -> InjuryParameters:
        """The stage's parameters in SI."""
        return to_parameters(
            self,
            InjuryParameters,
            projectile=to_parameters(self.projectile, ProjectileParameters),
            aim=self.aim.parameters(),
            window_length=self.window_length_mm * MILLIMETRE or None,
            gravity=gravity,
            seed=seed,
            threads=threads,
        )
