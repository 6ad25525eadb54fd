"""One shot through a limb: the paper's section 2.2 from aim to injured geometry, and its collapse.

Two phases: the flight with the tissues' true moduli, then the collapse of the temporary cavity with
lowered bulk moduli, which takes larger steps. The mode "paper" has the first phase only.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.checkpoint import Checkpoint, NoCheckpoint
from vulnus.core.handoff import (
    InjuredLimb,
    InjuryOutcome,
    LimbModel,
    ParticleFrame,
)
from vulnus.core.progress import Progress, SilentProgress
from vulnus.core.units import MILLISECOND

from ..materials import slowed
from ..parameters import InjuryParameters
from ..solver import set_threads
from .artery_injuries import artery_report, injured_arteries
from .projectile_way import ProjectileWay, fates_of, ways_of
from .record import RunRecord, Snapshot, poses
from .report import LimbState, cavity_of, open_holes, wound_report
from .run_end import collapse_time, schedule
from .setup import ShotSetup, prepare_shot


def shoot(
    limb: LimbModel,
    parameters: InjuryParameters,
    *,
    on_frame: Callable[[ParticleFrame], None] | None = None,
    checkpoint: Checkpoint | None = None,
    progress: Progress | None = None,
) -> InjuryOutcome:
    """Shoot the projectile through the limb; the limb's states by name, and the wound report.

    `on_frame` receives the simulated particles every `frame_interval`, later every
    `relaxation_frame_interval`, in the limb's order, with velocity_m_per_s, displacement_m, damage
    and tissue. Particles outside of the window are in the result, undeformed. Which artery is cut,
    and where, is found in the result.
    """
    set_threads(parameters.threads)
    setup = prepare_shot(limb, parameters)
    run = _Run(setup, checkpoint or NoCheckpoint(), on_frame)
    run.to_the_end(progress or SilentProgress())
    return _outcome(setup, run.record)


class _Run:
    """The solver on its way through both phases, with frames and checkpoints."""

    def __init__(
        self,
        setup: ShotSetup,
        checkpoint: Checkpoint,
        on_frame: Callable[[ParticleFrame], None] | None,
    ) -> None:
        self.setup, self.checkpoint, self.on_frame = setup, checkpoint, on_frame
        self.schedule = schedule(setup.parameters, setup.thrust_end)
        # A guided body turns at a step's end, so that its deepest place is noted.
        self.stops = np.unique([*self.schedule.times, *setup.turns])
        self.record = RunRecord(setup.solver, setup.connected)

    def to_the_end(self, progress: Progress) -> None:
        """Run from where the checkpoint stands to the last frame."""
        solver = self.setup.solver
        saved = self.checkpoint.load()
        if saved is not None:
            solver.restore(saved)
            self.record.resume(saved)
        progress.begin("injury", self.schedule.latest / MILLISECOND, "ms")

        def report() -> None:
            progress.update(solver.time / MILLISECOND, f"{solver.steps} steps")

        if solver.time == 0.0:
            self._end_of_frame(0)
        begun = solver.time
        for index, until in enumerate(self.schedule.times, start=1):
            if until <= begun:  # written before the checkpoint that this run goes on from
                continue
            while solver.time < until:
                self._epoch(until, report)
            self._end_of_frame(index)
            if self._has_collapsed():
                break
        progress.end()

    def _epoch(self, until: float, report: Callable[[], None]) -> None:
        solver, record = self.setup.solver, self.record
        start = clock.perf_counter()
        number = int(np.searchsorted(self.stops, solver.time, side="right"))
        stop, then = self.stops[number], self.stops[min(number + 1, len(self.stops) - 1)]
        solver.advance_epoch(float(stop), then=float(then), on_call=report)
        record.wall += clock.perf_counter() - start
        record.follow(solver)
        if solver.synchronized and self._flight_is_over():
            solver.change_materials(self._slowed_materials())
            record.relaxed = True
        if solver.synchronized and solver.time < until and self.checkpoint.due():
            self.checkpoint.save({**solver.state(), **record.entries()})

    def _end_of_frame(self, index: int) -> None:
        solver = self.setup.solver
        cavity = cavity_of(self.setup, solver.position, poses(solver.bodies))
        self.record.note_cavity(solver, cavity.volume)
        if self.on_frame is not None:
            self.on_frame(_frame(self.setup, index))

    def _has_collapsed(self) -> bool:
        """Whether the run may end: no projectile is on its way and the cavity has collapsed."""
        if not self.schedule.earliest <= self.setup.solver.time < self.schedule.latest:
            return False
        return collapse_time(self.record.history) is not None and "inside" not in fates_of(
            self.setup
        )

    def _flight_is_over(self) -> bool:
        """Whether the moduli may be lowered now: every projectile is out, or slow, and none guided.

        Slow is a tenth of the lowered speed of sound, where compressibility does not matter.
        """
        parameters, solver = self.setup.parameters, self.setup.solver
        if self.record.relaxed or parameters.mode == "paper":
            return False
        slow = 0.1 * parameters.relaxation_sound_speed
        if slow == 0.0 or solver.time < max(parameters.phase_one, self.setup.thrust_end):
            return False
        return all(
            fate == "left" or float(np.linalg.norm(body.velocity)) < slow
            for fate, body in zip(fates_of(self.setup), solver.bodies, strict=True)
        )

    def _slowed_materials(self) -> FloatArray:
        return slowed(self.setup.materials, self.setup.parameters.relaxation_sound_speed)


def _frame(setup: ShotSetup, index: int) -> ParticleFrame:
    limb, solver = setup.limb, setup.solver
    position = solver.position.astype(np.float32)
    return ParticleFrame(
        index=index,
        time=solver.time,
        position=position,
        point_data={
            "velocity_m_per_s": solver.velocity.astype(np.float32),
            "displacement_m": position - limb.position[setup.simulated],
            "damage": np.asarray(solver.damage, np.float32),
            "tissue": limb.tissue[setup.simulated],
        },
        frame_data={
            "projectile_position_m": np.array([body.position for body in solver.bodies]),
            "projectile_rotation": np.array([body.rotation.ravel() for body in solver.bodies]),
        },
    )


def _outcome(setup: ShotSetup, record: RunRecord) -> InjuryOutcome:
    last = record.snapshot(setup.solver)
    named = {"permanent": last}
    if setup.parameters.mode == "full":
        named = {"temporary": record.largest or last, "permanent": last}
    ways = ways_of(setup, record)
    end = LimbState.of(setup, last)
    vessels = artery_report(setup, last, _paths(ways), end.damage)
    return InjuryOutcome(
        states={
            name: _injured_limb(setup, snapshot, record=record, ways=ways)
            for name, snapshot in named.items()
        },
        bleeds_from=setup.parameters.bleeds_from,
        report=wound_report(setup, record, ways, end=end, vessels=vessels),
    )


def _paths(ways: Sequence[ProjectileWay]) -> list[FloatArray]:
    return [way.middle.position for way in ways]


def _injured_limb(
    setup: ShotSetup, snapshot: Snapshot, *, record: RunRecord, ways: Sequence[ProjectileWay]
) -> InjuredLimb:
    limb, solver = setup.limb, setup.solver
    state = LimbState.of(setup, snapshot)
    arteries, injuries = injured_arteries(setup, snapshot, _paths(ways), state.damage)
    first, *others = open_holes(setup, ways, state)
    return InjuredLimb(
        position=state.position,
        reference_position=np.asarray(limb.position, np.float32),
        tissue=limb.tissue,
        volume=limb.volume,
        damage=state.damage,
        spacing=limb.spacing,
        arteries=arteries,
        injuries=injuries,
        shot=setup.shot,
        entry_area=first.entry_area,
        exit_area=first.exit_area,
        other_holes=tuple(others),
        time=snapshot.time,
        steps=snapshot.steps,
        particle_steps_per_second=solver.steps * len(setup.simulated) / max(record.wall, 1e-9),
        surfaces=limb.surfaces,
        side=limb.side,
    )
