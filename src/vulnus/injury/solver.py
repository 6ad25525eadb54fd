"""The material point solver as a Python object: bodies in, steps, fields out.

solver = MpmSolver(materials=table, grid_spacing=0.002, lower=(-0.1,) * 3, upper=(0.1,) * 3)
solver.set_particles(position, volume=volume, material=material)
solver.advance(until=1e-3)
solver.position, solver.damage
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, LabelArray, Vector3
from vulnus.core.checkpoint import CheckpointData
from vulnus.core.errors import ScenarioError, StorageError

from . import _native
from .bodies.rigid_body import STATE_SIZE, BodyState, RigidBody, add_body
from .boundaries import Boundary, add_boundaries
from .checked_values import positive
from .material_change import bearable, same_bodies
from .solver_faults import body_fault, particle_fault

Precision = Literal["float32", "float64"]

# Where a quantity stands among the native fields (particle_set.hpp).
POSITION, VELOCITY, GRADIENT, STRAIN, PLASTIC_STRAIN, OPENING = 0, 3, 6, 15, 22, 23
DAMAGE, NETWORK_STRAIN = 24, 25
# xx yy zz xy yz zx as a matrix.
FULL_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])

PARTICLES_AT_ONCE = 1 << 18  # chosen: 12 MB of copies instead of those of all particles
PASSAGE_STEPS = 8
"""Steps for which the nodes keep their momentum where rigid bodies move, until something has moved
by a quarter of a cell. Chosen: from 4 on the drag of a sphere at 180 m/s no longer depends on the
bulk modulus. Without bodies momentum passes at every step: that calms the noise of slow loading."""
WALL_TIME_OF_A_CALL = 0.15  # [s]: Ctrl-C is answered between native calls


class MpmSolver:
    """MLS-MPM/APIC with quadratic B-splines on a sparse grid; Equation: Chong2017 (1).

    `materials` holds one row a material (`materials.material_table`); `lower` and `upper` [m] span
    the box that no particle may leave; `bodies` move among the tissue, `boundaries` hold it. The
    result does not depend on the number of threads.
    """

    def __init__(
        self,
        *,
        materials: FloatArray,
        grid_spacing: float,
        lower: Vector3,
        upper: Vector3,
        courant_number: float = 0.4,
        gravity: Vector3 = (0.0, 0.0, 0.0),
        bodies: Sequence[RigidBody] = (),
        boundaries: Sequence[Boundary] = (),
        largest_step: float = 1e30,
        precision: Precision = "float32",
        passage_steps: int | None = None,
    ) -> None:
        positive("grid_spacing", grid_spacing)
        positive("courant_number", courant_number)
        self._origin = 0.5 * (np.array(lower) + np.array(upper))
        self._materials = np.ascontiguousarray(materials, dtype=np.float64)
        self.grid_spacing = grid_spacing
        kind = _native.Solver32 if precision == "float32" else _native.Solver64
        self._native = kind(
            materials=self._materials,
            grid_spacing=grid_spacing,
            courant_number=courant_number,
            gravity=gravity,
            domain_lower=_vector(lower - self._origin),
            domain_upper=_vector(upper - self._origin),
            largest_step=largest_step,
            passage_steps=passage_steps or (PASSAGE_STEPS if bodies else 1),
        )
        self._body_names = tuple(body.name for body in bodies)
        for body in bodies:
            add_body(self._native, body, origin=self._origin, grid_spacing=grid_spacing)
        self._boundaries = tuple(boundaries)
        self._match_boundaries()
        self._energy_of_changes = 0.0
        self._material = np.zeros(0, np.uint8)
        self._steps_per_call = 1

    def set_particles(
        self,
        position: AnyArray,
        *,
        volume: AnyArray,
        material: LabelArray,
        velocity: AnyArray | None = None,
    ) -> None:
        """Put in the particles: `position` (n, 3) [m], `volume` (n,) [m³], `material` (n,) rows."""
        where, sizes = np.asarray(position), np.asarray(volume)
        speed = None if velocity is None else np.asarray(velocity)
        self._material = np.ascontiguousarray(material, dtype=np.uint8)
        lengths = {len(a) for a in (where, sizes, self._material, speed) if a is not None}
        if len(lengths) != 1:
            told = f"arrays have the lengths {sorted(lengths)}"
            raise ScenarioError("particles", told, "Give each n rows.")
        if self._material.max(initial=0) >= len(self._materials):
            raise ScenarioError(
                "material",
                f"row {self._material.max()} of a table of {len(self._materials)}",
                "Give every particle a row of the material table.",
            )
        if not np.all(sizes > 0.0):
            raise ScenarioError("volume", f"is {np.min(sizes)} m³, must be > 0", "Leave it out.")
        self._native.make_particles(len(where))
        for first in range(0, len(where), PARTICLES_AT_ONCE):
            part = slice(first, first + PARTICLES_AT_ONCE)
            local = np.ascontiguousarray(where[part] - self._origin, dtype=np.float64)
            moving = np.zeros_like(local) if speed is None else speed[part]
            self._native.set_particles(
                first,
                local,
                np.ascontiguousarray(moving, dtype=np.float64),
                np.ascontiguousarray(sizes[part], dtype=np.float64),
                self._material[part],
            )

    def set_point_state(self, state: FloatArray) -> None:
        """Begin with strains and damage: (n, 15) b_e - I, plastic strain, opening, damage, b - I.

        In the order of `set_particles`; strains as xx yy zz xy yz zx, the last of the network.
        """
        self._native.set_values(STRAIN, np.ascontiguousarray(state[:, :6], dtype=np.float64))
        rest = np.ascontiguousarray(state[:, 6:], dtype=np.float64)
        self._native.set_values(PLASTIC_STRAIN, rest)

    def _match_boundaries(self) -> None:
        add_boundaries(
            self._native, self._boundaries, origin=self._origin, grid_spacing=self.grid_spacing,
            materials=self._materials,
        )  # fmt: skip

    def set_tracers(self, position: FloatArray) -> None:
        """Put in massless points (n, 3) [m] that move with the material."""
        self._native.set_tracers(np.ascontiguousarray(position - self._origin))

    def advance(
        self, until: float, *, on_call: Callable[[], None] | None = None, max_steps: int = 2**31
    ) -> int:
        """Step to the time `until` [s] (or `max_steps`); returns the number of steps.

        `on_call` is called between native calls, a few times a second. Raises `UnstableStepError`.
        """
        done = 0
        while self.time < until and done < max_steps:
            done += self._call(min(self._steps_per_call, max_steps - done), until, until)
            if on_call is not None:
                on_call()
        return done

    def advance_epoch(
        self, until: float, *, then: float = 0.0, on_call: Callable[[], None] | None = None
    ) -> None:
        """Step to the end of the epoch, at most 64 steps, or to `until` [s].

        Only at an epoch's end can the state be saved. Where epochs end does not depend on the
        calls. At `until` the epoch ends too, unless the run is to go on to a later time `then` [s]:
        momentum that passes from nodes to particles and back loses some energy, so that a look at
        every sample must not end an epoch. `settle` ends it all the same.
        """
        reported = clock.perf_counter()
        self._call(1, until, then)
        while not self.synchronized and self.time < until:
            self._call(1, until, then)
            if on_call is not None and clock.perf_counter() > reported + WALL_TIME_OF_A_CALL:
                reported = clock.perf_counter()
                on_call()
        if on_call is not None:
            on_call()

    def settle(self) -> None:
        """End the epoch where `advance_epoch` stopped for a look: the state can be saved."""
        self._native.settle()

    def _call(self, steps: int, until: float, then: float) -> int:
        start = clock.perf_counter()
        taken = self._native.advance(steps, until, then)
        self._raise_fault()
        wall = max(clock.perf_counter() - start, 1e-6)
        if taken > 0:  # not only the start of an epoch
            wanted = int(taken * WALL_TIME_OF_A_CALL / wall)
            self._steps_per_call = min(max(wanted, 1), 2 * self._steps_per_call)
        return taken

    def _raise_fault(self) -> None:
        bits, body = self._native.fault_bits, self._native.fault_body
        if body >= 0:
            raise body_fault(self, bits, body)
        if bits:
            raise particle_fault(self, bits, self._native.fault_particle)

    @property
    def synchronized(self) -> bool:
        """Whether the particles hold the whole state (always after `advance` reached `until`)."""
        return self._native.synchronized

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._native.time

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return self._native.steps

    @property
    def step_size(self) -> float:
        """The newest time step [s]."""
        return self._native.step_size

    @property
    def memory_bytes(self) -> int:
        """Bytes that particles, grid and sorting hold."""
        return self._native.memory_bytes

    @property
    def position(self) -> FloatArray:
        """Positions (n, 3) [m] in the order of `set_particles`."""
        local: FloatArray = np.asarray(self._native.positions(), np.float64)
        local += self._origin
        return local

    @property
    def velocity(self) -> AnyArray:
        """Velocities (n, 3) [m/s]; of the end of the newest epoch, or of the newest look."""
        return self._native.values(VELOCITY, 3)

    @property
    def elastic_left_cauchy_green(self) -> AnyArray:
        """Left Cauchy-Green tensor (n, 3, 3) of the elastic part of the deformation."""
        tensor: AnyArray = self._native.values(STRAIN, 6)[:, FULL_TENSOR] + np.eye(3)
        return tensor

    @property
    def plastic_strain(self) -> AnyArray:
        """Equivalent plastic strain (n,)."""
        return self._native.values(PLASTIC_STRAIN, 1)[:, 0]

    @property
    def opening(self) -> AnyArray:
        """Logarithmic volume strain (n,) of open voids and cracks."""
        return self._native.values(OPENING, 1)[:, 0]

    @property
    def damage(self) -> AnyArray:
        """Damage (n,), 0 intact to 1 without strength."""
        return self._native.values(DAMAGE, 1)[:, 0]

    @property
    def stress(self) -> AnyArray:
        """Cauchy stress (n, 3, 3) [Pa], tension positive."""
        return self._native.stress()[:, FULL_TENSOR]

    @property
    def pressure(self) -> AnyArray:
        """Mean of the compressive stresses (n,) [Pa], -tr(stress)/3."""
        pressure: AnyArray = -np.mean(self._native.stress()[:, :3], axis=1)
        return pressure

    @property
    def volume_ratio(self) -> AnyArray:
        """Volume over undeformed volume J (n,), with open voids and cracks."""
        return self._native.stress()[:, 6]

    def energies(self) -> dict[str, float]:
        """Energy [J] of the particles: `kinetic` of their motion, `elastic` stored as strain."""
        kinetic, elastic = self._native.energies()
        return {"kinetic": kinetic, "elastic": elastic}

    @property
    def materials(self) -> FloatArray:
        """Rows of the table of materials that hold now; not to be written to."""
        return self._materials

    def change_materials(self, materials: FloatArray) -> None:
        """Go on with other constants (`materials.slowed`) under unchanged stress.

        Elastic strains are rescaled so that the Kirchhoff stress of every particle stays; the
        volume ratio changes with the bulk modulus, and so does the stored energy, by what is added
        to `energy_of_changes`. Densities and networks must stay as they are. `AbsorbingEnds` take
        up the waves of the new constants from now on.
        """
        if not self.synchronized:
            raise ScenarioError(
                "materials", "changed in the middle of an epoch", "Change them after `advance(t)`."
            )
        rows = np.ascontiguousarray(materials, dtype=np.float64)
        same_bodies(self._materials, rows)
        bearable(self._native.largest_strain_with(rows))
        self._energy_of_changes += self._native.set_materials(rows, rescale=True)
        self._materials = rows
        self._match_boundaries()

    @property
    def energy_of_changes(self) -> float:
        """Elastic energy [J] that `change_materials` has made so far: softer stores more.

        What was lost is the fall of all energies, and this.
        """
        return self._energy_of_changes

    @property
    def tracers(self) -> tuple[FloatArray, FloatArray]:
        """Tracer positions (n, 3) [m] and their smallest distance (n,) [m] to any body so far."""
        state = self._native.tracer_state()
        return state[:, :3] + self._origin, state[:, 3]

    @property
    def bodies(self) -> tuple[BodyState, ...]:
        """The bodies now, in the order of the constructor.

        A body that has left the tissue flies on freely, also out of the domain.
        """
        rows = self._native.body_state()
        return tuple(
            BodyState.from_row(name, row, self._origin)
            for name, row in zip(self._body_names, rows, strict=True)
        )

    def totals(self, *, grid: bool = False) -> dict[str, float | Vector3]:
        """Mass, momentum, angular momentum and kinetic energy of the particles or of the nodes."""
        return self._native.totals(grid=grid)

    def state(self) -> CheckpointData:
        """Everything that a later `restore` needs to go on with the same bits."""
        if not self.synchronized:
            raise StorageError(
                "material point state",
                "asked for in the middle of an epoch",
                "Save when synchronized.",
            )
        return {
            "fields": self._native.state_fields(),
            "id": self._native.state_id(),
            "material": self._native.state_material(),
            "tracers": self._native.tracer_state(),
            "bodies": self._native.body_state(),
            "materials": self._materials,
            "energy_of_changes": self._energy_of_changes,
            "time": self._native.time,
            "steps": self._native.steps,
            "sound_speed": self._native.sound_speed,
        }

    def restore(self, state: CheckpointData) -> None:
        """Go on from what `state` returned."""
        fields, ids = np.asarray(state["fields"]), np.asarray(state["id"], np.int32)
        if np.count_nonzero(ids >= 0) != len(self._material):
            raise StorageError(
                "injury checkpoint",
                f"holds {np.count_nonzero(ids >= 0)} particles, the limb {len(self._material)}",
                "Start the run anew without --resume.",
            )
        bodies = np.ascontiguousarray(state["bodies"], dtype=np.float64)
        if bodies.shape != (len(self._body_names), STATE_SIZE):
            raise StorageError(
                "injury checkpoint",
                f"holds {len(bodies)} bodies, the case {len(self._body_names)}",
                "Start the run anew without --resume.",
            )
        self._materials = np.ascontiguousarray(state["materials"], dtype=np.float64)
        self._native.set_materials(self._materials, rescale=False)
        self._energy_of_changes = float(state["energy_of_changes"])
        self._match_boundaries()
        self._native.set_body_state(bodies)
        self._native.restore(
            np.ascontiguousarray(fields),
            np.ascontiguousarray(ids),
            np.ascontiguousarray(state["material"], dtype=np.uint8),
            np.ascontiguousarray(state["tracers"], dtype=np.float64),
            float(state["time"]),
            int(state["steps"]),
            float(state["sound_speed"]),
        )


def set_threads(count: int) -> None:
    """Use `count` threads in this process, 0 for all processors."""
    _native.set_num_threads(count)


def _vector(values: AnyArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
