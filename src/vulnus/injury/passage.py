"""One shot through a limb: the paper's section 2.2 from aim to injured geometry."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, IndexArray
from vulnus.core.checkpoint import Checkpoint, NoCheckpoint
from vulnus.core.errors import AnatomyError, ScenarioError
from vulnus.core.handoff import (
    InjuredArtery,
    InjuredLimb,
    LimbModel,
    ParticleFrame,
    ShotLine,
    Tissue,
    VesselInjury,
)
from vulnus.core.progress import Progress, SilentProgress
from vulnus.core.units import MILLISECOND

from . import wound
from .materials import tissue_table
from .parameters import InjuryParameters
from .shot_line import aim
from .solver import HeldEnds, MpmSolver, RigidSphere, set_threads

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


def shoot(
    limb: LimbModel,
    parameters: InjuryParameters,
    *,
    on_frame: Callable[[ParticleFrame], None] | None = None,
    checkpoint: Checkpoint | None = None,
    progress: Progress | None = None,
) -> InjuredLimb:
    """Shoot the projectile through the limb and return the geometry at `duration`.

    `on_frame` receives the simulated particles every `frame_interval`, in the limb's order, with
    velocity_m_per_s, displacement_m, damage and tissue. Particles outside of the window are in the
    result, undeformed. Which artery is cut, and where, is found in the result.
    """
    checkpoint = checkpoint or NoCheckpoint()
    progress = progress or SilentProgress()
    set_threads(parameters.threads)
    setup = prepare_shot(limb, parameters)
    wall = _run(
        limb, parameters, setup, on_frame=on_frame, checkpoint=checkpoint, progress=progress
    )
    return _injured_limb(limb, parameters, setup, wall)


def prepare_shot(limb: LimbModel, parameters: InjuryParameters) -> ShotSetup:
    """Aim, choose the window of the limb around the track, and fill the solver."""
    _check(parameters)
    if len(limb.position) == 0:
        raise AnatomyError("limb", "has no particles", "Check the label volume.")
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
        sphere=projectile_at_contact(inside, shot, parameters.projectile.friction),
        held=held,
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


def projectile_at_contact(position: FloatArray, shot: ShotLine, friction: float) -> RigidSphere:
    """The sphere where it first touches a particle; time begins here."""
    direction = np.asarray(shot.direction)
    entry = np.asarray(shot.entry_point)
    radius = 0.5 * shot.diameter
    offset = position - entry
    along = offset @ direction
    beside = np.einsum("ij,ij->i", offset, offset) - along**2
    near = beside < radius**2
    start = -radius
    if np.any(near):
        start = float(np.min(along[near] - np.sqrt(radius**2 - beside[near])))
    return RigidSphere(
        centre=_triple(entry + start * direction),
        velocity=_triple(shot.speed * direction),
        radius=radius,
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


def _run(
    limb: LimbModel,
    parameters: InjuryParameters,
    setup: ShotSetup,
    *,
    on_frame: Callable[[ParticleFrame], None] | None,
    checkpoint: Checkpoint,
    progress: Progress,
) -> float:
    """Run to `duration` and return the wall time [s] spent in steps, of all sessions."""
    solver = setup.solver
    wall = 0.0
    saved = checkpoint.load()
    if saved is not None:
        solver.restore(saved)
        wall = float(saved["wall"])

    progress.begin("injury", parameters.duration / MILLISECOND, "ms")

    def report() -> None:
        progress.update(solver.time / MILLISECOND, f"{solver.steps} steps")

    start = clock.perf_counter()
    if solver.time == 0.0 and on_frame is not None:
        on_frame(_frame(limb, setup, 0))
    begun = solver.time
    for index, until in _frame_times(parameters):
        if until <= begun:  # written before the checkpoint that this run goes on from
            continue
        while solver.time < until:
            solver.advance_epoch(until, on_call=report)
            if checkpoint.due() and solver.time < until:
                elapsed = wall + clock.perf_counter() - start
                checkpoint.save({**solver.state(), "wall": elapsed})
        if on_frame is not None:
            on_frame(_frame(limb, setup, index))
    progress.end()
    return wall + clock.perf_counter() - start


def _frame_times(parameters: InjuryParameters) -> list[tuple[int, float]]:
    """Index and time [s] of every frame after the first; the last one is at `duration`."""
    count = math.ceil(parameters.duration / parameters.frame_interval - 1e-9)
    times = [index * parameters.frame_interval for index in range(1, count)]
    return list(enumerate([*times, parameters.duration], start=1))


def _frame(limb: LimbModel, setup: ShotSetup, index: int) -> ParticleFrame:
    solver = setup.solver
    position = solver.position.astype(np.float32)
    return ParticleFrame(
        index=index,
        time=solver.time,
        position=position,
        point_data={
            "velocity_m_per_s": solver.velocity.astype(np.float32),
            "displacement_m": position - limb.position[setup.simulated],
            "damage": solver.damage.astype(np.float32),
            "tissue": limb.tissue[setup.simulated],
        },
    )


def _injured_limb(
    limb: LimbModel, parameters: InjuryParameters, setup: ShotSetup, wall: float
) -> InjuredLimb:
    solver, shot = setup.solver, setup.shot
    position = np.array(limb.position, np.float32)
    position[setup.simulated] = solver.position
    damage = np.zeros(len(position), np.float32)
    damage[setup.simulated] = solver.damage
    arteries, injuries = _injured_arteries(limb, parameters, setup, damage)
    entry_area, exit_area = _hole_areas(limb, parameters, shot, position, damage)
    return InjuredLimb(
        position=position,
        reference_position=np.asarray(limb.position, np.float32),
        tissue=limb.tissue,
        volume=limb.volume,
        damage=damage,
        spacing=limb.spacing,
        arteries=arteries,
        injuries=injuries,
        shot=shot,
        entry_area=entry_area,
        exit_area=exit_area,
        time=solver.time,
        steps=solver.steps,
        particle_steps_per_second=solver.steps * len(setup.simulated) / max(wall, 1e-9),
        surfaces=limb.surfaces,
        side=limb.side,
    )


def _injured_arteries(
    limb: LimbModel, parameters: InjuryParameters, setup: ShotSetup, damage: AnyArray
) -> tuple[tuple[InjuredArtery, ...], tuple[VesselInjury, ...]]:
    moved, gaps = setup.solver.tracers
    wall = np.flatnonzero(limb.tissue == Tissue.ARTERY)
    arteries: list[InjuredArtery] = []
    injuries: list[VesselInjury] = []
    parts = zip(limb.arteries, setup.stations, setup.tracer_inside, setup.tracer_range, strict=True)
    for artery, stations, inside, tracers in parts:
        deformed = stations.points.copy()
        deformed[inside] = moved[tracers]
        gap = np.full(len(deformed), np.inf)
        gap[inside] = gaps[tracers]
        own_wall = wound.wall_point_damage(stations, limb.position[wall], damage[wall])
        station = wound.station_damage(
            stations, deformed, gap, own_wall, parameters.artery_failure_stretch
        )
        arteries.append(wound.injured_artery(artery, stations, deformed, station))
        injuries += wound.find_injuries(stations, deformed, station, parameters.damage_threshold)
    return tuple(arteries), wound.worst_first(injuries)


def _hole_areas(
    limb: LimbModel,
    parameters: InjuryParameters,
    shot: ShotLine,
    position: AnyArray,
    damage: AnyArray,
) -> tuple[float, float]:
    skin = np.flatnonzero(limb.tissue == Tissue.SKIN)
    if len(skin) == 0:
        return 0.0, 0.0
    reference = np.asarray(limb.position[skin], np.float64)
    destroyed = wound.destroyed_skin(
        reference,
        position[skin],
        damage[skin],
        spacing=limb.spacing,
        threshold=parameters.damage_threshold,
    )
    # Chosen: far enough for a hole of three calibres, near enough to tell entry from exit.
    radius = 1.5 * shot.diameter + 3.0 * parameters.grid_spacing
    entry, exit_ = (
        wound.hole_area(
            reference,
            limb.volume[skin],
            destroyed,
            limb.surfaces["skin"],
            centre=point,
            radius=radius,
        )
        for point in (shot.entry_point, shot.exit_point)
    )
    return entry, exit_


def _check(parameters: InjuryParameters) -> None:
    for name in ("grid_spacing", "duration", "frame_interval", "bone_modulus_scale"):
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
            "injury.window_length",
            f"is {window:g} m, must exceed both held ends ({parameters.held_length:g} m each)",
            "Use at least five projectile diameters, or 0 for the whole limb.",
        )


def _triple(values: AnyArray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
