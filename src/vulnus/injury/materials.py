"""Material constants of the tissues, each with its source, and the table that the solver reads.

Marks as in the project's physics notes: [F] a source that was read, [M] from memory of the named
literature, [D] derived, [chosen] with the reason.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.handoff import Tissue

UNLIMITED = 1e30
"""A strength that is never reached [Pa]."""

COLUMNS = (
    "density",
    "bulk_modulus",
    "shear_modulus",
    "tait_exponent",
    "yield_stress",
    "friction",
    "rate_reference",
    "rate_exponent",
    "damage_start",
    "damage_end",
    "pressure_cutoff",
    "tensile_strength",
    "opening_damage",
)
"""Columns of the native table, in the order of `MaterialColumn` in material.hpp."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """One elasto-plastic material; SI.

    Stress is Hencky-elastic in shear; the pressure is K ln J, or Tait's law where `tait_exponent`
    is not 0. Shear flows at q = yield_stress [1 + (rate/rate_reference)^rate_exponent] (1 - D) +
    friction p. Damage D grows from 0 at the plastic strain `damage_start` to 1 after a span that
    spends `fracture_energy` [J/m²] over one cell at the stress `softening_stress`.
    """

    density: float
    bulk_modulus: float
    shear_modulus: float
    tait_exponent: float = 0.0
    yield_stress: float = UNLIMITED
    friction: float = 0.0
    rate_reference: float = 0.0
    rate_exponent: float = 1.0
    damage_start: float = 0.0
    fracture_energy: float = UNLIMITED
    softening_stress: float = 1.0
    pressure_cutoff: float = UNLIMITED
    tensile_strength: float = UNLIMITED
    opening_damage: float = 0.0

    @property
    def sound_speed(self) -> float:
        """Speed of longitudinal waves sqrt((K + 4G/3)/rho) [m/s]."""
        modulus = self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus
        return float(np.sqrt(modulus / self.density))

    def damage_span(self, grid_spacing: float) -> float:
        """Plastic strain over which the strength goes to zero, 2 G_f / (stress * cell).

        Crack-band regularisation (Bazant & Oh 1983 [M]): the energy per crack area does not depend
        on the cell. Where the span is less than the yield strain a cell snaps back, so it stops
        10 % above that (the crack then costs more energy than `fracture_energy`). With the elastic
        strain gone at the end, exp(span) is the stretch at failure.
        """
        span = 2.0 * self.fracture_energy / (self.softening_stress * grid_spacing)
        strength = self.yield_stress if self.yield_stress < UNLIMITED else self.softening_stress
        return max(span, 1.1 * strength / (3.0 * self.shear_modulus))

    def row(self, grid_spacing: float) -> list[float]:
        """The native table's row for a cell of `grid_spacing` [m]."""
        values = {name: getattr(self, name) for name in COLUMNS if name != "damage_end"}
        values["damage_end"] = self.damage_start + self.damage_span(grid_spacing)
        return [float(min(values[name], UNLIMITED)) for name in COLUMNS]


MUSCLE = Material(
    density=1060.0,  # 1040-1090 [M]
    bulk_modulus=2.3e9,  # c = 1.5 km/s [M]
    shear_modulus=3.5e6,  # 3-4 MPa at 4e4 /s [D: cavity-expansion fit to the BB in 10 % gel]
    tait_exponent=7.0,  # Tait's law for water [M: Cole 1948]
    yield_stress=0.15e6,  # at rest [D: same fit]
    rate_reference=3e2,  # 1/s [D: same fit]
    rate_exponent=0.36,  # about 1 MPa at 4e4 /s [D: same fit]
    damage_start=0.4,  # [chosen: half of the failure strain 0.5-1.0 [M]]
    fracture_energy=0.6e3,  # 0.3-1 kJ/m² [M]
    softening_stress=1.0e6,  # yield stress at 4e4 /s, where a ballistic wound tears [D]
    pressure_cutoff=0.3e6,  # cavitation at 0.1-0.5 MPa [M]
)

FAT = Material(
    density=950.0,  # 920-970 [M]
    bulk_modulus=2.0e9,  # [M]
    shear_modulus=0.7e6,  # a fifth of muscle's [chosen: quasi-static E 1-5 kPa to 10-100 kPa [M]]
    tait_exponent=7.0,  # as muscle [chosen: mostly liquid]
    yield_stress=0.03e6,  # a fifth of muscle's [chosen: strength 0.1 to 0.1-0.5 MPa [M]]
    rate_reference=3e2,  # as muscle [chosen: no data]
    rate_exponent=0.36,  # as muscle [chosen: no data]
    damage_start=0.4,  # half of the failure strain 0.8 [M]
    fracture_energy=0.12e3,  # a fifth of muscle's [chosen: no data]
    softening_stress=0.2e6,  # yield stress at 4e4 /s [D]
    pressure_cutoff=0.1e6,  # strength 0.1 MPa [M]
)

