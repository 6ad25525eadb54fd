"""One shot through a limb: the paper's section 2.2 from aim to injured geometry."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable

import numpy as np

from vulnus.core.arrays import AnyArray
from vulnus.core.checkpoint import Checkpoint, NoCheckpoint
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
from .parameters import InjuryParameters
from .shot_setup import ShotSetup, prepare_shot
from .solver import set_threads


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

    progress.begin("injury", parameters.end_time / MILLISECOND, "ms")

    def report() -> None:
        progress.update(solver.time / MILLISECOND, f"{solver.steps} steps")

    if solver.time == 0.0 and on_frame is not None:
        on_frame(_frame(limb, setup, 0))
    begun = solver.time
    for index, until in _frame_times(parameters):
        if until <= begun:  # written before the checkpoint that this run goes on from
            continue
        while solver.time < until:
            start = clock.perf_counter()
            solver.advance_epoch(until, on_call=report)
            wall += clock.perf_counter() - start
            if checkpoint.due() and solver.time < until:
                checkpoint.save({**solver.state(), "wall": wall})
        if on_frame is not None:
            on_frame(_frame(limb, setup, index))
    progress.end()
    return wall


def _frame_times(parameters: InjuryParameters) -> list[tuple[int, float]]:
    """Index and time [s] of every frame after the first; the last one is at `duration`."""
    count = math.ceil(parameters.end_time / parameters.frame_interval - 1e-9)
    times = [index * parameters.frame_interval for index in range(1, count)]
    return list(enumerate([*times, parameters.end_time], start=1))


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
        own_wall = wound.wall_point_damage(
            stations, limb.position[wall], damage[wall], parameters.grid_spacing
        )
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
