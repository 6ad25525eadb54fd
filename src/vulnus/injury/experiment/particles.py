"""The particles of an experiment before its first step: who is made of what, and where."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..bodies.solids import FilledPoints, Solid
from ..checked_values import given_or_made, not_too_fast, numbers, one_of, points
from ..material_model import CAPACITY, Material
from ..material_point import STATE
from ..materials import MATERIALS
from ..materials import material as named_material
from ..particle_reading import JoinedParticles, TissueBody
from .checks import free_name
from .initial_state import Given, initial_state, volume_ratio

Arrangement = Literal["lattice", "poisson"]
Velocity = Vector3 | AnyArray | Callable[[FloatArray], AnyArray]
"""One velocity [m/s] for all, one for each particle (n, 3), or a function of positions (n, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class Filling:
    """One body of tissue: its particles, and the solid they fill where there is one."""

    name: str
    position: FloatArray
    volume: FloatArray
    velocity: FloatArray
    material_row: int
    solid: Solid | None
    state: FloatArray | None = None
    """Native values (n, 15) of particles that begin under stress, damaged or worked."""


class ParticleStore:
    """Collects bodies and gives the arrays that the solver takes."""

    def __init__(self) -> None:
        self.fillings: list[Filling] = []
        self.materials: list[Material] = []

    def free_name(self, wish: str | None, kind: str) -> str:
        """The name wished for, or the next free one of its kind."""
        return free_name(wish, kind, [filling.name for filling in self.fillings])

    def add(
        self,
        name: str,
        position: AnyArray,
        volume: AnyArray | float,
        material: str | Material,
        *,
        velocity: Velocity,
        solid: Solid | None = None,
    ) -> None:
        """Add a body of particles at `position` (n, 3) [m]."""
        place = points(f"{name}: position", position)
        if not len(place):
            raise ScenarioError(
                name, "holds no particles", "Make the solid larger or the cells smaller."
            )
        self.fillings.append(
            Filling(
                name=name,
                position=place,
                volume=_volumes(name, volume, len(place)),
                velocity=_velocities(name, velocity, place),
                material_row=self._row_of(name, material),
                solid=solid,
            )
        )

    def begin_in(
        self,
        name: str,
        *,
        grid_spacing: float,
        velocity: Velocity | None,
        stress: Given | None,
        damage: Given,
        plastic_strain: Given,
    ) -> None:
        """Let a body begin in this state instead of the one before; see `Experiment.set_state`."""
        names = [filling.name for filling in self.fillings]
        number = names.index(one_of("body", name, names))
        before = self.fillings[number]
        state = initial_state(
            name,
            self.materials[before.material_row],
            before.position,
            grid_spacing=grid_spacing,
            stress=stress,
            damage=damage,
            plastic_strain=plastic_strain,
        )
        present = before.volume
        if before.state is not None:
            present = present * volume_ratio(before.state)
        moving = before.velocity if velocity is None else velocity
        self.fillings[number] = replace(
            before,
            state=state,
            volume=present / volume_ratio(state),
            velocity=_velocities(name, moving, before.position),
        )

    def _row_of(self, name: str, material: str | Material) -> int:
        chosen = named_material(material) if isinstance(material, str) else material
        if not isinstance(chosen, Material):
            raise ScenarioError(
                f"{name}: material",
                f"is {material!r}",
                f"Give a Material or one of {', '.join(MATERIALS)}.",
            )
        if chosen not in self.materials:
            if len(self.materials) == CAPACITY:
                raise ScenarioError(
                    f"{name}: material",
                    f"would be number {CAPACITY + 1} of at most {CAPACITY}",
                    "Use fewer different materials.",
                )
            self.materials.append(chosen)
        return self.materials.index(chosen)

    def check(self) -> None:
        """Refuse an experiment without particles."""
        if not self.fillings:
            raise ScenarioError(
                "experiment", "has no bodies", "Use add_body, add_points or add_labels first."
            )

    @property
    def count(self) -> int:
        """How many particles there are."""
        return sum(len(filling.position) for filling in self.fillings)

    @property
    def bodies(self) -> tuple[TissueBody, ...]:
        """Names of the bodies and their ranges of particles."""
        ends = np.cumsum([0, *(len(filling.position) for filling in self.fillings)]).tolist()
        return tuple(
            TissueBody(filling.name, slice(first, last))
            for filling, first, last in zip(self.fillings, ends[:-1], ends[1:], strict=True)
        )

    def joined(self) -> JoinedParticles:
        """All particles in one set of arrays."""
        rows = [np.full(len(f.position), f.material_row, np.uint8) for f in self.fillings]
        row = np.concatenate(rows)
        density = np.array([material.density for material in self.materials])
        return JoinedParticles(
            position=np.concatenate([filling.position for filling in self.fillings]),
            volume=np.concatenate([filling.volume for filling in self.fillings]),
            velocity=np.concatenate([filling.velocity for filling in self.fillings]),
            material_row=row,
            density=density[row],
            state=self._state(),
        )

    def _state(self) -> FloatArray | None:
        """Native values (n, 15) of all particles, None where all begin at rest."""
        if all(filling.state is None for filling in self.fillings):
            return None
        return np.concatenate(
            [
                np.zeros((len(filling.position), STATE.stop))
                if filling.state is None
                else filling.state
                for filling in self.fillings
            ]
        )


def fill(
    solid: Solid, *, point_spacing: float, arrangement: Arrangement, seed: int
) -> FilledPoints:
    """Points in the solid, one in every `point_spacing`³ [m³] on average."""
    if not isinstance(solid, Solid):
        raise ScenarioError("solid", f"is {solid!r}", "Give a Block, Ball, Rod or another Solid.")
    one_of("arrangement", arrangement, ("lattice", "poisson"))
    if arrangement == "lattice":
        return solid.lattice(point_spacing)
    return solid.poisson_disk(point_spacing**-3, seed)


def _volumes(name: str, volume: Any, count: int) -> FloatArray:
    try:
        values = np.ascontiguousarray(np.broadcast_to(numbers(volume), (count,)))
    except ValueError:
        raise ScenarioError(
            f"{name}: volume",
            f"does not fit {count} particles",
            "Give one volume [m³], or one a particle.",
        ) from None
    if not (np.isfinite(values) & (values > 0.0)).all():
        row = int(np.flatnonzero(~(np.isfinite(values) & (values > 0.0)))[0])
        raise ScenarioError(
            f"{name}: volume", f"of particle {row} is {values[row]:g} m³, must be > 0", "Mend it."
        )
    return values


def _velocities(name: str, velocity: Any, position: FloatArray) -> FloatArray:
    values = numbers(given_or_made(f"{name}: velocity", velocity, position))
    if values.shape not in ((3,), position.shape):
        raise ScenarioError(
            f"{name}: velocity",
            f"does not fit {len(position)} particles",
            "Give (vx, vy, vz) [m/s], an array (n, 3), or a function of the positions (n, 3).",
        )
    checked = points(f"{name}: velocity", np.array(np.broadcast_to(values, position.shape)))
    not_too_fast(name, float(np.max(np.abs(checked))))
    return checked