SKIN = Material(
    density=1110.0,  # 1100-1150 [M]
    bulk_modulus=2.2e9,  # [M]
    shear_modulus=27.7e6,  # E/3 of 83 MPa, the linear part [F: Ni Annaidh, arXiv 1302.3022]
    yield_stress=21.6e6,  # tensile strength 21.6 +- 8.4 MPa [F: Ni Annaidh]
    fracture_energy=12e3,  # 2.5-20 kJ/m² [M: Pereira 1997; Yang 2015]; the stretch at failure is
    # then 1.45 on cells of 3 mm and 1.74 on 2 mm, against 1.54 +- 0.17 measured [F]
    softening_stress=21.6e6,  # the yield stress
    pressure_cutoff=21.6e6,  # the tensile strength
    opening_damage=1.0,  # what opens is torn
)

ARTERY = Material(
    density=1080.0,  # 1050-1100 [M]
    bulk_modulus=2.2e9,  # as skin [chosen: wet collagen tissue]
    shear_modulus=2.0e6,  # E 2-6 MPa at high stretch [M: Mohan & Melbin 1983]
    tait_exponent=7.0,  # as muscle [chosen: a tube full of blood]
    yield_stress=1.8e6,  # strength 1.5-5 MPa [M: Mohan & Melbin 1983]
    fracture_energy=1.2e3,  # [chosen: stretch at failure 1.56 on cells of 3 mm, between the
    # 1.4-1.8 of wall strips [M]]
    softening_stress=1.8e6,  # the yield stress
    pressure_cutoff=0.3e6,  # as muscle [chosen: full of blood]
)

CORTICAL_BONE = Material(
    density=1900.0,  # 1800-2050 [M]
    bulk_modulus=14.2e9,  # E 17 GPa (15 modal, 6-45 [F]), Poisson's ratio 0.3 [M]
    shear_modulus=6.54e9,  # the same
    yield_stress=157.6e6,  # with the friction: 200 MPa in compression, 130 MPa in tension [F, M]
    friction=0.636,  # 3 (200 - 130) / (200 + 130) [D]
    fracture_energy=3e3,  # 2-6 kJ/m² [M]
    softening_stress=130e6,  # the tensile strength
    tensile_strength=130e6,  # 120-150 MPa [F, M]
    opening_damage=1.0,  # what opens is cracked
)

CANCELLOUS_BONE = Material(
    density=1150.0,  # with marrow, 1050-1400 [M]
    bulk_modulus=2.0e9,  # filled with fluid, 1-3 GPa [M]
    shear_modulus=0.2e9,  # E 0.1-1 GPa [M]
    yield_stress=5e6,  # 2-10 MPa [M]
    friction=0.636,  # as cortical bone [chosen: no data]
    fracture_energy=0.5e3,  # 0.3-1 kJ/m² [M]
    softening_stress=5e6,  # the yield stress
    tensile_strength=5e6,  # 2-10 MPa [M]
    opening_damage=1.0,  # what opens is cracked
)

MARROW = Material(
    density=980.0,  # [M]
    bulk_modulus=2.0e9,  # [M]
    shear_modulus=0.2e6,  # E about 0 [M]; not 0, so that it flows with a limit [chosen]
    tait_exponent=7.0,  # as muscle [chosen: mostly liquid]
    yield_stress=0.01e6,  # strength about 0 [M]
    rate_reference=3e2,  # as muscle [chosen: no data]
    rate_exponent=0.36,  # as muscle [chosen: no data]
    damage_start=0.4,  # as fat [chosen: no data]
    fracture_energy=0.04e3,  # as fat, in proportion to the yield stress [chosen]
    softening_stress=0.07e6,  # yield stress at 4e4 /s [D]
    pressure_cutoff=0.1e6,  # as fat [chosen]
)

TISSUE_MATERIALS: Mapping[Tissue, Material] = {
    Tissue.SKIN: SKIN,
    Tissue.MUSCLE: MUSCLE,
    Tissue.BONE: CORTICAL_BONE,
    Tissue.ARTERY: ARTERY,
    Tissue.FAT: FAT,
    Tissue.MARROW: MARROW,
    Tissue.CANCELLOUS: CANCELLOUS_BONE,
}


def tissue_table(grid_spacing: float, *, bone_modulus_scale: float = 1.0) -> FloatArray:
    """Native material rows (8, 13), indexed by `Tissue` code, for cells of `grid_spacing` [m].

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


def material_table(materials: list[Material], grid_spacing: float) -> FloatArray:
    """Native rows (n, 13) of these materials for cells of `grid_spacing` [m]; at most 16."""
    return np.array([material.row(grid_spacing) for material in materials], dtype=np.float64)


def damage_from_plastic_strain(
    table: FloatArray, material: np.ndarray, plastic_strain: FloatArray
) -> FloatArray:
    """Damage (n,) 0-1 of points with these rows of `table` and plastic strains (damage.hpp)."""
    start = table[material, COLUMNS.index("damage_start")]
    end = table[material, COLUMNS.index("damage_end")]
    damage: FloatArray = np.clip((plastic_strain - start) / (end - start), 0.0, 1.0)
    return damage
