"""What the arterial tree and its injury branch are computed with; SI values with their sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vulnus.core.constants import BLOOD_DENSITY
from vulnus.core.units import DEGREE, MILLIMETRE_OF_MERCURY

InjuryMode = Literal["transection", "shunt"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CirculationParameters:
    """The systemic arterial tree, its source and its injury branch.

    `tree`: name of the table, "stergiopulos91" (the paper's 91 segments).
    `harmonics`: harmonics of the heart's frequency kept beside the mean (128: half the 256 samples
    of the aortic signal, so that nothing of it is lost). Signals have `2 * harmonics` samples.
    `density` [kg/m³], `viscosity` [Pa s] of blood in the arteries (4 mPa s: Cardio1D and CVModule,
    the codes of the paper's group).
    `poisson_ratio` (0.5: incompressible wall) and `wall_phase` [rad], the viscoelastic lag
    φ₀ of the wall at high frequency (15°, Avolio 1980).
    `venous_pressure` [Pa] behind the terminal resistances (5 mmHg, chosen: middle of the normal
    central venous range of 2-8 mmHg).
    `terminal_compliance` [m³/Pa] of all terminal beds together, shared out in proportion to their
    conductance (0.2 ml/mmHg, chosen: a third of the tree's own 0.63 ml/mmHg, so that terminals
    reflect slow waves and swallow fast ones; 0 gives pure resistances as in Cardio1D).
    `source`: what is imposed at the root, the aortic "pressure" (the paper) or "flow".
    `heart_rate` [1/s]: None keeps the aortic signal's own, 1/0.8288 s; a value stretches its time.
    `aortic_mean_pressure`, `aortic_pulse_pressure` [Pa]: None keeps the signal's 90/47 mmHg; a
    value shifts or scales the pressure signal.
    `exit_loss_coefficient` K of ½ K ρ v² at the stump, in both modes (1.5: 1 for the jet's lost
    head, 0.5 for the contraction; 0 leaves a linear branch).
    `injury_mode`: "transection" drops the arterial tree behind the cut (its distal stump is not
    fed), "shunt" keeps it and hangs the paper's branch of low impedance beside it.
    `shunt_resistance` [Pa s/m³] of that branch (1e7, chosen: 1/20 of the smallest tibial Thevenin
    resistance, 2e8); used in the mode "shunt" only.
    """

    tree: str = "stergiopulos91"
    harmonics: int = 128
    density: float = BLOOD_DENSITY
    viscosity: float = 4.0e-3
    poisson_ratio: float = 0.5
    wall_phase: float = 15.0 * DEGREE
    venous_pressure: float = 5.0 * MILLIMETRE_OF_MERCURY
    terminal_compliance: float = 0.2e-6 / MILLIMETRE_OF_MERCURY
    source: Literal["pressure", "flow"] = "pressure"
    heart_rate: float | None = None
    aortic_mean_pressure: float | None = None
    aortic_pulse_pressure: float | None = None
    exit_loss_coefficient: float = 1.5
    injury_mode: InjuryMode = "transection"
    shunt_resistance: float = 1.0e7
