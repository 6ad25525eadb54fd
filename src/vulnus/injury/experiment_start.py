"""An experiment at its first step: checked, placed, and put into the solver."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3

from . import experiment_checks as checks
from .boundaries import Boundary, Wall
from .experiment_particles import Filling, ParticleStore
from .flight import Flight, refuse_start_inside
from .materials import material_table
from .particle_reading import JoinedParticles, TissueBody
from .projectile_launch import Launch
from .rigid_body import RigidBody
from .solver import MpmSolver, Precision

LEAST_PROJECTILE_CELLS = 5.0
"""Cells across a projectile below which its depth depends on the grid (PHYSICS 1.6)."""


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
    for body in bodies:
        refuse_start_inside(body, particles, settings.grid_spacing)
        _warn_of_coarse_grid(body, settings.grid_spacing)
    return StartedExperiment(
        solver=_filled_solver(settings, store, particles, bodies, boundaries),
        particles=particles,
        tissue=store.bodies,
        rigid=bodies,
        flights=tuple(Flight(body, particles) for body in bodies),
    )


def _filled_solver(
    settings: GridSettings,
    store: ParticleStore,
    particles: JoinedParticles,
    bodies: Sequence[RigidBody],
    boundaries: Sequence[Boundary],
) -> MpmSolver:
    lower, upper = checks.box_around(
        particles.position, settings.box, settings.grid_spacing, settings.grid_offset
    )
    solver = MpmSolver(
        materials=material_table(store.materials, settings.grid_spacing),
        grid_spacing=settings.grid_spacing,
        lower=lower,
        upper=upper,
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
    checks.body_resolved(filling.name, filling.solid, grid_spacing, confined=confined)


def _warn_of_coarse_grid(body: RigidBody, grid_spacing: float) -> None:
    cells = 2.0 * body.shape.inner_radius / grid_spacing
    if cells < LEAST_PROJECTILE_CELLS * (1.0 - 1e-6) and not body.cutting:
        warnings.warn(
            f"{body.name} is {cells:.1f} cells across; its depth depends on the grid below "
            f"{LEAST_PROJECTILE_CELLS:g}: use a grid_spacing of at most "
            f"{2.0 * body.shape.inner_radius / LEAST_PROJECTILE_CELLS:.3g} m",
            stacklevel=5,
        )
