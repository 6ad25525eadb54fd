"""An experiment at its first step: checked, placed, and put into the solver."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3

from ..bodies.flight import Flight, refuse_start_inside
from ..bodies.rigid_body import RigidBody
from ..boundaries import Boundary, Wall
from ..materials import material_table
from ..particle_reading import JoinedParticles, TissueBody
from ..solver import MpmSolver, Precision
from . import checks
from .boundary_checks import check_boundaries, refuse_half_bodies
from .filling_checks import thickest_part
from .particles import Filling, ParticleStore
from .projectile_launch import Launch
from .rigid_body_checks import refuse_misfits, warn_of_body


@dataclass(frozen=True, slots=True, kw_only=True)
class GridSettings:
    """How an experiment is discretised; the fields are those of `Experiment`."""

    grid_spacing: float
    gravity: Vector3
    courant_number: float
    precision: Precision
    box: tuple[FloatArray, FloatArray] | None
    grid_offset: Vector3


@dataclass(frozen=True, slots=True, eq=False)
class StartedExperiment:
    """The solver with all that is in it."""

    solver: MpmSolver
    particles: JoinedParticles
    tissue: tuple[TissueBody, ...]
    rigid: tuple[RigidBody, ...]
    flights: tuple[Flight, ...]


def threads_of_environment() -> int:
    """The first number in OMP_NUM_THREADS, 0 (all processors) where there is none."""
    first = os.environ.get("OMP_NUM_THREADS", "").split(",")[0].strip()
    return int(first) if first.isdecimal() else 0


def start(
    settings: GridSettings,
    store: ParticleStore,
    rigid: Mapping[str, RigidBody | Launch],
    boundaries: Sequence[Boundary],
) -> StartedExperiment:
    """Check what was set up and fill the solver; refuses what cannot run, with the reason."""
    store.check()
    for filling in store.fillings:
        _check_resolution(filling, settings.grid_spacing, boundaries)
    checks.bodies_apart(store.fillings)
    particles = store.joined()
    bodies = tuple(
        replace(
            body.rigid_body(name, particles, settings.grid_spacing)
            if isinstance(body, Launch)
            else body,
            name=name,
        )
        for name, body in rigid.items()
    )
    flights = tuple(Flight(body, particles) for body in bodies)
    spacing = settings.grid_spacing
    box = checks.box_around(particles.position, settings.box, spacing, settings.grid_offset)
    check_boundaries(
        boundaries, particles.position, grid_spacing=spacing, grid_offset=settings.grid_offset
    )
    refuse_misfits(bodies, particles.position, spacing)
    refuse_half_bodies(boundaries, bodies, flights, spacing)
    for body, flight in zip(bodies, flights, strict=True):
        refuse_start_inside(body, particles, spacing)
        warn_of_body(body, flight, spacing)
    return StartedExperiment(
        solver=_filled_solver(
            settings, store, particles, bodies=bodies, boundaries=boundaries, box=box
        ),
        particles=particles,
        tissue=store.bodies,
        rigid=bodies,
        flights=flights,
    )


def _filled_solver(
    settings: GridSettings,
    store: ParticleStore,
    particles: JoinedParticles,
    *,
    bodies: Sequence[RigidBody],
    boundaries: Sequence[Boundary],
    box: tuple[Vector3, Vector3],
) -> MpmSolver:
    solver = MpmSolver(
        materials=material_table(store.materials, settings.grid_spacing),
        grid_spacing=settings.grid_spacing,
        lower=box[0],
        upper=box[1],
        courant_number=settings.courant_number,
        gravity=settings.gravity,
        bodies=bodies,
        boundaries=boundaries,
        precision=settings.precision,
    )
    solver.set_particles(
        particles.position,
        volume=particles.volume,
        material=particles.material_row,
        velocity=particles.velocity,
    )
    if particles.state is not None:
        solver.set_point_state(particles.state)
    return solver


def _check_resolution(
    filling: Filling, grid_spacing: float, boundaries: Sequence[Boundary]
) -> None:
    """A body needs two cells across, but between two walls a slice may have one."""
    if filling.solid is None:
        return
    confined = any(
        isinstance(one, Wall) and isinstance(other, Wall)
        and np.allclose(np.asarray(one.normal), -np.asarray(other.normal))
        for one in boundaries
        for other in boundaries
    )  # fmt: skip
    point_spacing = float(np.cbrt(filling.volume.mean()))
    thickest = thickest_part(filling.solid, filling.position, point_spacing)
    checks.body_resolved(
        filling.name, filling.solid, grid_spacing, thickest=thickest, confined=confined
    )
