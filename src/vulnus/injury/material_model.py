"""What a material is: its laws' constants, checked, and the row that the native solver reads."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError

from .checked_values import (
    finite,
    is_a,
    not_a_number,
    not_negative,
    positive,
    true_or_false,
)

UNLIMITED = 1e30
"""A strength, a stretch or an energy that is never reached."""

COLUMNS = (
    "density",
    "bulk_modulus",
    "shear_modulus",
    "volume_exponent",
    "volume_growth",
    "volume_averaging",
    "yield_stress",
    "hardening",
    "friction",
    "rate_reference",
    "rate_exponent",
    "damage_start",
    "damage_slope",
    "pressure_cutoff",
    "tensile_strength",
    "opening_damage",
    "network_modulus",
    "network_stiffening",
    "break_start",
    "break_slope",
)
"""Columns of the native table, in the order of `MaterialColumn` in material.hpp."""

FLAGS = ("quadratic_volume", "volume_averaging")
"""Fields of `Material` that are True or False."""

CAPACITY = 16
"""Rows that a native table holds (material.hpp)."""

CRACK_BAND = 2.0
"""Cells over which a crack softens: the gradient of a step in quadratic splines is a hat two cells
wide [D]; bars pulled apart then spend the fracture energy within 15 % (test_injury_fracture.py)."""

SNAP_BACK = 1.1
"""Least span of softening over the yield strain; chosen: a cell snaps back below 1."""

LOCKING_RATIO = 5.0
"""Bulk over shear modulus (Poisson's ratio 0.41) from which the constructors average the volume
rate; chosen: below it locking is a matter of per cent."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """One material as the sum of three parts; SI.

    *Pressure*: K ln J, or Tait's law where `tait_exponent` is not 0, or (K/2)(J² - 1) where
    `quadratic_volume`; its tension ends at `pressure_cutoff`. `volume_averaging` averages the
    volume rate over a cell, so that a nearly incompressible material does not lock.

    *Elasto-plastic part*: Hencky-elastic in shear with `shear_modulus`; flows at q = (yield_stress
    + hardening alpha) [1 + (rate/rate_reference)^rate_exponent] (1 - D) + friction p, and its
    largest principal stress is at most `tensile_strength` (1 - D).

    *Network*: remembers the whole deformation (Demiray 1972), stress network_modulus
    exp(network_stiffening (I - 3)) dev(b) (1 - D), breaks from the uniaxial stretch
    `failure_stretch` on.

    Damage D: a network that can fail breaks over a span that spends `fracture_energy` [J/m²] over
    one cell (`softening_stress` is what the elasto-plastic part carries beside it). Without one D
    grows from 0 at the plastic strain `damage_start` to 1 after a span that spends the energy at
    `softening_stress`; `opening_damage` of the strain of cracks and voids counts as plastic.
    """

    name: str = "material"
    density: float
    bulk_modulus: float
    shear_modulus: float = 0.0
    tait_exponent: float = 0.0
    quadratic_volume: bool = False
    volume_averaging: bool = False
    pressure_cutoff: float = UNLIMITED
    yield_stress: float = UNLIMITED
    hardening: float = 0.0
    friction: float = 0.0
    rate_reference: float = 0.0
    rate_exponent: float = 1.0
    tensile_strength: float = UNLIMITED
    network_modulus: float = 0.0
    network_stiffening: float = 0.0
    failure_stretch: float = UNLIMITED
    fracture_energy: float = UNLIMITED
    softening_stress: float = 0.0
    damage_start: float = 0.0
    opening_damage: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "name":
                is_a("material name", value, str, "Give a text.")
            elif field.name in FLAGS:
                true_or_false(f"{self.name}.{field.name}", value)
            elif not_a_number(value) or value < 0.0:
                self._refuse(field.name, f"is {value!r}, must be a number >= 0")
        for key in ("density", "bulk_modulus", "pressure_cutoff", "fracture_energy"):
            if not getattr(self, key) > 0.0:
                self._refuse(key, "is 0, must be > 0")
        if not self.failure_stretch > 1.0:
            self._refuse("failure_stretch", f"is {self.failure_stretch}, must be > 1")
        if self.shear_modulus == 0.0 and self.tensile_strength < UNLIMITED:
            self._refuse("tensile_strength", "limits a material whose shear_modulus is 0")
        if self.failure_stretch < UNLIMITED and self.network_modulus == 0.0:
            self._refuse("failure_stretch", "is that of a network, but network_modulus is 0")
        if self.quadratic_volume and self.tait_exponent > 0.0:
            self._refuse("quadratic_volume", "is set and so is tait_exponent: one law, not two")

    def _refuse(self, key: str, problem: str) -> None:
        raise ScenarioError(
            f"{self.name}.{key}", problem, "Give the constants in SI units; see Material's fields."
        )

    @property
    def sound_speed(self) -> float:
        """Speed of longitudinal waves at rest sqrt((K + 4G/3)/rho) [m/s]."""
        shear = self.shear_modulus + self.network_modulus
        return math.sqrt((self.bulk_modulus + 4.0 / 3.0 * shear) / self.density)

    @property
    def breaks(self) -> bool:
        """Whether the network can fail."""
        return self.failure_stretch < UNLIMITED

    @property
    def failure_strain(self) -> float:
        """Equivalent strain sqrt((I - 3)/3) of the network at `failure_stretch`, I = s² + 2/s."""
        if not self.breaks:
            return UNLIMITED
        stretch = self.failure_stretch
        return math.sqrt((stretch**2 + 2.0 / stretch - 3.0) / 3.0)

    @property
    def failure_work(self) -> float:
        """Energy [J/m³] of the network at failure, mu/(2 beta) (exp(beta (I - 3)) - 1)."""
        excess = 3.0 * self.failure_strain**2
        if self.network_stiffening * excess < 1e-9:
            return 0.5 * self.network_modulus * excess
        scale = 0.5 * self.network_modulus / self.network_stiffening
        return scale * math.expm1(self.network_stiffening * excess)

    def break_span(self, grid_spacing: float) -> float:
        """Equivalent strain from the network's failure to its end.

        Crack-band regularisation (Bazant & Oh 1983 [M]): what a crack's cells have stored at
        failure and what the falling stress still takes make up the fracture energy, G_f = band
        (W_0 + s span/2), with s the network's equivalent stress 3 mu_0 e_0 at failure and
        `softening_stress`, and the band `CRACK_BAND` cells. Where coarse cells have stored more
        than that, the span is a twentieth of the failure strain
        (chosen: a fall over some time steps; the crack then costs more than G_f).
        """
        strain = self.failure_strain
        stiffened = math.exp(self.network_stiffening * 3.0 * strain**2)
        stress = 3.0 * self.network_modulus * stiffened * strain + self.softening_stress
        band = CRACK_BAND * grid_spacing
        span = 2.0 * (self.fracture_energy / band - self.failure_work) / stress
        return max(span, 0.05 * strain)

    def damage_span(self, grid_spacing: float) -> float:
        """Plastic strain over which the strength goes to zero, 2 G_f / (stress * band).

        Crack-band regularisation: the energy per crack area does not depend on the cell; the band
        is `CRACK_BAND` cells. Where the span is less than the yield strain a cell snaps back, so it
        stops 10 % above that (the crack then costs more energy than `fracture_energy`).
        """
        limits = [s for s in (self.yield_stress, self.tensile_strength) if s < UNLIMITED]
        stress = self.softening_stress or min(limits, default=UNLIMITED)
        span = 2.0 * self.fracture_energy / (stress * CRACK_BAND * grid_spacing)
        if self.shear_modulus == 0.0 or not limits:
            return span
        return max(span, SNAP_BACK * max(limits) / (3.0 * self.shear_modulus))

    def row(self, grid_spacing: float) -> list[float]:
        """The native table's row for a cell of `grid_spacing` [m]."""
        values = {
            "volume_exponent": 2.0 if self.quadratic_volume else self.tait_exponent,
            "volume_growth": 2.0 if self.quadratic_volume else float(self.tait_exponent > 0.0),
            "damage_slope": 0.0 if self.breaks else 1.0 / self.damage_span(grid_spacing),
            "break_start": self.failure_strain,
            "break_slope": 1.0 / self.break_span(grid_spacing) if self.breaks else 0.0,
        }
        return [
            float(min(values[name] if name in values else getattr(self, name), UNLIMITED))
            for name in COLUMNS
        ]


def material_table(materials: Sequence[Material], grid_spacing: float) -> FloatArray:
    """Native rows (n, 20) of these materials for cells of `grid_spacing` [m]; at most 16."""
    if not 1 <= len(materials) <= CAPACITY:
        raise ScenarioError(
            "materials", f"are {len(materials)}, must be 1 to {CAPACITY}", "Share rows."
        )
    return np.array([material.row(grid_spacing) for material in materials], dtype=np.float64)


def slowed(table: FloatArray, sound_speed: float) -> FloatArray:
    """Rows with lower moduli, so that longitudinal waves at rest keep below `sound_speed` [m/s].

    Nearly incompressible rows (K > 10 G) lose bulk modulus only, down to 2 G at most, so that what
    resists and recoils stays true; the others (bone) lose bulk and shear modulus alike. Networks,
    yield stresses and strengths stay.
    """
    positive("sound_speed", sound_speed)
    new = table.copy()
    density, bulk, shear, network = (
        table[:, COLUMNS.index(name)]
        for name in ("density", "bulk_modulus", "shear_modulus", "network_modulus")
    )
    budget = density * sound_speed**2
    total = shear + network
    soft = bulk > 10.0 * total
    factor = np.minimum(1.0, budget / (bulk + 4.0 / 3.0 * total))
    lowered = np.clip(budget - 4.0 / 3.0 * total, np.minimum(2.0 * total, bulk), bulk)
    new[:, COLUMNS.index("bulk_modulus")] = np.where(soft, lowered, factor * bulk)
    new[:, COLUMNS.index("shear_modulus")] = np.where(soft, shear, factor * shear)
    _without_snap_back(new)
    return new


def _without_snap_back(table: FloatArray) -> None:
    """Rows whose moduli were lowered soften over the yield strain that they have now at least."""
    shear, slope, *strengths = (
        table[:, COLUMNS.index(name)]
        for name in ("shear_modulus", "damage_slope", "yield_stress", "tensile_strength")
    )
    limits = [np.where(strength < UNLIMITED, strength, 0.0) for strength in strengths]
    largest = np.max(limits, axis=0)
    steepest = np.divide(
        3.0 * shear, SNAP_BACK * largest, out=slope.copy(), where=(shear > 0.0) & (largest > 0.0)
    )
    table[:, COLUMNS.index("damage_slope")] = np.minimum(slope, steepest)


def elastic(density: float, youngs_modulus: float, poisson_ratio: float) -> Material:
    """A Hencky-elastic solid of any strength: stress from the logarithmic strain."""
    bulk, shear = _moduli(youngs_modulus, poisson_ratio)
    return Material(
        name="elastic",
        density=density,
        bulk_modulus=bulk,
        shear_modulus=shear,
        volume_averaging=bulk > LOCKING_RATIO * shear,
    )


def neo_hookean(density: float, shear_modulus: float, bulk_modulus: float) -> Material:
    """Tau = mu J^(-2/3) dev(b) + (K/2)(J² - 1) I (PHYSICS 1.4), of any strength."""
    positive("shear_modulus", shear_modulus)
    positive("bulk_modulus", bulk_modulus)
    return Material(
        name="neo-Hookean",
        density=density,
        bulk_modulus=bulk_modulus,
        network_modulus=shear_modulus,
        quadratic_volume=True,
        volume_averaging=bulk_modulus > LOCKING_RATIO * shear_modulus,
    )


def von_mises(
    density: float,
    youngs_modulus: float,
    poisson_ratio: float,
    yield_stress: float,
    hardening: float = 0.0,
) -> Material:
    """A metal: Hencky-elastic, flows at yield_stress + hardening times the plastic strain."""
    bulk, shear = _moduli(youngs_modulus, poisson_ratio)
    return Material(
        name="von Mises",
        density=density,
        bulk_modulus=bulk,
        shear_modulus=shear,
        yield_stress=yield_stress,
        hardening=hardening,
        volume_averaging=True,
    )


def drucker_prager(
    density: float,
    youngs_modulus: float,
    poisson_ratio: float,
    yield_stress: float,
    friction: float,
) -> Material:
    """Rock or grain: flows at q = yield_stress + friction times the pressure.

    Tension ends at the tip of that cone, yield_stress / friction, where the material opens.
    """
    bulk, shear = _moduli(youngs_modulus, poisson_ratio)
    not_negative("yield_stress", yield_stress)
    not_negative("friction", friction)
    return Material(
        name="Drucker-Prager",
        density=density,
        bulk_modulus=bulk,
        shear_modulus=shear,
        yield_stress=yield_stress,
        friction=friction,
        pressure_cutoff=yield_stress / friction if yield_stress > 0.0 < friction else UNLIMITED,
    )


def liquid(density: float, bulk_modulus: float, cavitation_pressure: float = 0.0) -> Material:
    """A liquid without viscosity: Tait's law (exponent 7), torn by the tension given (0: never)."""
    return Material(
        name="liquid",
        density=density,
        bulk_modulus=bulk_modulus,
        tait_exponent=7.0,
        pressure_cutoff=not_negative("cavitation_pressure", cavitation_pressure) or UNLIMITED,
    )


def _moduli(youngs_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Bulk and shear modulus [Pa]."""
    positive("youngs_modulus", youngs_modulus)
    if not -1.0 < finite("poisson_ratio", poisson_ratio) < 0.5:
        raise ScenarioError(
            "poisson_ratio",
            f"is {poisson_ratio}, must be > -1 and < 0.5",
            "Use 0.4999 for what hardly changes its volume, with volume_averaging.",
        )
    bulk = youngs_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
    return bulk, youngs_modulus / (2.0 * (1.0 + poisson_ratio))
