"""Any tank, obstacle, porous block, body force and source, without a limb.

scene = FluidScene(FluidParameters(particle_spacing=5e-3), gravity=(0.0, 0.0, -9.81))
scene.add_container((0, 0, 0), (0.2, 0.1, 0.3), open_faces=("+z",))
scene.fill_box((0, 0, 0), (0.2, 0.1, 0.1))
fluid = scene.build()
fluid.advance(0.5)
fluid.position, fluid.velocity, fluid.pressure
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3

from . import _native
from .fluid import Fluid, FluidParameters

FACES = ("-x", "+x", "-y", "+y", "-z", "+z")
"""Names of a box's faces by the direction out of it."""


def box_lattice(
    lower: Sequence[float] | FloatArray, upper: Sequence[float] | FloatArray, spacing: float
) -> FloatArray:
    """Centres (n, 3) [m] of the cubes of side `spacing` that fill a box, centred in it."""
    axes = []
    for low, high in zip(lower, upper, strict=True):
        count = max(0, round((high - low) / spacing))
        axes.append(0.5 * (low + high) + spacing * (np.arange(count) - 0.5 * (count - 1)))
    mesh = np.meshgrid(*axes, indexing="ij")
    return np.stack([m.ravel() for m in mesh], axis=1)


class FluidScene:
    """What stands where before the fluid moves; `build` turns it into a `Fluid`."""

    def __init__(
        self, parameters: FluidParameters, *, gravity: Vector3 = (0.0, 0.0, 0.0), threads: int = 0
    ) -> None:
        self.parameters = parameters
        self.gravity = gravity
        self.threads = threads
        self._fluid: list[tuple[FloatArray, FloatArray]] = []
        self._walls: list[FloatArray] = []
        self._periodic: dict[int, tuple[float, float]] = {}
        self._porous: list[tuple[FloatArray, FloatArray, float, float]] = []
        self._source: tuple[Vector3, float, int] | None = None
        self._net: tuple[FloatArray, FloatArray] | None = None
        self._domain: tuple[Vector3, Vector3] | None = None

    def add_fluid(self, position: AnyArray, velocity: AnyArray | None = None) -> None:
        """Particles at `position` (n, 3) [m] with `velocity` (n, 3) [m/s] or at rest."""
        points = np.ascontiguousarray(position, dtype=np.float64)
        speeds = np.zeros_like(points) if velocity is None else np.asarray(velocity, np.float64)
        self._fluid.append((points, np.ascontiguousarray(speeds)))

    def fill_box(self, lower: Sequence[float], upper: Sequence[float]) -> None:
        """Fluid at rest between two corners [m], on a lattice."""
        self.add_fluid(box_lattice(lower, upper, self.parameters.particle_spacing))

    def add_obstacle(self, position: AnyArray) -> None:
        """Stationary particles (n, 3) [m], at most a particle spacing apart."""
        self._walls.append(np.ascontiguousarray(position, dtype=np.float64))

    def add_obstacle_box(self, lower: Sequence[float], upper: Sequence[float]) -> None:
        """A solid block between two corners [m]."""
        self.add_obstacle(box_lattice(lower, upper, self.parameters.particle_spacing))

    def add_container(
        self,
        lower: Sequence[float],
        upper: Sequence[float],
        *,
        open_faces: Sequence[str] = (),
        safety_net: bool = False,
    ) -> None:
        """Walls around a box [m], thick enough for the kernel, but for the open faces.

        `safety_net` also pushes back what gets through (a closed container only).
        """
        dx = self.parameters.particle_spacing
        layers = int(np.ceil(self.parameters.smoothing_ratio))
        low, high = np.array(lower, dtype=float), np.array(upper, dtype=float)
        points = box_lattice(low - layers * dx, high + layers * dx, dx)
        closed = np.ones(len(points), dtype=bool)
        for name in open_faces:
            axis, sign = FACES.index(name) // 2, FACES.index(name) % 2
            beyond = points[:, axis] > high[axis] if sign else points[:, axis] < low[axis]
            closed &= ~beyond
        inside = ((points > low) & (points < high)).all(axis=1)
        self.add_obstacle(points[closed & ~inside])
        if safety_net:
            self._net = (low, high)

    def set_periodic(self, axis: int, lower: float, upper: float) -> None:
        """What leaves at `upper` [m] along an axis comes in at `lower`."""
        self._periodic[axis] = (lower, upper)

    def add_porous_block(
        self,
        lower: Sequence[float],
        upper: Sequence[float],
        *,
        porosity: float,
        permeability: float,
    ) -> None:
        """Tissue of one porosity and permeability K [m²] between two corners [m]."""
        self._porous.append(
            (np.array(lower, float), np.array(upper, float), porosity, permeability)
        )

    def set_source(self, center: Vector3, *, radius: float = 1.5e-3, seed: int = 1) -> None:
        """A spherical shell [m] on which `Fluid.advance` lets its flow rate in."""
        self._source = (center, radius, seed)

    def set_domain(self, lower: Vector3, upper: Vector3) -> None:
        """Particles outside these corners [m] are taken out."""
        self._domain = (lower, upper)

    def build(self, *, double: bool = False) -> Fluid:
        """The fluid, ready to advance; in double precision if asked for."""
        fluid = Fluid(self.parameters, gravity=self.gravity, threads=self.threads, double=double)
        native = fluid.native
        for points, speeds in self._fluid:
            native.add_particles(points, speeds)
        if self._walls:
            native.set_barrier(np.concatenate(self._walls))
        for axis, (low, high) in self._periodic.items():
            native.set_periodic(axis, low, high - low)
        if self._porous:
            self._build_porous(native)
        if self._net is not None:
            self._build_net(native)
        if self._source is not None:
            center, radius, seed = self._source
            native.set_source(center, radius, 0.0, seed)
        if self._domain is not None:
            native.set_domain(*self._domain)
        return fluid

    def _build_porous(self, native: _native.BleedingSolver32) -> None:
        cell = self.parameters.particle_spacing
        low = np.min([block[0] for block in self._porous], axis=0) - 2.5 * cell
        high = np.max([block[1] for block in self._porous], axis=0) + 2.5 * cell
        shape = np.ceil((high - low) / cell).astype(int) + 1
        axes = [low[a] + cell * np.arange(shape[a]) for a in range(3)]
        porosity = np.ones(shape, dtype=np.float32)
        log_rate = np.full(shape, _native.FREE_LOG_RATE, dtype=np.float32)
        p = self.parameters
        for lower, upper, eps, permeability in self._porous:
            inside = [(axes[a] > lower[a]) & (axes[a] < upper[a]) for a in range(3)]
            block = np.ix_(*inside)
            porosity[block] = eps
            rate = _native.drag_rate(eps, p.viscosity, p.density, permeability)
            log_rate[block] = np.log(rate)
        native.set_tissue((low[0], low[1], low[2]), cell, porosity, log_rate)

    def _build_net(self, native: _native.BleedingSolver32) -> None:
        if self._net is None:
            return
        low, high = self._net
        cell = self.parameters.particle_spacing
        start = low - 3.0 * cell
        shape = np.ceil((high + 3.0 * cell - start) / cell).astype(int) + 1
        distance = np.full(shape, np.inf)
        for axis in range(3):
            x = start[axis] + cell * np.arange(shape[axis])
            gap = np.minimum(x - low[axis], high[axis] - x)
            distance = np.minimum(distance, gap.reshape([-1 if a == axis else 1 for a in range(3)]))
        values = distance.astype(np.float32)
        native.set_barrier_distance((start[0], start[1], start[2]), cell, values)
