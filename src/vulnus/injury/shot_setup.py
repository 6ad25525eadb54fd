"""A shot before its first step: its line, the part of the limb that is simulated, the solver."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from vulnus.core.errors import AnatomyError, ScenarioError
from vulnus.core.handoff import LimbModel, ShotLine
from vulnus.core.units import MILLIMETRE

from . import wound
from .boundaries import HeldEnds
from .materials import tissue_table
from .parameters import InjuryParameters
from .rigid_body import RigidBody
from .shapes import Sphere
from .shot_line import aim
from .solver import MpmSolver

DOMAIN_MARGIN = 0.5
"""How far [m] a particle may fly out of the limb's box; chosen: 1 ms at 500 m/s."""


@dataclass(frozen=True, slots=True, eq=False)
class ShotSetup:
    """A shot ready to run: who is simulated, and the solver before its first step."""

    solver: MpmSolver
    shot: ShotLine
    simulated: IndexArray
    stations: tuple[wound.CentrelineStations, ...]
    tracer_range: tuple[slice, ...]
    tracer_inside: tuple[BoolArray, ...]


def prepare_shot(limb: LimbModel, parameters: InjuryParameters) -> ShotSetup:
    """Aim, choose the window of the limb around the track, and fill the solver."""
    _check(parameters)
    if len(limb.position) == 0:
        raise AnatomyError("limb", "has no particles", "Check the label volume.")
    if parameters.grid_spacing < limb.spacing:
        raise ScenarioError(
            "injury.grid_spacing_mm",
            f"is {parameters.grid_spacing / MILLIMETRE:g} mm, less than the points' spacing of "
            f"{limb.spacing / MILLIMETRE:g} mm",
            "Use about twice anatomy.particle_spacing_mm, or the tissue falls apart between cells.",
        )
    shot = aim(limb, parameters.aim, parameters.projectile)
    position = np.asarray(limb.position, np.float64)
    axis = long_axis(position)
    height = position @ axis
    lower, upper = window_of(height, shot, axis, parameters.window_length)
    simulated = np.flatnonzero((height >= lower) & (height <= upper))
    held = HeldEnds(
        axis=(float(axis[0]), float(axis[1]), float(axis[2])),
        lower=lower + parameters.held_length,
        upper=upper - parameters.held_length,
    )
    inside = position[simulated]
    solver = MpmSolver(
        materials=tissue_table(
            parameters.grid_spacing, bone_modulus_scale=parameters.bone_modulus_scale
        ),
        grid_spacing=parameters.grid_spacing,
        lower=_triple(inside.min(axis=0) - DOMAIN_MARGIN),
        upper=_triple(inside.max(axis=0) + DOMAIN_MARGIN),
        courant_number=parameters.courant_number,
        gravity=parameters.gravity,
        bodies=[
            projectile_at_contact(
                inside,
                shot,
                friction=parameters.projectile.friction,
                grid_spacing=parameters.grid_spacing,
            )
        ],
        boundaries=[held],
    )
    solver.set_particles(inside, volume=limb.volume[simulated], material=limb.tissue[simulated])
    stations = tuple(
        wound.resample(artery, 0.5 * parameters.grid_spacing) for artery in limb.arteries
    )
    tracer_inside, tracer_range = _place_tracers(solver, stations, axis, lower, upper)
    return ShotSetup(solver, shot, simulated, stations, tracer_range, tracer_inside)


def long_axis(position: FloatArray) -> FloatArray:
    """Unit vector (3,) of the limb's long axis: the direction of largest spread, upwards."""
    centred = position - position.mean(axis=0)
    _, vectors = np.linalg.eigh(centred.T @ centred)
    axis: FloatArray = vectors[:, -1]
    return axis if axis[2] >= 0.0 else -axis


def window_of(
    height: FloatArray, shot: ShotLine, axis: FloatArray, window_length: float | None
) -> tuple[float, float]:
    """Lower and upper end [m] along the axis of the part that is simulated.

    The track's own extent along the axis comes on top of `window_length`, so that the holes of an
    oblique shot keep their distance from the held ends; the limb's ends bound it.
    """
    lowest, highest = float(height.min()), float(height.max())
    if window_length is None:
        return lowest, highest
    ends = (float(np.dot(shot.entry_point, axis)), float(np.dot(shot.exit_point, axis)))
    half = 0.5 * window_length
    return max(lowest, min(ends) - half), min(highest, max(ends) + half)


def contact_radius(diameter: float, grid_spacing: float) -> float:
    """Radius [m] that the grid feels: the projectile's, but never less than 0.9 of a cell.

    A smaller sphere could pass between the nodes, whose cells have a half diagonal of 0.87.
    """
    smallest = 0.9 * grid_spacing
    if 0.5 * diameter < smallest:
        given, cell, acting = (v / MILLIMETRE for v in (diameter, grid_spacing, 2.0 * smallest))
        acts = f"{given:.1f} mm on cells of {cell:.1f} mm acts as one of {acting:.1f} mm"
        warnings.warn(f"a projectile of {acts}", stacklevel=2)
    return max(0.5 * diameter, smallest)


def projectile_at_contact(
    position: FloatArray, shot: ShotLine, *, friction: float, grid_spacing: float
) -> RigidBody:
    """The sphere where it first touches a particle; time begins here."""
    direction = np.asarray(shot.direction)
    entry = np.asarray(shot.entry_point)
    radius = contact_radius(shot.diameter, grid_spacing)
    offset = position - entry
    along = offset @ direction
    beside = np.einsum("ij,ij->i", offset, offset) - along**2
    near = beside < radius**2
    start = -radius
    if np.any(near):
        start = float(np.min(along[near] - np.sqrt(radius**2 - beside[near])))
    return RigidBody(
        shape=Sphere(radius),
        centre=_triple(entry + start * direction),
        velocity=_triple(shot.speed * direction),
        friction=friction,
    )


def _place_tracers(
    solver: MpmSolver,
    stations: tuple[wound.CentrelineStations, ...],
    axis: FloatArray,
    lower: float,
    upper: float,
) -> tuple[tuple[BoolArray, ...], tuple[slice, ...]]:
    inside, ranges, points = [], [], [np.zeros((0, 3))]
    first = 0
    for artery in stations:
        height = artery.points @ axis
        within = (height >= lower) & (height <= upper)
        inside.append(within)
        points.append(artery.points[within])
        ranges.append(slice(first, first + int(np.count_nonzero(within))))
        first = ranges[-1].stop
    solver.set_tracers(np.concatenate(points))
    return tuple(inside), tuple(ranges)


def _check(parameters: InjuryParameters) -> None:
    for name in ("grid_spacing", "end_time", "frame_interval", "bone_modulus_scale"):
        value = getattr(parameters, name)
        if not (math.isfinite(value) and value > 0.0):
            raise ScenarioError(
                f"injury.{name}",
                f"is {value:g} in SI units, must be > 0",
                "Give a positive number.",
            )
    if not 0.0 < parameters.courant_number <= 1.0:
        raise ScenarioError(
            "injury.courant_number",
            f"is {parameters.courant_number:g}, must be > 0 and <= 1",
            "Use 0.3 to 0.4.",
        )
    window = parameters.window_length
    if window is not None and not window > 2.0 * parameters.held_length:
        raise ScenarioError(
            "injury.window_length_mm",
            f"is {window / MILLIMETRE:g} mm, must exceed both held ends "
            f"({parameters.held_length / MILLIMETRE:g} mm each)",
            "Use at least five projectile diameters, or 0 for the whole limb.",
        )


def _triple(values: AnyArray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
