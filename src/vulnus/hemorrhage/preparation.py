"""From an injured limb to a solver ready to bleed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.errors import AnatomyError
from vulnus.core.handoff import InjuredLimb
from vulnus.core.progress import Progress, SilentProgress
from vulnus.core.units import MILLIMETRE

from .barriers import LimbBarriers, Platform, build_barriers, place_platform
from .bleeding import BleedingSolver
from .fluid import FluidParameters
from .openings import skin_openings, sparse_skin_area
from .parameters import HemorrhageParameters
from .tissue_field import TissueGrid, build_tissue

SOURCE_SHIFT_LIMIT = 10e-3
"""How far the source may be moved out of a wall [m]; chosen: about the projectile's size."""

WALL_DRAG_RATE = 3e4
"""Drag rate of tissue with K = 1e-11 m² and ε = 0.1 [1/s]: from there it is a wall (PHYSICS §4.3);
the native source uses the same number."""


def fluid_parameters(parameters: HemorrhageParameters) -> FluidParameters:
    """The fluid's share of the bleeding's parameters."""
    return FluidParameters(
        particle_spacing=parameters.particle_spacing,
        smoothing_ratio=parameters.smoothing_ratio,
        sound_speed=parameters.sound_speed,
        kernels=parameters.kernels,
        density=parameters.density,
        viscosity=parameters.viscosity,
        courant_number=parameters.courant_number,
        pressure_clamped=parameters.pressure_model == "clamped",
        as_printed=parameters.as_printed,
    )


def shell_points(center: FloatArray, radii: FloatArray, count: int = 200) -> FloatArray:
    """Points (len(radii) * count, 3) [m] spread evenly over spheres (Fibonacci)."""
    k = np.arange(count) + 0.5
    z = 1.0 - 2.0 * k / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * k
    s = np.sqrt(1.0 - z * z)
    directions = np.stack([s * np.cos(turn), s * np.sin(turn), z], axis=1)
    return np.asarray(center + (radii[:, np.newaxis, np.newaxis] * directions).reshape(-1, 3))


def open_share(center: FloatArray, barriers: LimbBarriers, radius: float, gap: float) -> float:
    """Share of the source's shell that lies at least `gap` [m] away from walls."""
    clearance, _ = barriers.grid.sample(barriers.barrier, shell_points(center, np.array([radius])))
    return float(np.mean(clearance > gap))


def admissible_center(
    wanted: Vector3, barriers: LimbBarriers, parameters: HemorrhageParameters
) -> FloatArray:
    """The wound's centre, moved to the nearest place with half its shell free of walls [m].

    Raises AnatomyError where the place lies outside the limb or no free place is near.
    """
    center = np.array(wanted, dtype=np.float64)
    place = ", ".join(f"{c / MILLIMETRE:.1f}" for c in center)
    outside, _ = barriers.grid.sample(barriers.limb, center)
    if outside[0] > parameters.source_radius:
        raise AnatomyError(
            "wound's position",
            f"({place}) mm lies {outside[0] / MILLIMETRE:.1f} mm outside the limb",
            "Check the artery's centre-line against the labels.",
        )
    radius, gap = parameters.source_radius, 0.4 * parameters.particle_spacing
    steps = np.arange(0.0, SOURCE_SHIFT_LIMIT + 1e-9, 0.5e-3)
    for shift in steps:
        candidates = center[np.newaxis] if shift == 0.0 else shell_points(center, np.array([shift]))
        shares = [open_share(c, barriers, radius, gap) for c in candidates]
        best = int(np.argmax(shares))
        if shares[best] >= 0.5:
            return np.asarray(candidates[best])
    raise AnatomyError(
        "wound's position",
        f"({place}) mm lies in bone or skin, and so does all within "
        f"{SOURCE_SHIFT_LIMIT / MILLIMETRE:.0f} mm",
        "Check the artery's centre-line against the bone's label, or lower source_radius_mm.",
    )


