"""The scenario's tables about the limb: where it comes from and how it becomes particles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator

from vulnus.anatomy.parameters import AnatomyParameters
from vulnus.core.handoff import Tissue
from vulnus.imaging.parameters import BUILTIN_LEG, ImagingParameters, LegMeasurements

from .quantity import Section, choice, quantity, to_parameters

LabelValue = Annotated[int, Field(ge=0, le=255)]
TISSUE_NAMES = tuple(tissue.name.lower() for tissue in Tissue)


class LegSection(Section):
    """[imaging.leg]: measurements of the built-in leg; its defaults are an average man's."""

    stature_mm: float = quantity(
        LegMeasurements, "stature", "mm", "height of the person", ge=1000, le=2300
    )
    calf_girth_mm: float = quantity(
        LegMeasurements, "calf_girth", "mm", "greatest girth of the calf", ge=200, le=700
    )
    ankle_girth_mm: float = quantity(
        LegMeasurements, "ankle_girth", "mm", "least girth above the malleoli", ge=140, le=400
    )
    knee_girth_mm: float = quantity(
        LegMeasurements, "knee_girth", "mm", "girth at the tibial tuberosity", ge=220, le=700
    )
    skin_thickness_mm: float = quantity(
        LegMeasurements, "skin_thickness", "mm", "epidermis and dermis together", ge=0.5, le=5
    )
    fat_thickness_mm: float = quantity(
        LegMeasurements,
        "fat_thickness",
        "mm",
        "mean subcutaneous fat round the greatest calf",
        ge=0.5,
        le=50,
    )
    cortex_thickness_mm: float = quantity(
        LegMeasurements, "cortex_thickness", "mm", "wall of the tibia's mid-shaft", ge=1, le=10
    )
    fibula_cortex_thickness_mm: float = quantity(
        LegMeasurements,
        "fibula_cortex_thickness",
        "mm",
        "wall of the fibula's mid-shaft",
        ge=0.5,
        le=6,
    )
    popliteal_radius_mm: float = quantity(
        LegMeasurements, "popliteal_radius", "mm", "lumen of the popliteal artery", ge=1, le=6
    )
    anterior_tibial_radius_mm: float = quantity(
        LegMeasurements,
        "anterior_tibial_radius",
        "mm",
        "lumen of the anterior tibial artery at its origin",
        ge=0.5,
        le=4,
    )
    posterior_tibial_radius_mm: float = quantity(
        LegMeasurements,
        "posterior_tibial_radius",
        "mm",
        "lumen of the posterior tibial artery at its origin",
        ge=0.5,
        le=4,
    )
    fibular_radius_mm: float = quantity(
        LegMeasurements,
        "fibular_radius",
        "mm",
        "lumen of the fibular artery at its origin",
        ge=0.5,
        le=4,
    )


class ImagingSection(Section):
    """[imaging]: the built-in leg, or a label volume with the centre-lines of its arteries."""

    source: str = choice(
        BUILTIN_LEG,
        '"builtin_leg", or a label volume: path of a .nrrd, .seg.nrrd, .nii or .nii.gz file '
        "(relative to the scenario file)",
        min_length=1,
    )
    centrelines: str | None = choice(
        None,
        "JSON file with the arteries' centre-lines (relative to the scenario file); "
        '"auto": artery_centrelines*.json beside the volume',
        min_length=1,
    )
    side: Literal["left", "right"] = quantity(ImagingParameters, "side", "", "which leg it is")
    voxel_mm: float = quantity(
        ImagingParameters, "voxel", "mm", "edge of the built-in leg's voxels", ge=0.2, le=6
    )
    labels: dict[str, LabelValue] | None = choice(
        None,
        "label value of each tissue in the file, as a table { skin = 1, bone = 3 }; "
        '"auto": the file\'s own names, or 1 skin, 2 soft tissue, 3 bone, 4 artery',
    )
    leg: LegSection = LegSection()

    @field_validator("labels")
    @classmethod
    def _known_tissues(cls, labels: dict[str, int] | None) -> dict[str, int] | None:
        for name in labels or {}:
            if name not in TISSUE_NAMES:
                raise ValueError(
                    f"{name!r} is no tissue that vulnus knows; use {', '.join(TISSUE_NAMES)}"
                )
        return labels

    def parameters(self) -> ImagingParameters:
        """The stage's parameters in SI."""
        builtin = self.source == BUILTIN_LEG
        return to_parameters(
            self,
            ImagingParameters,
            source=self.source if builtin else Path(self.source),
            centrelines=None if self.centrelines is None else Path(self.centrelines),
            label_map=self.labels,
            leg=to_parameters(self.leg, LegMeasurements),
        )


class AnatomySection(Section):
    """[anatomy]: the limb as material points."""

    particle_spacing_mm: float = quantity(
        AnatomyParameters,
        "particle_spacing",
        "mm",
        "smallest distance of two material points (Poisson-disk radius)",
        ge=0.3,
        le=12,
    )
    level_set_voxel_mm: float | None = quantity(
        AnatomyParameters,
        "level_set_voxel",
        "mm",
        'voxel of the limb\'s level sets; "auto": half the particle spacing, within limits',
        ge=0.1,
        le=12,
    )
    smoothing_iterations: int = quantity(
        AnatomyParameters,
        "smoothing_iterations",
        "",
        "mean-curvature steps on the surfaces",
        ge=0,
        le=100,
    )
    skin_thickness_mm: float = quantity(
        AnatomyParameters, "skin_thickness", "mm", "depth of the skin's shell", ge=0.2, le=10
    )

    def parameters(self, seed: int) -> AnatomyParameters:
        """The stage's parameters in SI."""
        return to_parameters(self, AnatomyParameters, seed=seed)
