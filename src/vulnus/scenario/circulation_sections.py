"""The scenario's tables about the arterial tree and its exchange with the bleeding limb."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from vulnus.circulation.parameters import CirculationParameters, InjuryMode
from vulnus.coupling.parameters import CouplingParameters

from .quantity import Section, quantity, to_parameters


class CirculationSection(Section):
    """[circulation]: the systemic arterial tree and its injury branch."""

    tree: Literal["stergiopulos91"] = quantity(
        CirculationParameters, "tree", "", "table of segments: the paper's 91"
    )
    harmonics: int = quantity(
        CirculationParameters,
        "harmonics",
        "",
        "harmonics of the heart's frequency beside the mean",
        ge=8,
        le=1024,
    )
    density_kg_per_m3: float = quantity(
        CirculationParameters,
        "density",
        "kg/m³",
        "of blood in the arteries",
        ge=900,
        le=1200,
    )
    viscosity_mpa_s: float = quantity(
        CirculationParameters,
        "viscosity",
        "mPa s",
        "dynamic viscosity of blood in the arteries",
        ge=0.5,
        le=20,
    )
    poisson_ratio: float = quantity(
        CirculationParameters, "poisson_ratio", "", "of the arterial wall", ge=0, le=0.5
    )
    wall_phase_deg: float = quantity(
        CirculationParameters,
        "wall_phase",
        "deg",
        "viscoelastic lag of the wall at high frequency",
        ge=0,
        le=45,
    )
    venous_pressure_mmhg: float = quantity(
        CirculationParameters,
        "venous_pressure",
        "mmHg",
        "pressure behind the terminal resistances",
        ge=0,
        le=40,
    )
    terminal_compliance_ml_per_mmhg: float = quantity(
        CirculationParameters,
        "terminal_compliance",
        "ml/mmHg",
        "of all terminal beds together; 0: pure resistances",
        ge=0,
        le=10,
    )
    source: Literal["pressure", "flow"] = quantity(
        CirculationParameters, "source", "", "what is imposed at the aortic root"
    )
    heart_rate_per_min: float | None = quantity(
        CirculationParameters,
        "heart_rate",
        "1/min",
        'beats; "auto": the aortic signal\'s own',
        ge=20,
        le=240,
    )
    aortic_mean_pressure_mmhg: float | None = quantity(
        CirculationParameters,
        "aortic_mean_pressure",
        "mmHg",
        'mean of the aortic pressure; "auto": the signal\'s own',
        ge=10,
        le=250,
    )
    aortic_pulse_pressure_mmhg: float | None = quantity(
        CirculationParameters,
        "aortic_pulse_pressure",
        "mmHg",
        'systolic less diastolic pressure; "auto": the signal\'s own',
        ge=0,
        le=200,
    )
    exit_loss_coefficient: float = quantity(
        CirculationParameters,
        "exit_loss_coefficient",
        "",
        "K of the stump's exit loss ½ K ρ v²",
        ge=0,
        le=20,
    )
    injury_mode: InjuryMode = quantity(
        CirculationParameters,
        "injury_mode",
        "",
        '"transection": nothing flows on past the cut; "shunt": the paper\'s branch beside it',
    )
    shunt_resistance_pa_s_per_m3: float = quantity(
        CirculationParameters,
        "shunt_resistance",
        "Pa s/m³",
        "of the branch of the mode shunt",
        gt=0,
        le=1e12,
    )

    def parameters(self) -> CirculationParameters:
        """The stage's parameters in SI."""
        return to_parameters(self, CirculationParameters)


class CouplingSection(Section):
    """[coupling]: how long the limb bleeds, and how tree and blood talk to each other."""

    duration_s: float = quantity(
        CouplingParameters, "duration", "s", "simulated time of bleeding", gt=0, le=600
    )
    frame_interval_s: float = quantity(
        CouplingParameters, "frame_interval", "s", "between two saved frames", ge=0.001, le=60
    )
    sample_interval_s: float = quantity(
        CouplingParameters,
        "sample_interval",
        "s",
        "between two rows of waveforms.csv and ledger.csv",
        ge=0.0005,
        le=1,
    )
    relaxation: float = quantity(
        CouplingParameters,
        "relaxation",
        "",
        "ω of the exchanged pressure p ← p + ω (measured - p); 1: the paper's plain exchange",
        gt=0,
        le=1,
    )
    initial_pressure_mmhg: float = quantity(
        CouplingParameters,
        "initial_pressure",
        "mmHg",
        "around the wound in the first beat",
        ge=-50,
        le=250,
    )

    def parameters(self) -> CouplingParameters:
        """The stage's parameters in SI."""
        return to_parameters(self, CouplingParameters)

    @model_validator(mode="after")
    def _frames_fit(self) -> CouplingSection:
        if self.frame_interval_s > self.duration_s:
            raise ValueError(
                f"frame_interval_s = {self.frame_interval_s:g} must not be longer than "
                f"duration_s = {self.duration_s:g}"
            )
        return self
