"""An experiment: bodies of tissue, rigid bodies, boundaries and sensors; run it, read the result.

experiment = Experiment(grid_spacing=2e-3)
experiment.add_body(Block(size=(0.1, 0.04, 0.04)), material="gelatin_10", name="gel")
experiment.add_sensor(PointSensor(position=(0, 0, 0), name="middle"))
result = experiment.run(until=1e-3)
result.sensor("middle")["pressure"]

Everything is SI: metres, kilograms, seconds, pascals, radians. Positions are in one world frame.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping

import numpy as np

from vulnus.core.arrays import AnyArray, Vector3
from vulnus.core.checkpoint import Checkpoint, CheckpointData
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import LabelVolume
from vulnus.core.progress import Progress, SilentProgress
from vulnus.core.units import MILLISECOND

from . import experiment_checks as checks
from .boundaries import HeldEnds
from .checked_values import not_negative, one_of, positive, vector
from .experiment_particles import Arrangement, ParticleStore, Velocity, fill
from .experiment_record import Record
from .experiment_result import ExperimentResult, Fields, read_fields
from .labelled_bodies import label_bodies
from .materials import Material, material_table
from .particle_reading import JoinedParticles, ParticleReading
from .rotations import Axis, axis_vector
from .sample_schedule import SampleSchedule
from .sensors import Sensor
from .solids import Solid, triple
from .solver import MpmSolver, Precision, set_threads


class Experiment:
    """A case for the material point solver, set up piece by piece and then run.

    `grid_spacing` [m] is the edge of a grid cell; the nodes stand at its whole multiples in the
    world frame, moved by `grid_offset` [m]. `gravity` [m/s²]. `courant_number` scales the time
    step. `precision` is of the particles' arithmetic: "float32" for tissue, "float64" where
    round-off counts. `threads` 0 takes OMP_NUM_THREADS, or all processors where that is not set;
    the result does not depend on it. `lower`
    and `upper` [m] are corners of the box that no particle may leave; without them it lies five
    times the extent of the bodies, and at least 0.5 m, beyond them.
    """

    def __init__(
        self,
        *,
        grid_spacing: float,
        gravity: Vector3 = (0.0, 0.0, 0.0),
        courant_number: float = 0.4,
        precision: Precision = "float32",
        threads: int = 0,
        lower: Vector3 | None = None,
        upper: Vector3 | None = None,
        grid_offset: Vector3 = (0.0, 0.0, 0.0),
    ) -> None:
        self.grid_spacing = positive("grid_spacing", grid_spacing)
        self.gravity = vector("gravity", gravity)
        self.courant_number = checks.courant_number(courant_number)
        one_of("precision", precision, ("float32", "float64"))
        self.precision: Precision = precision
        self.threads = int(not_negative("threads", threads))
        self._box = checks.given_box(lower, upper)
        self._grid_offset = vector("grid_offset", grid_offset)
        self._store = ParticleStore()
        self._held: HeldEnds | None = None
        self._sensors: dict[str, Sensor] = {}
        self._solver: MpmSolver | None = None
        self._particles: JoinedParticles | None = None
        self._record: Record | None = None
        self._snapshots: list[Fields] = []
        self._sample_interval: float | None = None

    def add_body(
        self,
        solid: Solid,
        *,
        material: str | Material,
        velocity: Velocity = (0.0, 0.0, 0.0),
        particles_per_cell: float = 8,
        arrangement: Arrangement = "lattice",
        rotation: AnyArray | None = None,
        seed: int = 0,
        name: str | None = None,
    ) -> str:
        """Fill a solid with particles of a material; returns the body's name.

        `material` is a name in `MATERIALS` or a `Material`; `velocity` [m/s] one vector, an array
        (n, 3), or a function of the positions (n, 3) [m]; `arrangement` "lattice" (along the
        solid's axes) or "poisson" (random, from `seed`); `rotation` turns the solid about its
        centre first. The particles' volumes add up to the solid's. Bodies must not overlap; those
        that touch share the grid and so stick together without friction or gap.
        """
        self._refuse_after_start("add_body")
        turned = solid if rotation is None else solid.rotated(rotation)
        chosen = self._store.free_name(name, "body")
        filled = fill(
            turned,
            point_spacing=self._point_spacing(particles_per_cell),
            arrangement=arrangement,
            seed=seed,
        )
        self._store.add(
            chosen, filled.position, filled.volume, material, velocity=velocity, solid=turned
        )
        return chosen

    def add_points(
        self,
        position: AnyArray,
        *,
        volume: AnyArray | float,
        material: str | Material,
        velocity: Velocity = (0.0, 0.0, 0.0),
        name: str | None = None,
    ) -> str:
        """Add a body as points (n, 3) [m] with a `volume` [m³] for each or for all.

        Where the points lie farther apart than a cell the body falls to pieces.
        """
        self._refuse_after_start("add_points")
        chosen = self._store.free_name(name, "points")
        self._store.add(chosen, position, volume, material, velocity=velocity)
        return chosen

    def add_labels(
        self,
        labels: LabelVolume | AnyArray,
        *,
        materials: Mapping[int, str | Material],
        spacing: Vector3 | float | None = None,
        origin: Vector3 = (0.0, 0.0, 0.0),
        velocity: Velocity = (0.0, 0.0, 0.0),
        particles_per_cell: float = 8,
        names: Mapping[int, str] | None = None,
    ) -> dict[int, str]:
        """Fill the labels of a voxel volume, one body a label; returns label to body name.

        `labels` is a `LabelVolume`, or an array (nx, ny, nz) of whole numbers whose voxel (0, 0, 0)
        is centred at `origin` [m] and whose voxels have the edges `spacing` [m]. `materials` names
        the material of each label to fill; other labels stay empty. A body is called by `names`,
        else "label 3" and so on.
        """
        self._refuse_after_start("add_labels")
        bodies = label_bodies(
            labels,
            wanted=tuple(materials),
            spacing=spacing,
            origin=origin,
            point_spacing=self._point_spacing(particles_per_cell),
        )
        found = {}
        for label, filled in bodies.items():
            wish = (names or {}).get(label, f"label {label}")
            found[label] = self._store.free_name(wish, "label")
            self._store.add(
                found[label], filled.position, filled.volume, materials[label], velocity=velocity
            )
        return found

    def hold_ends(self, *, axis: Axis, lower: float = -1e30, upper: float = 1e30) -> None:
        """Hold the grid where the coordinate along `axis` is outside [lower, upper] [m]."""
        self._refuse_after_start("hold_ends")
        self._held = HeldEnds(axis=triple(axis_vector("axis", axis)), lower=lower, upper=upper)

    def add_sensor(self, sensor: Sensor) -> str:
        """Look at something at every sample; returns the sensor's name."""
        self._refuse_after_start("add_sensor")
        name = checks.free_name(sensor.name, "sensor", self._sensors)
        self._sensors[name] = sensor
        return name

    @property
    def time(self) -> float:
        """Simulated time [s] so far."""
        return self._solver.time if self._solver else 0.0

    @property
    def particle_count(self) -> int:
        """How many particles there are."""
        return self._store.count

    @property
    def solver(self) -> MpmSolver:
        """The solver behind the experiment, ready for its first step or wherever it is."""
        return self._start()

    def fields(self) -> Fields:
        """All particles as they are now."""
        solver = self._start()
        return read_fields(self._reading(solver), self._store.bodies)

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
        hundredth of `until`, or as in the call before) and at the end; snapshots of all particles
        at the multiples of `snapshot_interval` [s]. At each sample `on_sample` is called and `stop_when` may end the
        run by giving True. Call `run` again with a later `until` to go on. `checkpoint` keeps the
        state at samples, when it is due, and a later call of the same experiment goes on from it.
        Raises `UnstableStepError` where a particle inverts, flies out of the box or is not finite.
        """
        schedule = SampleSchedule.of(
            self.time, until, sample_interval or self._sample_interval, snapshot_interval
        )
        self._sample_interval = schedule.sample_interval
        set_threads(self.threads or int(os.environ.get("OMP_NUM_THREADS", "0")))
        solver = self._start()
        record = self._recorder(solver, schedule, checkpoint)
        bar = progress or SilentProgress()
        bar.begin("experiment", until / MILLISECOND, "ms")
        stopped = False
        for time in schedule.after(solver.time):
            solver.advance(
                time, on_call=lambda: bar.update(solver.time / MILLISECOND, f"{solver.steps} steps")
            )
            self._sample(solver, record, schedule)
            if on_sample is not None:
                on_sample(self)
            if checkpoint is not None and checkpoint.due():
                checkpoint.save(self._state(solver, record))
            if stop_when is not None and stop_when(self):
                stopped = True
                break
        bar.end()
        return self._result(solver, record, stopped_early=stopped)

    def _refuse_after_start(self, what: str) -> None:
        if self._solver is not None:
            raise ScenarioError(
                what, "the experiment has begun", "Add everything first, or make a new Experiment."
            )

    def _point_spacing(self, particles_per_cell: float) -> float:
        return self.grid_spacing / positive("particles_per_cell", particles_per_cell) ** (1 / 3)

    def _start(self) -> MpmSolver:
        """The solver; made and filled at the first call."""
        if self._solver is None:
            particles = self._checked_particles()
            lower, upper = checks.box_around(
                particles.position, self._box, self.grid_spacing, self._grid_offset
            )
            self._solver = MpmSolver(
                materials=material_table(self._store.materials, self.grid_spacing),
                grid_spacing=self.grid_spacing,
                lower=lower,
                upper=upper,
                courant_number=self.courant_number,
                gravity=self.gravity,
                boundaries=[self._held] if self._held is not None else [],
                precision=self.precision,
            )
            self._solver.set_particles(
                particles.position,
                volume=particles.volume,
                material=particles.material_row,
                velocity=particles.velocity,
            )
            self._particles = particles
        return self._solver

    def _checked_particles(self) -> JoinedParticles:
        self._store.check()
        for filling in self._store.fillings:
            if filling.solid is not None:
                checks.body_resolved(filling.name, filling.solid, self.grid_spacing, confined=False)
        checks.bodies_apart(self._store.fillings)
        return self._store.joined()

    def _reading(self, solver: MpmSolver) -> ParticleReading:
        assert self._particles is not None  # made with the solver
        return ParticleReading(solver, self._particles, self._store.bodies)

    def _recorder(
        self, solver: MpmSolver, schedule: SampleSchedule, checkpoint: Checkpoint | None
    ) -> Record:
        """The record, with its first sample or with what a checkpoint kept."""
        if self._record is not None:
            return self._record
        reading = self._reading(solver)
        sensors = {
            name: sensor.attach(reading, self.grid_spacing)
            for name, sensor in self._sensors.items()
        }
        self._record = Record(gravity=self.gravity, bodies=self._store.bodies, sensors=sensors)
        saved = checkpoint.load() if checkpoint is not None else None
        if saved is None:
            self._sample(solver, self._record, schedule)
        else:
            checks.same_experiment(str(saved["fingerprint"]), self._fingerprint())
            solver.restore(saved)
            self._record.restore(saved)
        return self._record

    def _sample(self, solver: MpmSolver, record: Record, schedule: SampleSchedule) -> None:
        reading = self._reading(solver)
        record.add(solver, reading)
        if schedule.is_snapshot(solver.time):
            self._snapshots.append(read_fields(reading, self._store.bodies))

    def _result(
        self, solver: MpmSolver, record: Record, *, stopped_early: bool
    ) -> ExperimentResult:
        return ExperimentResult(
            columns=record.columns,
            final=self.fields(),
            snapshots=tuple(self._snapshots),
            steps=solver.steps,
            stopped_early=stopped_early,
        )

    def _state(self, solver: MpmSolver, record: Record) -> CheckpointData:
        return {**solver.state(), **record.state(), "fingerprint": self._fingerprint()}

    def _fingerprint(self) -> str:
        """A short text that differs between experiments that would run differently."""
        assert self._particles is not None  # made with the solver
        digest = hashlib.sha256()
        particles = self._particles
        for array in (particles.position, particles.volume, particles.velocity):
            digest.update(np.ascontiguousarray(array).tobytes())
        digest.update(particles.material_row.tobytes())
        numbers = (self.grid_spacing, self.gravity, self.courant_number, self.precision)
        digest.update(repr((numbers, self._store.materials, self._held)).encode())
        return digest.hexdigest()
