"""The scenario's table about the passage: mode, resolution, window and thresholds."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Len
from pydantic import model_validator

from vulnus.core.arrays import Vector3
from vulnus.core.units import MILLIMETRE
from vulnus.injury.parameters import InjuryMode, InjuryParameters, WoundState

from .projectile_sections import AimSection, ProjectileSection, ShotSection
from .quantity import Section, choice, quantity, to_parameters


class InjurySection(Section):
    """[injury]: the projectile's passage through the limb (equation 1)."""

    mode: InjuryMode = quantity(
        InjuryParameters,
        "mode",
        "",
        "full: until the temporary cavity has collapsed; paper: the passage alone, whose last "
        "instant is the wound",
    )
    grid_spacing_mm: float = quantity(
        InjuryParameters, "grid_spacing", "mm", "edge of a grid cell", ge=0.5, le=30
    )
    duration_ms: float | None = quantity(
        InjuryParameters,
        "duration",
        "ms",
        'from first contact to the end; "auto": 1 in the mode paper; in the mode full until the '
        "cavity has collapsed, from 10 to 20; and until a blade is out again",
        gt=0,
        le=200,
    )
    phase_one_ms: float = quantity(
        InjuryParameters,
        "phase_one",
        "ms",
        "least time with the true moduli, which stay while a projectile flies or is thrust in the "
        "limb",
        gt=0,
        le=200,
    )
    relaxation_sound_speed_m_per_s: float = quantity(
        InjuryParameters,
        "relaxation_sound_speed",
        "m/s",
        "speed of sound that tissues are slowed to after that; 0: the true moduli to the end",
        ge=0,
        le=6000,
    )
    bleeds_from: WoundState = quantity(
        InjuryParameters,
        "bleeds_from",
        "",
        "state of the wound that bleeds and is drawn; the mode paper has only permanent",
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
        "length at both ends of the limb where the tissue is held fast",
        ge=0,
        le=100,
    )
    absorbing_length_mm: float = quantity(
        InjuryParameters,
        "absorbing_length",
        "mm",
        "length inside a cut end of the window that takes up waves; 0: that end is held",
        ge=0,
        le=200,
    )
    frame_interval_ms: float = quantity(
        InjuryParameters,
        "frame_interval",
        "ms",
        "between two saved frames of the passage",
        gt=0,
        le=100,
    )
    relaxation_frame_interval_ms: float = quantity(
        InjuryParameters,
        "relaxation_frame_interval",
        "ms",
        "between two saved frames after it",
        gt=0,
        le=100,
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
    laceration_threshold: float = quantity(
        InjuryParameters,
        "laceration_threshold",
        "",
        "destroyed share of an artery's wall from which it is lacerated",
        gt=0,
        le=1,
    )
    projectiles: Annotated[list[ShotSection], Len(0, 20)] = choice(
        [],
        "several projectiles at once, each a table [[injury.projectiles]] with the keys of "
        "[injury.projectile] and [injury.projectiles.aim], in place of those two tables",
    )
    projectile: ProjectileSection = ProjectileSection()
    aim: AimSection = AimSection()

    @model_validator(mode="after")
    def _one_or_several(self) -> InjurySection:
        single = self.projectile != ProjectileSection() or self.aim != AimSection()
        if self.projectiles and single:
            raise ValueError(
                "give [injury.projectile] and [injury.aim], or [[injury.projectiles]], not both"
            )
        return self

    @model_validator(mode="after")
    def _holds_together(self) -> InjurySection:
        if self.laceration_threshold > self.damage_threshold:
            raise ValueError(
                f"laceration_threshold is {self.laceration_threshold:g}, must not exceed "
                f"damage_threshold, {self.damage_threshold:g}, from which an artery is transected"
            )
        if self.mode == "paper":
            self._fits_the_paper()
        ends = max(self.held_length_mm, self.absorbing_length_mm)
        if 0.0 < self.window_length_mm <= 2.0 * ends:
            raise ValueError(
                f"window_length_mm is {self.window_length_mm:g} mm, must exceed what both ends "
                f"take, {ends:g} mm each"
            )
        needed = max(shot.thrust_ms for shot in self.shots)
        if self.duration_ms is not None and self.duration_ms < needed:
            raise ValueError(
                f"duration_ms is {self.duration_ms:g} ms, but the blade needs {needed:.4g} ms in "
                "and out: leave it out, or give more"
            )
        return self

    def _fits_the_paper(self) -> None:
        """Refuse what the mode "paper" has not."""
        if self.bleeds_from != "permanent":
            raise ValueError(
                'bleeds_from = "temporary" has no meaning in the mode "paper", whose wound is its '
                'last instant: leave it out, or give mode = "full"'
            )
        if any(shot.motion == "dynamic" for shot in self.shots):
            raise ValueError(
                'motion = "dynamic" has no meaning in the mode "paper", whose projectile keeps '
                'its velocity: leave it out, or give mode = "full"'
            )

    @property
    def shots(self) -> list[ProjectileSection]:
        """The projectiles of one shot or of several."""
        return [*self.projectiles] or [self.projectile]

    def parameters(self, *, seed: int, threads: int, gravity: Vector3) -> InjuryParameters:
        """The stage's parameters in SI."""
        may_move = self.mode == "full"
        shots = [one.shot(may_move=may_move) for one in self.projectiles]
        if shots:
            projectile, aim = shots[0].projectile, shots[0].aim
        else:
            projectile = self.projectile.parameters(may_move=may_move)
            aim = self.aim.parameters()
        return to_parameters(
            self,
            InjuryParameters,
            projectile=projectile,
            aim=aim,
            other_shots=tuple(shots[1:]),
            window_length=self.window_length_mm * MILLIMETRE or None,
            gravity=gravity,
            seed=seed,
            threads=threads,
        )
