"""The bleeding run: arterial tree and blood particles, exchanging once per heartbeat.

As in the paper (section 2.3): the flow of a beat is what the tree gives against the pressure that
the blood around the wound had, on average, in the beat before. With the relaxation ω the tree
sees p ← p + ω (p_measured - p). Between two exchanges the solver takes in a flow that is linear
between the tree's samples, and its integral is the ledger's injected volume.

One thing the paper does not say: within a beat, blood around the wound that is found above the
stump's pressure holds the flow back (`BeatFlow.between`). Without that a closed pocket would be
filled far beyond the artery's pressure before the tree hears of it.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from vulnus.core.checkpoint import Checkpoint, CheckpointData, CheckpointValue, NoCheckpoint
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import BleedOutcome, ParticleFrame
from vulnus.core.progress import Progress, SilentProgress
from vulnus.core.units import MILLILITRE, MILLIMETRE_OF_MERCURY

from .beat_flow import BeatFlow, FlowSlice
from .blood_solver import BloodSolver, TreePort
from .parameters import CouplingParameters
from .run_log import RunLog
from .running_mean import RunningMean
from .schedule import Schedule, Stop

_SOLVER_PREFIX = "solver_"


def bleed_out(
    tree_port: TreePort,
    solver: BloodSolver,
    parameters: CouplingParameters,
    *,
    on_frame: Callable[[ParticleFrame], None] = lambda _frame: None,
    checkpoint: Checkpoint | None = None,
    progress: Progress | None = None,
) -> BleedOutcome:
    """Let the limb bleed for `parameters.duration` and account for the blood.

    Frames go to `on_frame` at exact multiples of the frame interval, frame 0 at time 0. Where the
    checkpoint holds one, the run goes on from there with the same bits; frames since then are
    handed out again. The mean flows are those of whole beats; a run that ends within its first beat
    has the mean over what was simulated of it.
    Raises `ScenarioError` for times or a relaxation outside their ranges. An interrupt leaves the
    newest checkpoint in place.
    """
    _check(parameters)
    checkpoint = checkpoint or NoCheckpoint()
    progress = progress or SilentProgress()
    run = BleedingRun(tree_port, solver, parameters)
    saved = checkpoint.load()
    progress.begin("bleeding", parameters.duration, "s")
    if saved is None:
        run.begin(on_frame)
    else:
        run.restore(saved)
    while not run.finished:
        stop = run.go_to_next_stop(progress)
        if stop.frame:
            on_frame(solver.frame(run.frames - 1))
        if checkpoint.due():
            checkpoint.save(run.state())
    progress.end()
    return run.outcome()


@dataclass(slots=True)
class BleedingRun:
    """The state of a bleeding run between two stops."""

    port: TreePort
    solver: BloodSolver
    parameters: CouplingParameters
    schedule: Schedule = field(init=False)
    beat: BeatFlow = field(init=False)
    log: RunLog = field(init=False, default_factory=RunLog)
    pressure: float = field(init=False)
    beats: int = field(init=False, default=0)
    frames: int = field(init=False, default=0)
    samples: int = field(init=False, default=0)
    injected: float = field(init=False, default=0.0)
    injected_before: float = field(init=False, default=0.0)
    pressure_outside: float = field(init=False)
    finished: bool = field(init=False, default=False)
    beat_pressure: RunningMean = field(init=False, default_factory=RunningMean)
    sample_pressure: RunningMean = field(init=False, default_factory=RunningMean)
    particle_steps: float = field(init=False, default=0.0)
    wall: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        self.pressure = self.pressure_outside = self.parameters.initial_pressure
        self.schedule = Schedule(
            duration=self.parameters.duration,
            frame_interval=self.parameters.frame_interval,
            sample_interval=self.parameters.sample_interval,
            period=self.port.period,
        )

    def begin(self, on_frame: Callable[[ParticleFrame], None]) -> None:
        """Open the first beat; frame 0 and sample 0."""
        self._open_beat()
        first = self._flow_until(self.schedule.sample_interval)
        self._sample(self.pressure, float(first.flow[0]), float(self.beat.pressure_artery[0]))
        on_frame(self.solver.frame(0))
        self.frames = self.samples = 1

    def go_to_next_stop(self, progress: Progress) -> Stop:
        """Advance the blood to the next frame, sample, end of beat or end, and take note."""
        stop = self.schedule.stop_after(frames=self.frames, samples=self.samples, beats=self.beats)
        given = self._flow_until(stop.time)
        self._advance(stop.time, given, progress)
        if stop.sample:
            measured = self.sample_pressure.take(self.pressure_outside)
            self._sample(measured, float(given.flow[-1]), given.pressure_artery)
            self.samples += 1
        if stop.frame:
            self.frames += 1
        if stop.beat or (stop.end and not self.log.mean_flow):
            elapsed = stop.time - self.beat.start
            self.log.mean_flow.append((self.injected - self.injected_before) / elapsed)
        if stop.beat and not stop.end:
            self._exchange()
        self.finished = stop.end
        return stop

    def _flow_until(self, stop: float) -> FlowSlice:
        """The tree's flow from now to a stop, held back by the pressure measured last."""
        return self.beat.between(
            self.solver.time,
            stop,
            pressure_outside=self.pressure_outside,
            resistance=self.port.resistance,
        )

    def _advance(self, until: float, given: FlowSlice, progress: Progress) -> None:
        """Advance the solver, keep the pressure it measured and count its work."""
        begun, steps, since = clock.perf_counter(), self.solver.steps, self.solver.time
        self.solver.advance(
            until,
            (given.time, given.flow),
            on_chunk=lambda time: progress.update(time, self._note()),
        )
        self.injected += given.volume
        self.wall += clock.perf_counter() - begun
        self.particle_steps += (self.solver.steps - steps) * self.solver.particle_count
        self.pressure_outside = self.solver.pressure_injury
        for mean in (self.beat_pressure, self.sample_pressure):
            mean.add(self.pressure_outside, until - since)
        progress.update(until, self._note())

    def _sample(self, pressure_injury: float, flow: float, pressure_artery: float) -> None:
        """Write a row of waveforms and ledger at the solver's time."""
        time = self.solver.time
        signals = (self.beat.aorta_at(time), pressure_artery, pressure_injury, flow)
        self.log.sample(time, signals, self.injected, self.solver.volumes())

    def _exchange(self) -> None:
        """Hand the tree the beat's mean pressure and open the next beat."""
        measured = self.beat_pressure.take(self.pressure)
        self.pressure += self.parameters.relaxation * (measured - self.pressure)
        self.injected_before = self.injected
        self.beats += 1
        self._open_beat()

    def _open_beat(self) -> None:
        self.beat = BeatFlow.starting(self.beats * self.port.period, self.port.bleed(self.pressure))

    def _note(self) -> str:
        return (
            f"{self.injected / MILLILITRE:.1f} ml, {self.solver.particle_count} particles, "
            f"wound {self.pressure / MILLIMETRE_OF_MERCURY:.0f} mmHg"
        )

    def state(self) -> CheckpointData:
        """What a run that goes on from here needs, the solver's own state included."""
        data: dict[str, CheckpointValue] = {
            "beats": self.beats,
            "frames": self.frames,
            "samples": self.samples,
            "pressure": self.pressure,
            "pressure_outside": self.pressure_outside,
            "injected": self.injected,
            "injected_before": self.injected_before,
            "beat_pressure": np.array(self.beat_pressure.parts),
            "sample_pressure": np.array(self.sample_pressure.parts),
            "rows": self.log.table(),
            "mean_flow": np.array(self.log.mean_flow, dtype=float),
            "particle_steps": self.particle_steps,
            "wall": self.wall,
        }
        solver_state = self.solver.state()
        return data | {_SOLVER_PREFIX + name: value for name, value in solver_state.items()}

    def restore(self, data: CheckpointData) -> None:
        """Go back to a saved state; the beat is computed again from its pressure."""
        self.solver.restore(
            {
                name.removeprefix(_SOLVER_PREFIX): value
                for name, value in data.items()
                if name.startswith(_SOLVER_PREFIX)
            }
        )
        self.beats, self.frames, self.samples = (
            int(data[name]) for name in ("beats", "frames", "samples")
        )
        self.pressure = float(data["pressure"])
        self.pressure_outside = float(data["pressure_outside"])
        self.injected = float(data["injected"])
        self.injected_before = float(data["injected_before"])
        self.beat_pressure = RunningMean.of(np.asarray(data["beat_pressure"]))
        self.sample_pressure = RunningMean.of(np.asarray(data["sample_pressure"]))
        self.log = RunLog.from_table(np.asarray(data["rows"]), np.asarray(data["mean_flow"]))
        self.particle_steps, self.wall = float(data["particle_steps"]), float(data["wall"])
        self._open_beat()
        self.finished = self.parameters.duration - self.solver.time < 1e-9

    def outcome(self) -> BleedOutcome:
        """The result of the finished run."""
        return BleedOutcome(
            waveforms=self.log.waveforms(),
            ledger=self.log.ledger(),
            period=self.port.period,
            mean_flow_per_beat=np.array(self.log.mean_flow, dtype=float),
            barrier_crossings=self.solver.barrier_crossings,
            particle_count=self.solver.particle_count,
            steps=self.solver.steps,
            particle_steps_per_second=self.particle_steps / self.wall if self.wall > 0.0 else 0.0,
        )


def _check(parameters: CouplingParameters) -> None:
    """Raise `ScenarioError` for a value outside its range."""
    for name in ("duration", "frame_interval", "sample_interval"):
        value = getattr(parameters, name)
        if not (math.isfinite(value) and value > 0.0):
            raise ScenarioError(
                f"coupling.{name}", f"is {value:g} s, must be positive and finite", "Correct it"
            )
    if not 0.0 < parameters.relaxation <= 1.0:
        raise ScenarioError(
            "coupling.relaxation",
            f"is {parameters.relaxation:g}, must lie in (0, 1]",
            "1 is the paper's plain exchange, 0.5 damps a closed pocket",
        )
    if not math.isfinite(parameters.initial_pressure):
        raise ScenarioError(
            "coupling.initial_pressure", "is not finite", "Give the pressure around the wound"
        )
