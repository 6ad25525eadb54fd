"""The materials by name, each constant with its source, and the table of the limb's tissues.

Marks as in the project's physics notes: [F] a source that was read, [M] from memory of the named
literature, [D] derived, [chosen] with the reason.

A new material is one more row here; `material_model.Material` says what the fields mean.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import Tissue

from .checked_values import is_a
from .material_model import (
    COLUMNS,
    UNLIMITED,
    Material,
    drucker_prager,
    elastic,
    liquid,
    material_table,
    neo_hookean,
    slowed,
    von_mises,
)

__all__ = [
    "COLUMNS",
    "MATERIALS",
    "TISSUE_MATERIALS",
    "UNLIMITED",
    "Material",
    "drucker_prager",
    "elastic",
    "liquid",
    "material",
    "material_table",
    "neo_hookean",
    "slowed",
    "tissue_table",
    "von_mises",
]

GELATIN_10 = Material(
    name="gelatin_10",  # 10 % by mass at 4 °C, the FBI's
    density=1030.0,  # [M: Wen 2013, Int J Impact Eng]
    bulk_modulus=2.38e9,  # [M: Wen 2013]
    tait_exponent=7.0,  # Tait's law for water [M: Cole 1948]
    volume_averaging=True,
    pressure_cutoff=0.3e6,  # cavitation at 0.1-0.5 MPa [M]
    shear_modulus=3.5e6,  # 3-4 MPa at 4e4 /s [D: cavity expansion, 2.18 MPa of drag of the BB]
    yield_stress=0.03e6,  # with the law of rate 0.14 MPa at 100 /s [D: PHYSICS 1.2, 0.13 MPa] and
    rate_reference=7.0,  # 1/s; 1.9 MPa at 4e4 /s: the depth of M8a. With the 1 MPa of a cavity's
    rate_exponent=0.475,  # expansion a ball goes too deep: when slow it strains at 1e4 /s only
    network_modulus=0.2e6,  # E/3 at low rate, 0.1-0.8 MPa [D: PHYSICS 1.2]
    failure_stretch=1.8,  # failure strain 0.7-0.9 [M: Wen 2013]
    fracture_energy=1.5e3,  # [D: M8a; 10 J/m² at rest [M: Forte 2015], far more for a
    # fast crack [M: Baumberger 2006]]
    softening_stress=1.5e6,  # yield stress at 2.5e4 /s, where a ballistic wound tears [D]
)

GELATIN_20 = replace(
    GELATIN_10,
    name="gelatin_20",  # 20 % by mass at 10 °C, the NATO's
    density=1060.0,  # [chosen: 10 % more gelatin of 1350 kg/m³]
    shear_modulus=8.1e6,  # 2.32 times that of 10 %: drag 5.06 to 2.18 MPa [D: PHYSICS 1.2]
    yield_stress=0.07e6,  # the same ratio [D]
    network_modulus=0.464e6,  # the same ratio [chosen: no data]
    fracture_energy=3.5e3,  # the same ratio [chosen: no data]
    softening_stress=3.5e6,  # the same ratio [D]
)

MUSCLE = Material(
    name="muscle",
    density=1060.0,  # 1040-1090 [M]
    bulk_modulus=2.3e9,  # c = 1.5 km/s [M]
    tait_exponent=7.0,  # Tait's law for water [M: Cole 1948]
    volume_averaging=True,
    pressure_cutoff=0.3e6,  # cavitation at 0.1-0.5 MPa [M]
    shear_modulus=3.5e6,  # as gelatin 10 %, made to behave like it [D]
    yield_stress=0.03e6,  # as gelatin 10 % [D]; 0.14 MPa at 100 /s: 0.1-0.5 MPa in tension [M]
    rate_reference=7.0,  # 1/s, as gelatin 10 % [D]
    rate_exponent=0.475,  # as gelatin 10 % [D]
    network_modulus=0.2e6,  # as gelatin 10 %: E 0.1-0.8 MPa at 100 /s [D: PHYSICS 1.2]
    failure_stretch=1.75,  # failure strain 0.5-1.0 [M], the middle
    fracture_energy=1.0e3,  # 0.3-1 kJ/m² [M]; the most, as gelatin's is more
    softening_stress=1.5e6,  # as gelatin 10 % [D]
)

FAT = Material(
    name="fat",
    density=950.0,  # 920-970 [M]
    bulk_modulus=2.0e9,  # [M]
    tait_exponent=7.0,  # as muscle [chosen: mostly liquid]
    volume_averaging=True,
    pressure_cutoff=0.1e6,  # strength 0.1 MPa [M]
    shear_modulus=0.7e6,  # a fifth of muscle's [chosen: quasi-static E 1-5 kPa to 10-100 kPa [M]]
    yield_stress=0.006e6,  # a fifth of muscle's [chosen: strength 0.1 to 0.1-0.5 MPa [M]]
    rate_reference=7.0,  # 1/s, as muscle [chosen: no data]
    rate_exponent=0.475,  # as muscle [chosen: no data]
    network_modulus=0.04e6,  # a fifth of muscle's [chosen: as the shear modulus]
    failure_stretch=1.8,  # failure strain 0.8 [M]
    fracture_energy=0.2e3,  # a fifth of muscle's [chosen: no data]
    softening_stress=0.3e6,  # a fifth of muscle's [D]
)

SKIN = Material(
    name="skin",
    density=1110.0,  # 1100-1150 [M]
    bulk_modulus=2.2e9,  # [M]
    volume_averaging=True,
    pressure_cutoff=33e6,  # true stress at failure, 21.6 MPa times 1.54 [D]
    network_modulus=5.18e6,  # [D: with the next, the law's one fit to the next three]
    network_stiffening=1.963,  # [D]: 21.6 MPa (nominal) and 3.6 MJ/m³ at a stretch of 1.54
    failure_stretch=1.54,  # 1.54 +- 0.17; 21.6 +- 8.4 MPa; 3.6 +- 1.6 MJ/m³ [F: Ni Annaidh]
    fracture_energy=12e3,  # 2.5-20 kJ/m² [M: Pereira 1997; Yang 2015]
)

ARTERY = Material(
    name="artery",
    density=1080.0,  # 1050-1100 [M]
    bulk_modulus=2.2e9,  # as skin [chosen: wet collagen tissue]
    tait_exponent=7.0,  # as muscle [chosen: a tube full of blood]
    volume_averaging=True,
    pressure_cutoff=0.3e6,  # as muscle [chosen: full of blood]
    network_modulus=0.8e6,  # E 2.4 MPa, 6 at failure; 2-6 MPa [M: Mohan & Melbin 1983]
    network_stiffening=0.94,  # [D]: 1.8 MPa at failure, 1.5-5 MPa [M: Mohan & Melbin 1983]
    failure_stretch=1.56,  # 1.4-1.8 of wall strips [M]
    fracture_energy=1.2e3,  # [chosen: 1.5 times what a cell of 2 mm stores at failure]
)

CORTICAL_BONE = Material(
    name="cortical_bone",
    density=1900.0,  # 1800-2050 [M]
    bulk_modulus=14.2e9,  # E 17 GPa (15 modal, 6-45 [F]), Poisson's ratio 0.3 [M]
    shear_modulus=6.54e9,  # the same
    yield_stress=157.6e6,  # with the friction: 200 MPa in compression, 130 MPa in tension [F, M]
    friction=0.636,  # 3 (200 - 130) / (200 + 130) [D]
    tensile_strength=130e6,  # 120-150 MPa [F, M]
    fracture_energy=3e3,  # 2-6 kJ/m² [M]
    softening_stress=130e6,  # the tensile strength
    opening_damage=1.0,  # what opens is cracked
)

CANCELLOUS_BONE = Material(
    name="cancellous_bone",
    density=1150.0,  # with marrow, 1050-1400 [M]
    bulk_modulus=2.0e9,  # filled with fluid, 1-3 GPa [M]
    shear_modulus=0.2e9,  # E 0.1-1 GPa [M]
    yield_stress=5e6,  # 2-10 MPa [M]
    friction=0.636,  # as cortical bone [chosen: no data]
    tensile_strength=5e6,  # 2-10 MPa [M]
    fracture_energy=0.5e3,  # 0.3-1 kJ/m² [M]
    softening_stress=5e6,  # the yield stress
    opening_damage=1.0,  # what opens is cracked
)

MARROW = Material(
    name="marrow",
    density=980.0,  # [M]
    bulk_modulus=2.0e9,  # [M]
    tait_exponent=7.0,  # as muscle [chosen: mostly liquid]
    volume_averaging=True,
    pressure_cutoff=0.1e6,  # as fat [chosen]
    shear_modulus=0.2e6,  # E about 0 [M]; not 0, so that it flows with a limit [chosen]
    yield_stress=0.002e6,  # strength about 0 [M]
    rate_reference=7.0,  # 1/s, as muscle [chosen: no data]
    rate_exponent=0.475,  # as muscle [chosen: no data]
    damage_start=0.4,  # as fat [chosen: no data]
    fracture_energy=0.07e3,  # as fat, in proportion to the yield stress [chosen]
    softening_stress=0.1e6,  # as fat, in proportion to the yield stress [D]
)

COPPER = replace(
    von_mises(8930.0, 117e9, 0.35, 400e6, 100e6),  # PHYSICS M6 [M: Kamoulakos; Zhu & Cescotto]
    name="copper",
)

MATERIALS: Mapping[str, Material] = MappingProxyType(
    {
        row.name: row
        for row in (
            *(SKIN, FAT, MUSCLE, ARTERY, CORTICAL_BONE, CANCELLOUS_BONE, MARROW),
            *(GELATIN_10, GELATIN_20, COPPER),
        )
    }
)
"""Every material that a case may name."""

TISSUE_MATERIALS: Mapping[Tissue, Material] = {
    Tissue.SKIN: SKIN,
    Tissue.MUSCLE: MUSCLE,
    Tissue.BONE: CORTICAL_BONE,
    Tissue.ARTERY: ARTERY,
    Tissue.FAT: FAT,
    Tissue.MARROW: MARROW,
    Tissue.CANCELLOUS: CANCELLOUS_BONE,
}


def material(name: str) -> Material:
    """The material of that name in `MATERIALS`; `ScenarioError` with the nearest name otherwise."""
    is_a("material", name, str, f"Give one of {', '.join(MATERIALS)}.")
    if name in MATERIALS:
        return MATERIALS[name]
    near = difflib.get_close_matches(name.lower().replace(" ", "_"), MATERIALS, n=1, cutoff=0.5)
    hint = f"Did you mean {near[0]!r}? " if near else ""
    raise ScenarioError(
        "material", f"{name!r} is not known", f"{hint}Known: {', '.join(MATERIALS)}."
    )


def tissue_table(grid_spacing: float, *, bone_modulus_scale: float = 1.0) -> FloatArray:
    """Native material rows (8, 20), indexed by `Tissue` code, for cells of `grid_spacing` [m].

    `bone_modulus_scale` multiplies the elastic moduli of cortical bone (strengths stay). The row of
    AIR, which no particle has, repeats muscle.
    """
    materials = {Tissue.AIR: MUSCLE, **TISSUE_MATERIALS}
    bone = materials[Tissue.BONE]
    materials[Tissue.BONE] = replace(
        bone,
        bulk_modulus=bone.bulk_modulus * bone_modulus_scale,
        shear_modulus=bone.shear_modulus * bone_modulus_scale,
    )
    return material_table([materials[tissue] for tissue in Tissue], grid_spacing)
