"""What the imaging stage is asked to do, in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .measurements import measurement

BUILTIN_LEG = "builtin_leg"
"""The `source` that stands for the leg which vulnus generates itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LegMeasurements:
    """The body measurements that the built-in leg takes; lengths in [m].

    The defaults are an average man's and come, with their sources, from
    `data/leg_measurements.csv`.
    """

    stature: float = measurement("stature")
    """Height of the person; the tibia's length follows from it."""
    calf_girth: float = measurement("calf_girth")
    """Greatest girth of the calf."""
    ankle_girth: float = measurement("ankle_girth")
    """Least girth above the malleoli."""
    knee_girth: float = measurement("knee_girth")
    """Girth at the tibial tuberosity, under the knee."""
    skin_thickness: float = measurement("skin_thickness")
    """Epidermis and dermis together."""
    fat_thickness: float = measurement("fat_thickness")
    """Mean subcutaneous fat round the greatest calf; other places follow in proportion."""
    cortex_thickness: float = measurement("cortex_thickness")
    """Mean wall of the tibia at the middle of its shaft."""
    fibula_cortex_thickness: float = measurement("fibula_cortex_thickness")
    """Mean wall of the fibula at the middle of its shaft."""
    popliteal_radius: float = measurement("popliteal_radius")
    """Lumen of the popliteal artery where it leaves the knee."""
    anterior_tibial_radius: float = measurement("anterior_tibial_radius")
    """Lumen of the anterior tibial artery at its origin."""
    posterior_tibial_radius: float = measurement("posterior_tibial_radius")
    """Lumen of the posterior tibial artery at its origin."""
    fibular_radius: float = measurement("fibular_radius")
    """Lumen of the fibular artery at its origin."""

    @property
    def tibia_length(self) -> float:
        """Distance of the tibia's two joint faces [m]."""
        return self.stature * measurement("tibia_length_ratio")


@dataclass(frozen=True, slots=True, kw_only=True)
class ImagingParameters:
    """Where the limb comes from: the built-in leg, or a label volume with its centre-lines.

    `source` is "builtin_leg" or the path of a NRRD or NIfTI file; `centrelines` the path of a JSON
    file, or None to look for `artery_centrelines*.json` beside the volume; `label_map` names the
    tissue of each label value of the file (tissue name -> value), or None for the file's own names
    or the five-label convention; `side` is "left" or "right".
    """

    source: str | Path = BUILTIN_LEG
    centrelines: Path | None = None
    label_map: Mapping[str, int] | None = None
    voxel: float = 1.5e-3
    """Edge of the built-in leg's voxels [m]; chosen: skin and arteries are still resolved."""
    side: str = "left"
    """Which leg it is; the built-in right leg is the left one mirrored."""
    leg: LegMeasurements = field(default_factory=LegMeasurements)
    """Measurements of the built-in leg."""