def sensor_volume(
    center: FloatArray, barriers: LimbBarriers, tissue: TissueGrid, parameters: HemorrhageParameters
) -> float:
    """Volume [m³] of the shell R..R+h around the source that blood can fill, at least a tenth."""
    inner = parameters.source_radius
    outer = inner + parameters.smoothing_ratio * parameters.particle_spacing
    points = shell_points(center, np.linspace(inner, outer, 7)[1::2])
    clearance, _ = barriers.grid.sample(barriers.barrier, points)
    nodes = np.rint((points - tissue.grid.origin) / tissue.grid.cell).astype(int)
    nodes = np.clip(nodes, 0, np.array(tissue.grid.shape) - 1)
    tight = tissue.log_drag_rate[tuple(nodes.T)] > np.log(WALL_DRAG_RATE)
    share = max(0.1, float(np.mean((clearance > 0.0) & ~tight)))
    return share * 4.0 / 3.0 * np.pi * (outer**3 - inner**3)


def domain(
    barriers: LimbBarriers, platform: Platform | None, margin: float
) -> tuple[FloatArray, FloatArray]:
    """Corners [m] of the box beyond which blood is taken out."""
    grid = barriers.grid
    lower = grid.origin.copy()
    upper = grid.origin + grid.cell * (np.array(grid.shape) - 1)
    if platform is not None:
        lower = np.minimum(lower, platform.corners().min(axis=0))
        upper = np.maximum(upper, platform.corners().max(axis=0))
    return lower - margin, upper + margin


def _triple(vector: AnyArray) -> Vector3:
    return (float(vector[0]), float(vector[1]), float(vector[2]))


def prepare(
    wound: InjuredLimb,
    parameters: HemorrhageParameters,
    progress: Progress | None = None,
) -> BleedingSolver:
    """A solver for the bleeding of the limb's worst arterial injury, before the first drop.

    Raises AnatomyError where no artery is cut or its place cannot be a source.
    """
    shown = progress if progress is not None else SilentProgress()
    if not wound.injuries:
        raise AnatomyError(
            "wound",
            "no artery is cut, so nothing bleeds",
            "Aim at an artery: [injury.aim] artery and fraction.",
        )
    shown.begin("hemorrhage: barriers and tissue", 3.0, "parts")
    barriers = build_barriers(wound, parameters)
    shown.update(1.0, f"{len(barriers.particles)} barrier particles")
    tissue = build_tissue(wound, parameters)
    shown.update(2.0, f"{tissue.grid.node_count} tissue nodes")
    center = admissible_center(wound.injuries[0].position, barriers, parameters)
    solver = BleedingSolver(
        fluid_parameters(parameters),
        origin=_triple(center),
        gravity=parameters.gravity,
        threads=parameters.threads,
    )
    _furnish(solver, wound, parameters, barriers, tissue)
    solver.openings = replace(
        skin_openings(barriers, parameters.particle_spacing),
        sparse_area=sparse_skin_area(wound, barriers),
    )
    shown.update(3.0)
    shown.end()
    return solver


def _furnish(
    solver: BleedingSolver,
    wound: InjuredLimb,
    parameters: HemorrhageParameters,
    barriers: LimbBarriers,
    tissue: TissueGrid,
) -> None:
    native, center = solver.native, solver.origin
    platform = None
    particles = [barriers.particles]
    dx = parameters.particle_spacing
    if parameters.platform is not None:
        thickness = (np.ceil(parameters.smoothing_ratio) + 0.1) * dx
        platform = place_platform(
            parameters.platform, wound.reference_position, parameters.gravity, float(thickness)
        )
        particles.append(platform.particles(dx))
        native.set_platform(
            _triple(np.array(platform.point) - center),
            platform.normal,
            platform.along,
            platform.across,
            platform.half_extent,
            platform.thickness,
        )
    native.set_barrier(solver.local(np.concatenate(particles)))
    corner = _triple(barriers.grid.origin - center)
    native.set_barrier_distance(corner, barriers.grid.cell, barriers.barrier)
    native.set_limb_distance(corner, barriers.grid.cell, barriers.limb)
    tissue_corner = _triple(tissue.grid.origin - center)
    native.set_tissue(tissue_corner, tissue.grid.cell, tissue.porosity, tissue.log_drag_rate)
    volume = sensor_volume(center, barriers, tissue, parameters)
    native.set_source((0.0, 0.0, 0.0), parameters.source_radius, volume, parameters.seed)
    lower, upper = domain(barriers, platform, parameters.removal_distance)
    native.set_domain(_triple(lower - center), _triple(upper - center))
