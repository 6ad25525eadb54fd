import numpy as np
from numpy.typing import NDArray

from vulnus.core.arrays import AnyArray, Float32Array, FloatArray, IntArray, LabelArray, Vector3

class BodyShape:
    @staticmethod
    def make(
        *,
        radius: float,
        expansion_speed: float,
        distance: Float32Array,
        distance_lower: Vector3,
        distance_spacing: float,
        lower: Vector3,
        upper: Vector3,
        inner_radius: float,
    ) -> BodyShape: ...

class RigidBody:
    @staticmethod
    def make(
        *,
        motion: int,
        mass: float,
        inertia: FloatArray,
        inverse_inertia: FloatArray,
        friction: float,
        margin: float,
        cutting: bool,
        path: FloatArray,
    ) -> RigidBody: ...

class Solver32:
    def __init__(
        self,
        *,
        materials: FloatArray,
        grid_spacing: float,
        courant_number: float,
        gravity: Vector3,
        domain_lower: Vector3,
        domain_upper: Vector3,
        largest_step: float,
    ) -> None: ...
    def add_body(self, shape: BodyShape, body: RigidBody, state: FloatArray) -> None: ...
    def add_boundary(
        self,
        *,
        kind: int,
        normal: Vector3,
        height: float,
        velocity: Vector3,
        friction: float,
        thickness: float,
        rate: float,
    ) -> None: ...
    def body_state(self) -> FloatArray: ...
    def set_body_state(self, state: FloatArray) -> None: ...
    def set_particles(
        self, position: FloatArray, velocity: FloatArray, volume: FloatArray, material: LabelArray
    ) -> None: ...
    def values(self, first: int, count: int) -> AnyArray: ...
    def set_values(self, first: int, values: FloatArray) -> None: ...
    def set_tracers(self, position: FloatArray) -> None: ...
    def tracer_state(self) -> FloatArray: ...
    def state_fields(self) -> AnyArray: ...
    def state_id(self) -> IntArray: ...
    def state_material(self) -> LabelArray: ...
    def restore(
        self,
        fields: AnyArray,
        id: IntArray,
        material: LabelArray,
        tracers: FloatArray,
        time: float,
        steps: int,
        sound_speed: float,
    ) -> None: ...
    def totals(self, *, grid: bool) -> dict[str, float | Vector3]: ...
    def advance(self, max_steps: int, stop_time: float) -> int: ...
    def scatter_only(self, step_size: float) -> None: ...
    def gather_only(self, step_size: float) -> None: ...
    @property
    def synchronized(self) -> bool: ...
    @property
    def time(self) -> float: ...
    @property
    def steps(self) -> int: ...
    @property
    def step_size(self) -> float: ...
    @property
    def sound_speed(self) -> float: ...
    @property
    def memory_bytes(self) -> int: ...
    @property
    def fault_bits(self) -> int: ...
    @property
    def fault_particle(self) -> int: ...
    @property
    def fault_body(self) -> int: ...

class Solver64(Solver32): ...

def return_map32(
    table: FloatArray, material: LabelArray, state: FloatArray, rate: FloatArray
) -> NDArray[np.float64]: ...
def return_map64(
    table: FloatArray, material: LabelArray, state: FloatArray, rate: FloatArray
) -> NDArray[np.float64]: ...
def set_num_threads(count: int) -> None: ...
