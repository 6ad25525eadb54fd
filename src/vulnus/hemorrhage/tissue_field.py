"""Porosity and permeability of the injured limb on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, Float32Array
from vulnus.core.handoff import InjuredLimb

from . import _native
from .distance_grid import NodeGrid
from .parameters import HemorrhageParameters

SMOOTHING_REACH = 2.0
"""Radius of the kernel that measures tissue density over the material points' spacing; chosen:
about 24 points in it."""

OPEN_FRACTION = 0.2
"""Share of tissue below which a place is open (tract, air); chosen."""

REFERENCE_FLOOR = 0.8
"""Density before the injury, over that of bulk tissue, that is taken as the least; chosen: beyond
it lies the limb's surface, where the kernel reaches into air."""


@dataclass(frozen=True, slots=True, eq=False)
class TissueGrid:
    """Porosity (nx, ny, nz) and logarithm of the drag rate εμ/(ρK) [1/s] on nodes.

    Open nodes have porosity 1 and the native solver's mark for free blood.
    """

    grid: NodeGrid
    porosity: Float32Array
    log_drag_rate: Float32Array


def grain_diameters(damage: Float32Array) -> Float32Array:
    """Grain diameter [m] of Kozeny-Carman by damage, from the native law's table points."""
    samples = np.linspace(0.0, 1.0, 201)
    table = np.array([_native.grain_diameter(float(d)) for d in samples])
    return np.asarray(np.exp(np.interp(damage, samples, np.log(table))), dtype=np.float32)


def porosity_from_density(density_ratio: AnyArray, porosity_intact: float) -> Float32Array:
    """ε = 1 - (1 - ε0) ρ_t/ρ_t0 from how much tissue is left, within [0.05, 1] (PHYSICS §4.1)."""
    solid = np.float32(1.0) - np.float32(porosity_intact)
    return np.asarray(np.clip(1.0 - solid * density_ratio, 0.05, 1.0), dtype=np.float32)


def permeability_kozeny_carman(
    porosity: Float32Array, grain_diameter: Float32Array
) -> Float32Array:
    """K = d²ε³ / (150 (1 - ε)²) [m²] (PHYSICS §4.3)."""
    solid = np.maximum(1.0 - porosity, 1e-3)
    return np.asarray(grain_diameter**2 * porosity**3 / (150.0 * solid**2), dtype=np.float32)


def build_tissue(wound: InjuredLimb, parameters: HemorrhageParameters) -> TissueGrid:
    """What blood meets in the injured limb.

    ε = 1 - (1 - ε0) ρ_t/ρ_t0 from the material points' density now and before, within [0.05, 1];
    K by Kozeny-Carman from ε and the damage, or the paper's constant.
    """
    spacing = wound.spacing
    cell = parameters.tissue_cell if parameters.tissue_cell > 0.0 else spacing
    lower = np.minimum(wound.reference_position.min(axis=0), wound.position.min(axis=0))
    upper = np.maximum(wound.reference_position.max(axis=0), wound.position.max(axis=0))
    reach = SMOOTHING_REACH * spacing
    # Debris far outside the limb is not worth a grid.
    lower = np.maximum(lower, wound.reference_position.min(axis=0) - 20.0 * spacing)
    upper = np.minimum(upper, wound.reference_position.max(axis=0) + 20.0 * spacing)
    grid = NodeGrid.around(lower, upper, cell, reach)
    where = (grid.corner, grid.cell, grid.shape, reach)
    now, damage = _native.tissue_fraction(wound.position, wound.volume, wound.damage, *where)
    before, _ = _native.tissue_fraction(
        wound.reference_position, wound.volume, wound.damage, *where
    )
    ratio = now / np.maximum(before, np.float32(REFERENCE_FLOOR))
    porosity = porosity_from_density(ratio, parameters.porosity_intact)
    if parameters.permeability_model == "constant" or parameters.as_printed:
        permeability = np.full_like(porosity, parameters.permeability_constant)
    else:
        permeability = permeability_kozeny_carman(porosity, grain_diameters(damage))
    kinematic = parameters.viscosity / parameters.density
    log_rate = np.log(porosity * np.float32(kinematic) / permeability)
    is_open = ratio < OPEN_FRACTION
    porosity[is_open] = 1.0
    log_rate[is_open] = _native.FREE_LOG_RATE
    return TissueGrid(grid, porosity, np.ascontiguousarray(log_rate, dtype=np.float32))
