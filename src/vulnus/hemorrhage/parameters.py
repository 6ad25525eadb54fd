"""What the bleeding simulation needs to know beside the injured limb; frozen, SI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vulnus.core.arrays import Vector3
from vulnus.core.constants import BLOOD_DENSITY, BLOOD_VISCOSITY, STANDARD_GRAVITY

PermeabilityModel = Literal["kozeny_carman", "constant"]
PressureModel = Literal["clamped", "unclamped"]
KernelSet = Literal["wendland_c2", "mueller2003"]
BarrierModel = Literal["damage", "presence"]


@dataclass(frozen=True, kw_only=True, slots=True)
class PlatformParameters:
    """A solid square slab on which blood pools, by default just below the limb.

    `point` [m] is the middle of its upper face and `normal` the unit vector out of that face;
    where they are None the slab lies across gravity, `gap` below the limb's lowest point.
    """

    gap: float = 5e-3
    """Distance of the face below the limb [m]; chosen: the paper says "just above"."""
    half_extent: float = 0.15
    """Half the side of the square [m]; chosen: carries a pool of 100 ml (PHYSICS S22: 0.09 m)."""
    point: Vector3 | None = None
    normal: Vector3 | None = None


@dataclass(frozen=True, kw_only=True, slots=True)
class HemorrhageParameters:
    """Weakly compressible SPH of blood in Brinkman tissue (Chong 2017, §2.3)."""

    particle_spacing: float = 1.5e-3
    """Rest spacing dx of blood particles [m]; one stands for dx³ of blood. Chosen: 3 s of
    bleeding in about a minute; the paper's scale is 0.75-1 mm (PHYSICS §4.6)."""
    smoothing_ratio: float = 2.3
    """Smoothing radius h of the kernels (their cut-off) over dx (PHYSICS §4.1b: 2-2.5); chosen:
    about 50 neighbours, at which a column at rest is calmest."""
    kernels: KernelSet = "wendland_c2"
    """One kernel for all sums, or "mueller2003": the paper's three, whose density and pressure
    kernels do not belong to one energy, so that blood at rest jitters at 0.1 m/s."""
    sound_speed: float = 30.0
    """Numerical speed of sound c0 [m/s]; k = c0² in eq. (7). At least 10 times the largest speed
    and √(p/0.01ρ), 35 m/s at 100 mmHg (PHYSICS §4.1)."""
    density: float = BLOOD_DENSITY
    """Rest density ρ0 of blood [kg/m³]."""
    viscosity: float = BLOOD_VISCOSITY
    """Dynamic viscosity μ of blood [Pa s], Newtonian."""
    gravity: Vector3 = (0.0, 0.0, -STANDARD_GRAVITY)
    """Acceleration of gravity [m/s²], LPS; the default is a leg upright."""

    permeability_model: PermeabilityModel = "kozeny_carman"
    """K from porosity and damage (PHYSICS §4.3), or the paper's one number for all tissue."""
    permeability_constant: float = 5e-7
    """K of all tissue [m²] where the model is "constant" (Chong 2017, §2.3)."""
    porosity_intact: float = 0.12
    """Porosity ε0 of intact tissue, its extracellular share (PHYSICS §4.1: 0.10-0.15)."""
    tissue_cell: float = 0.0
    """Cell of the tissue grid [m]; 0 = the spacing of the limb's material points."""

    source_radius: float = 1.5e-3
    """Radius of the spherical shell on which blood appears [m] (Chong 2017, §2.3)."""
    barrier_model: BarrierModel = "damage"
    """Which skin and bone holds blood back: points damaged less than `barrier_damage`, or (as in
    the paper) all points wherever they are."""
    barrier_damage: float = 0.9
    """Damage from which a point of skin or bone is debris (PHYSICS §1.4)."""
    platform: PlatformParameters | None = None
    """A slab under the limb (the paper's Fig. 6), or None (Fig. 5)."""

    pressure_model: PressureModel = "clamped"
    """Whether eq. (7) may be negative (attraction, the paper's stand-in for surface tension)."""
    as_printed: bool = False
    """Equations (3), (5)-(7) as the paper prints them: its three kernels, ε on the pressure
    gradient, no self term, constant K, pressure unclamped. The signs of (5) and (10) are corrected
    in either case."""
    courant_number: float = 0.25
    """Δt = courant_number · 0.65 h / (c0 + |v|max) (PHYSICS §4.1b)."""
    removal_distance: float = 0.10
    """Blood farther than this from the limb's (and platform's) box [m] is taken out and booked
    as removed; chosen: a drop needs 0.14 s to fall that far."""
    seed: int = 1
    """Seed of the random rotations of the source's directions."""
    threads: int = 0
    """Threads of the native loops; 0 = as many as OpenMP offers. Results do not depend on it."""
