"""What the particles of an experiment are like at one instant, each quantity read once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, IndexArray, LabelArray

from .checked_values import one_of
from .solver import MpmSolver

QUANTITIES: Mapping[str, str] = {
    "position": "m",
    "displacement": "m",
    "velocity": "m/s",
    "stress": "Pa",
    "pressure": "Pa",
    "volume_ratio": "1",
    "damage": "1",
    "plastic_strain": "1",
    "opening": "1",
}
"""Names of what can be read of particles, with units.

`stress` is Cauchy's, tension positive; `pressure` is its mean with compression positive;
`volume_ratio` is the present over the reference volume; `damage` runs from 0 (intact) to 1 (no
strength left); `opening` is the logarithmic volume strain of open voids and cracks.
"""


@dataclass(frozen=True, slots=True, eq=False)
class TissueBody:
    """One body of tissue: its name and which particles are its own."""

    name: str
    particles: slice


@dataclass(frozen=True, slots=True, eq=False)
class JoinedParticles:
    """All particles before the first step, in the order in which they were added.

    `position` (n, 3) [m], `volume` (n,) [m³], `velocity` (n, 3) [m/s], `material_row` (n,) of the
    table of materials, `density` (n,) [kg/m³]; `state` (n, 15) as `MpmSolver.set_point_state` takes
    it, None where nothing is strained or damaged.
    """

    position: FloatArray
    volume: FloatArray
    velocity: FloatArray
    material_row: LabelArray
    density: FloatArray
    state: FloatArray | None = None


class ParticleReading:
    """Quantities of all particles at one instant, in the order in which they were added."""

    def __init__(
        self, solver: MpmSolver, particles: JoinedParticles, bodies: Sequence[TissueBody]
    ) -> None:
        self.time = solver.time
        self.volume = particles.volume
        self.mass = particles.volume * particles.density
        self.reference = particles.position
        self._solver = solver
        self._bodies = {body.name: body.particles for body in bodies}
        self._read: dict[str, AnyArray] = {}

    def __getitem__(self, quantity: str) -> AnyArray:
        """The quantity of every particle: (n,), (n, 3) or (n, 3, 3)."""
        if quantity not in self._read:
            self._read[quantity] = self._of_solver(quantity)
        return self._read[quantity]

    def particles_of(self, body: str) -> IndexArray:
        """Indices of the particles of a body of tissue."""
        part = self._bodies[one_of("body", body, self._bodies)]
        return np.arange(part.start, part.stop)

    def _of_solver(self, quantity: str) -> AnyArray:
        if quantity == "displacement":
            moved: AnyArray = self["position"] - self.reference
            return moved
        return np.asarray(getattr(self._solver, quantity), np.float64)
