"""One body of fluid in the native solver: set up, moved on, read, kept and restored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, Float32Array, FloatArray, IntArray, Vector3
from vulnus.core.checkpoint import CheckpointValue
from vulnus.core.constants import BLOOD_DENSITY, BLOOD_VISCOSITY
from vulnus.core.errors import StorageError, UnstableStepError

from . import _native
from .parameters import KernelSet

CHUNK_WALL_TIME = 0.15
"""Wall time of one native call [s]; chosen: Ctrl-C is answered between calls."""

FAULTS = {1: "speed beyond four times the speed of sound or not finite", 16: "step too small"}
"""Fault bits of the native solver in words."""

SCALARS = (
    "time",
    "largest_speed",
    "largest_acceleration",
    "steps",
    "particle_steps",
    "removed",
    "crossings",
    "pushed",
    "searches",
    "stale",
    "list_margin",
    "injected",
    "pending",
    "draws",
    "next_id",
    "pressure_time",
    "sampled_time",
)
"""Numbers of the native solver that cannot be derived."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FluidParameters:
    """A weakly compressible fluid as particles; SI. Fields as in `HemorrhageParameters`."""

    particle_spacing: float
    smoothing_ratio: float = 2.3
    sound_speed: float = 30.0
    density: float = BLOOD_DENSITY
    viscosity: float = BLOOD_VISCOSITY
    courant_number: float = 0.25
    kernels: KernelSet = "wendland_c2"
    """Smoothing kernels: "mueller2003" are the paper's three (poly6, spiky, viscosity)."""
    pressure_clamped: bool = True
    as_printed: bool = False
    dissipation: float = 3.0
    """Factor of the pair dissipation of Zhang, Hu & Adams 2017 (their value: 3); 0 = none."""
    time_step: float = 0.0
    """A fixed step [s]; 0 = adaptive."""

    @property
    def smoothing_length(self) -> float:
        """Cut-off radius h of the kernels [m]."""
        return self.smoothing_ratio * self.particle_spacing

    def native(self) -> _native.FluidSettings:
        """The native settings, with sums that are exact on the rest lattice.

        As printed, the sums stay as they are and the rest density is measured the same way.
        """
        settings = _native.FluidSettings()
        settings.spacing = self.particle_spacing
        settings.smoothing = self.smoothing_length
        settings.sound_speed = self.sound_speed
        settings.density = settings.rest_density = self.density
        settings.viscosity = self.viscosity
        settings.courant = self.courant_number
        settings.fixed_step = self.time_step
        settings.clamped = self.pressure_clamped and not self.as_printed
        settings.as_printed = self.as_printed
        settings.dissipation = 0.0 if self.as_printed else self.dissipation
        paper = self.kernels == "mueller2003" or self.as_printed
        sums = _native.lattice_sums_mueller2003 if paper else _native.lattice_sums_wendland_c2
        whole, others, gradient, laplacian = sums(self.smoothing_length, self.particle_spacing)
        settings.kernels = _native.KernelSet.MUELLER2003 if paper else _native.KernelSet.WENDLAND_C2
        if self.as_printed:
            settings.rest_density = self.density * others
        else:
            settings.density_scale = 1.0 / whole
            settings.gradient_scale = 1.0 / gradient
            settings.laplacian_scale = 1.0 / laplacian
        return settings


