"""An experiment: bodies of tissue, rigid bodies, boundaries and sensors; run it, read the result.

experiment = Experiment(grid_spacing=1e-3)
experiment.add_body(Block(size=(0.15, 0.06, 0.06)), material="gelatin_10", name="gel")
experiment.add_projectile("bb_4.5mm", speed=180, direction="x", target=(0, 0, 0), name="ball")
result = experiment.run(until=2e-3)
result.rigid_body("ball").depth[-1]

Everything is SI: metres, kilograms, seconds, pascals. Positions are in one world frame.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vulnus.core.checkpoint import Checkpoint
from vulnus.core.errors import ScenarioError
from vulnus.core.progress import Progress, SilentProgress
from vulnus.core.units import MILLISECOND

from ..bodies.rigid_body import BodyState
from ..checked_values import has_methods, may_be_called, not_too_fast, one_of, positive
from ..material_model import slowed
from ..particle_reading import ParticleReading
from ..solver import MpmSolver, set_threads
from .fields import Fields, read_fields
from .fingerprint import experiment_fingerprint
from .record import Record
from .result import ExperimentResult
from .resume import RunHistory
from .sample_schedule import SampleSchedule
from .setup import ExperimentSetup
from .start import GridSettings, StartedExperiment, start, threads_of_environment


class Experiment(ExperimentSetup):
    """A case for the material point solver, set up piece by piece and then run.

    `grid_spacing` [m] is the edge of a grid cell; the nodes stand at its whole multiples in the
    world frame, moved by `grid_offset` [m]. `gravity` [m/s²]. `courant_number` scales the time
    step, 0.3 to 0.4. `precision` is that of the arithmetic: "float32", or "float64" where round-off
    counts. `threads` 0 takes OMP_NUM_THREADS, or all processors where that is not set; the result
    does not depend on it. `lower` and `upper` [m] are corners of the box that no particle may
    leave; without them it reaches five times the extent of the bodies, and at least 20 m, beyond
    them.
    """

    _started: StartedExperiment | None = None
    _record: Record | None = None
    _history: RunHistory | None = None
    _running = False

    @property
    def time(self) -> float:
        """Simulated time [s] so far."""
        return self._started.solver.time if self._started else 0.0

    @property
    def solver(self) -> MpmSolver:
        """The solver behind the experiment; asking for it ends the setting up."""
        return self._start().solver

    @property
    def step_estimate(self) -> float:
        """Time step [s] that the materials and the speeds before the start allow."""
        particles, rigid = self._start().particles, self._start().rigid
        wave = max(material.sound_speed for material in self._store.materials)
        fastest = float(np.max(np.linalg.norm(particles.velocity, axis=1)))
        fastest = max([fastest, *(float(np.linalg.norm(body.velocity)) for body in rigid)])
        return self.courant_number * self.grid_spacing / (wave + fastest)

    def fields(self) -> Fields:
        """All particles as they are now; asking for them ends the setting up."""
        return read_fields(self._reading(), self._start().tissue)

    def rigid_body(self, name: str) -> BodyState:
        """A rigid body as it is now; asking for it ends the setting up."""
        started = self._start()
        names = [body.name for body in started.rigid]
        return started.solver.bodies[names.index(one_of("rigid body", name, names))]

    def run(
        self,
        until: float,
        *,
        sample_interval: float | None = None,
        snapshot_interval: float | None = None,
        stop_when: Callable[[Experiment], bool] | None = None,
        on_sample: Callable[[Experiment], None] | None = None,
        progress: Progress | None = None,
        checkpoint: Checkpoint | None = None,
    ) -> ExperimentResult:
        """Step to the time `until` [s] and give back all that was recorded since the start.

        Samples are taken at time 0, at every whole multiple of `sample_interval` [s] (default: a
        hundredth of `until`) and at the end; snapshots of all particles at the multiples of
        `snapshot_interval` [s], which must be samples. At each sample
        `on_sample` is called with the experiment, and `stop_when` may end the run by giving True.
        Samples may be as dense as you like; each takes a time step's end, no more. Call `run` again
        with a later `until` to go on: where a run ends, all momentum passes to the particles, which
        smooths it a little, so that many short runs are not quite one long run. `checkpoint` keeps
        the state when it is due; the same script, started anew, goes on from there: runs that were
        finished then return at once what they returned, and the one that was cut off goes on.
        Raises `UnstableStepError` where a particle inverts, leaves the box or is not finite.
        """
        for name, function in (("stop_when", stop_when), ("on_sample", on_sample)):
            may_be_called(name, function)
        if progress is not None:
            has_methods("progress", progress, ("begin", "update", "end"), "a Progress")
        schedule = SampleSchedule.of(self.time, until, sample_interval, snapshot_interval)
        if self._running:
            raise ScenarioError("run", "is called from within run", "Return from it first.")
        self._running = True
        try:
            return self._run(schedule, stop_when, on_sample, progress, checkpoint)
        finally:
            self._running = False

    def _run(
        self,
        schedule: SampleSchedule,
        stop_when: Callable[[Experiment], bool] | None,
        on_sample: Callable[[Experiment], None] | None,
        progress: Progress | None,
        checkpoint: Checkpoint | None,
    ) -> ExperimentResult:
        set_threads(self.threads or threads_of_environment())
        solver = self._start().solver
        record, history = self._recorder(schedule), self._run_history()
        history.begin(solver, checkpoint)
        replayed = history.replay(schedule, solver, record)
        if replayed is not None:
            return self._result(record, stopped_early=replayed.stopped)

        history.resume(schedule, solver, record)
        stopped = False

        def save() -> None:
            if checkpoint is not None and solver.synchronized and checkpoint.due():
                checkpoint.save(history.data(solver, record))

        def report() -> None:
            bar.update(solver.time / MILLISECOND, f"{solver.steps} steps")

        bar = progress or SilentProgress()
        bar.begin("experiment", schedule.until / MILLISECOND, "ms")
        try:
            for time, then in schedule.after(solver.time):
                while solver.time < time:
                    solver.advance_epoch(time, then=then, on_call=report)
                    if solver.time < time:
                        save()
                record.add(self._reading(), snapshot=schedule.is_snapshot(solver.time))
                if on_sample is not None:
                    on_sample(self)
                stopped = stop_when is not None and bool(stop_when(self))
                if stopped:
                    break
                save()
        finally:
            bar.end()
        solver.settle()
        history.finish(schedule, solver, record, stopped=stopped)
        return self._result(record, stopped_early=stopped)

    def slow_waves(self, sound_speed: float) -> None:
        """Lower the elastic moduli from now on, so that waves run at `sound_speed` [m/s] at most.

        Steps grow in proportion. For the slow end of an experiment, such as the collapse of a
        cavity, when the waves of the impact are of no interest any more: strengths, networks and
        this moment's stress (Kirchhoff's) stay. Choose about ten times the speeds that still occur.
        """
        not_too_fast("sound", positive("sound_speed", sound_speed))
        started = self._start()
        started.solver.change_materials(slowed(started.solver.materials, sound_speed))

    def _settings(self) -> GridSettings:
        return GridSettings(
            grid_spacing=self.grid_spacing,
            gravity=self.gravity,
            courant_number=self.courant_number,
            precision=self.precision,
            box=self._box,
            grid_offset=self._grid_offset,
        )

    def _start(self) -> StartedExperiment:
        """The started experiment; checked and made at the first call."""
        if self._started is None:
            self._started = start(self._settings(), self._store, self._rigid, self._boundaries)
            self._begun = True
        return self._started

    def _reading(self) -> ParticleReading:
        started = self._start()
        return ParticleReading(started.solver, started.particles, started.tissue)

    def _recorder(self, schedule: SampleSchedule) -> Record:
        """The record, with its first sample."""
        if self._record is None:
            started, reading = self._start(), self._reading()
            sensors = {
                name: sensor.attach(reading, self.grid_spacing)
                for name, sensor in self._sensors.items()
            }
            self._record = Record(started, gravity=self.gravity, sensors=sensors)
            self._record.add(reading, snapshot=schedule.samples_per_snapshot > 0)
        return self._record

    def _run_history(self) -> RunHistory:
        """The finished runs, by which a checkpoint finds its place."""
        if self._history is None:
            self._history = RunHistory(
                lambda: experiment_fingerprint(
                    self._settings(),
                    self._store,
                    self._start().rigid,
                    self._boundaries,
                    self._sensors,
                )
            )
        return self._history

    def _result(self, record: Record, *, stopped_early: bool) -> ExperimentResult:
        started = self._start()
        return ExperimentResult(
            columns=record.columns,
            final=self.fields(),
            snapshots=record.snapshots,
            steps=started.solver.steps,
            stopped_early=stopped_early,
        )
