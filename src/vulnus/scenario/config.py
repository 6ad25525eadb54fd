"""A whole scenario file as validated tables, before it becomes SI parameters."""

from __future__ import annotations

from .circulation_sections import CirculationSection, CouplingSection
from .hemorrhage_sections import HemorrhageSection
from .injury_sections import InjurySection
from .limb_sections import AnatomySection, ImagingSection
from .quantity import Section, choice
from .visualization_sections import VisualizationSection


class RunSection(Section):
    """[run]: what concerns all stages."""

    seed: int = choice(1, "of everything random; same seed, same bits", ge=0, lt=2**31)
    threads: int = choice(
        0, "of the native loops; 0: all. The result does not depend on it", ge=0, le=1024
    )
    checkpoint_interval_s: float = choice(
        20.0, "wall time between two checkpoints of a long stage", unit="s", ge=0, le=3600
    )


class ScenarioConfig(Section):
    """A scenario file."""

    title: str = choice("A shot through the lower leg", "free text, shown on the pictures")
    run: RunSection = RunSection()
    imaging: ImagingSection = ImagingSection()
    anatomy: AnatomySection = AnatomySection()
    injury: InjurySection = InjurySection()
    circulation: CirculationSection = CirculationSection()
    hemorrhage: HemorrhageSection = HemorrhageSection()
    coupling: CouplingSection = CouplingSection()
    visualization: VisualizationSection = VisualizationSection()