class Fluid:
    """Particles of a fluid between barriers, in the patient's (or a tank's) frame [m].

    `origin` [m] is the local origin of the single precision arithmetic: put it where things
    happen. `double` computes in double precision, for validation.
    """

    name = "fluid solver"

    def __init__(
        self,
        parameters: FluidParameters,
        *,
        origin: Vector3 = (0.0, 0.0, 0.0),
        gravity: Vector3 = (0.0, 0.0, 0.0),
        threads: int = 0,
        double: bool = False,
    ) -> None:
        solver = _native.BleedingSolver64 if double else _native.BleedingSolver32
        self.parameters = parameters
        self.origin = np.array(origin, dtype=np.float64)
        self.native: _native.BleedingSolver32 = solver(parameters.native())
        self.native.gravity = gravity
        self.native.threads = threads if threads > 0 else _native.available_threads()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.native.time

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return self.native.steps

    @property
    def particle_count(self) -> int:
        """Fluid particles at present."""
        return self.native.count

    @property
    def position(self) -> FloatArray:
        """Positions (n, 3) [m]."""
        return self.native.position + self.origin

    @property
    def velocity(self) -> Float32Array:
        """Velocities (n, 3) [m/s]."""
        return self.native.velocity

    @property
    def pressure(self) -> Float32Array:
        """Pressures (n,) [Pa]."""
        return self.native.pressure

    @property
    def density(self) -> Float32Array:
        """Densities (n,) [kg/m³]."""
        return self.native.density

    @property
    def id(self) -> IntArray:
        """Names of the particles (n,), in order of appearance; arrays are not in their order."""
        return self.native.id

    @property
    def barrier_crossings(self) -> int:
        """How often a particle was found half a spacing deep in a wall, and put back."""
        return self.native.crossings

    @property
    def particle_volume(self) -> float:
        """Volume that one particle stands for [m³]."""
        return self.parameters.particle_spacing**3

    def local(self, points: AnyArray) -> FloatArray:
        """Points (n, 3) [m] relative to the local origin, contiguous."""
        return np.ascontiguousarray(np.asarray(points, dtype=np.float64) - self.origin)

    def set_gravity(self, gravity: Vector3) -> None:
        """Body force per mass from now on [m/s²]."""
        self.native.gravity = gravity

    def advance(
        self,
        until: float,
        flow_rate: tuple[FloatArray, FloatArray] | None = None,
        on_chunk: Callable[[float], None] | None = None,
    ) -> None:
        """Go to the time `until` [s] exactly.

        `flow_rate` (times [s], values [m³/s]) feeds the source, linear between samples.
        `on_chunk` is told the simulated time several times a second of wall time. Raises
        UnstableStepError with the particle's place where a step goes wrong.
        """
        while not self.step_chunk(until, flow_rate):
            if on_chunk is not None:
                on_chunk(self.time)
        if on_chunk is not None:
            on_chunk(self.time)

    def step_chunk(
        self,
        until: float,
        flow_rate: tuple[FloatArray, FloatArray] | None = None,
        *,
        step_limit: int = 1_000_000_000,
        wall_time: float = CHUNK_WALL_TIME,
    ) -> bool:
        """Step towards `until` [s] for about `wall_time` [s]; True when it is reached."""
        times, values = (np.zeros(1), np.zeros(1)) if flow_rate is None else flow_rate
        reached = self.native.advance(
            until,
            np.ascontiguousarray(times, dtype=np.float64),
            np.ascontiguousarray(values, dtype=np.float64),
            step_limit,
            wall_time,
        )
        if self.native.fault:
            self._raise_fault()
        return reached

    def _raise_fault(self) -> None:
        place = np.array(self.native.fault_position) + self.origin
        raise UnstableStepError.at(
            self.name,
            FAULTS.get(self.native.fault, f"fault {self.native.fault}"),
            "Raise sound_speed_m_per_s above ten times the fastest blood, or lower courant_number.",
            time=self.native.time,
            step=self.native.steps,
            particle=self.native.fault_id,
            position=(float(place[0]), float(place[1]), float(place[2])),
        )

    def state(self) -> dict[str, CheckpointValue]:
        """What cannot be derived: restored, the run goes on to the same bits."""
        kept: dict[str, CheckpointValue] = dict(self.native.kept_arrays())
        for name in SCALARS:
            value = getattr(self.native, name)
            kept[name] = int(value) if isinstance(value, bool) else value
        return kept

    def restore(self, state: Mapping[str, CheckpointValue]) -> None:
        """Go back to a state that `state` gave, of the same scene.

        Raises StorageError where it is another scene's.
        """
        walls = len(np.asarray(state["barrier_pressure"]))
        if walls != len(self.native.barrier_weight):
            raise StorageError(
                "checkpoint of the bleeding",
                f"has {walls} barrier particles, the limb {len(self.native.barrier_weight)}",
                "Run without --resume, or resume with the scenario that wrote it.",
            )
        for name in SCALARS:
            value = state[name]
            present = getattr(self.native, name)
            setattr(self.native, name, type(present)(value))
        arrays = {k: np.ascontiguousarray(v) for k, v in state.items() if k not in SCALARS}
        self.native.restore_arrays(arrays)
