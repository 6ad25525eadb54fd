"""Sensors of an experiment: where to look, which quantities, and how they are averaged.

PointSensor(position=(0.02, 0, 0), quantities=("velocity", "pressure"), name="probe")
RegionSensor(solid=Block(size=(2e-3, 1e-2, 1e-2)), name="front layer")
SectionSensor(point=(0.05, 0, 0), normal="x", name="middle")
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, IndexArray, Vector3
from vulnus.core.errors import ScenarioError

from ..bodies.rotations import Axis, axis_vector
from ..bodies.solids import Ball, Solid
from ..checked_values import is_a, one_of, positive, true_or_false, vector
from ..particle_reading import QUANTITIES, ParticleReading
from ..wound.cavity import cavity_volume
from .symmetry import Plane, mirrored_at_all

DEFAULT_QUANTITIES = ("displacement", "velocity", "stress", "pressure")


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensor(ABC):
    """Looks at the tissue at every sample; `name` finds it in the result."""

    name: str | None = None

    @abstractmethod
    def attach(self, reading: ParticleReading, grid_spacing: float) -> AttachedSensor:
        """The sensor on the particles as they are before the first step."""


class AttachedSensor(ABC):
    """A sensor that knows its particles."""

    @abstractmethod
    def read(self, reading: ParticleReading) -> Mapping[str, AnyArray]:
        """The present values by quantity."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RegionSensor(Sensor):
    """Means, weighted by volume, over the particles of a region that is a `solid`.

    The particles inside the solid before the first step are followed wherever they go; with
    `fixed` the mean is instead over those inside at the time of the sample (NaN while there are
    none). `quantities` are names of `particle_reading.QUANTITIES`: position, displacement [m],
    velocity [m/s], stress (3, 3) and pressure [Pa], volume_ratio, damage, plastic_strain.
    """

    solid: Solid
    quantities: tuple[str, ...] = DEFAULT_QUANTITIES
    fixed: bool = False

    def __post_init__(self) -> None:
        """Refuse a region that is none, and names of quantities that there are not."""
        is_a("sensor solid", self.solid, Solid, "Give a Block, Ball, Rod or other Solid.")
        true_or_false("sensor fixed", self.fixed)
        _check_quantities(self.quantities)

    def attach(self, reading: ParticleReading, grid_spacing: float) -> AttachedSensor:  # noqa: ARG002
        """Choose the particles inside; refuse where there are none."""
        chosen = np.flatnonzero(self.solid.contains(reading["position"]))
        if not self.fixed and not len(chosen):
            raise ScenarioError(
                f"sensor {self.name}",
                "there is no particle inside of it before the first step",
                "Move it into a body, make it larger, or set fixed=True.",
            )
        return _AttachedRegion(self.solid, self.quantities, None if self.fixed else chosen)


@dataclass(frozen=True, kw_only=True, eq=False)
class PointSensor(Sensor):
    """Means over the particles within `radius` [m] of a point; else as `RegionSensor`.

    Without a `radius` it is one grid cell, so that some 30 particles have their say.
    """

    position: Vector3
    radius: float | None = None
    quantities: tuple[str, ...] = DEFAULT_QUANTITIES
    fixed: bool = False

    def __post_init__(self) -> None:
        """Refuse a place that is none, and names of quantities that there are not."""
        vector("sensor position", self.position)
        if self.radius is not None:
            positive("sensor radius", self.radius)
        true_or_false("sensor fixed", self.fixed)
        _check_quantities(self.quantities)

    def attach(self, reading: ParticleReading, grid_spacing: float) -> AttachedSensor:
        """Choose the particles around the point."""
        ball = Ball(radius=self.radius or grid_spacing, centre=self.position)
        region = RegionSensor(
            solid=ball, quantities=self.quantities, fixed=self.fixed, name=self.name
        )
        return region.attach(reading, grid_spacing)


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionSensor(Sensor):
    """The force [N] that the tissue beyond a plane exerts on the tissue before it.

    The plane goes through `point` [m]; `normal` points to the side beyond. `force` (3,) is the
    integral of stress over the section, taken over the particles that are within half of
    `thickness` [m] (default two cells) of the plane at the time of the sample; `area` [m²] is their
    volume over the thickness, and `stress` (3, 3) [Pa] their mean. Tension gives a force along the
    normal. `body` restricts it to one body of tissue by name.
    """

    point: Vector3
    normal: Axis
    thickness: float | None = None
    body: str | None = None

    def __post_init__(self) -> None:
        """Refuse a plane that is none."""
        vector("sensor point", self.point)
        axis_vector("sensor normal", self.normal)
        if self.thickness is not None:
            positive("sensor thickness", self.thickness)

    def attach(self, reading: ParticleReading, grid_spacing: float) -> AttachedSensor:
        """Remember the plane and the particles that may cross it."""
        return _AttachedSection(
            point=np.asarray(vector("sensor point", self.point)),
            normal=axis_vector("sensor normal", self.normal),
            thickness=self.thickness or 2.0 * grid_spacing,
            among=None if self.body is None else reading.particles_of(self.body),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class CavitySensor(Sensor):
    """The volume [m³] that all tissue encloses and does not fill, as the quantity `volume`.

    See `Fields.cavity_volume`. `symmetry` holds planes, each a point [m] on it and its normal, at
    which the tissue is mirrored first: a half or quarter model has the whole's cavity. A sample
    takes some seconds a million particles.
    """

    symmetry: tuple[Plane, ...] = ()

    def __post_init__(self) -> None:
        """Refuse planes that are none."""
        mirrored_at_all(np.zeros((0, 3)), self.symmetry)

    def attach(self, reading: ParticleReading, grid_spacing: float) -> AttachedSensor:  # noqa: ARG002
        """The sensor looks at all particles."""
        return _AttachedCavity(self.symmetry)


class _AttachedCavity(AttachedSensor):
    def __init__(self, symmetry: tuple[Plane, ...]) -> None:
        self._symmetry = symmetry

    def read(self, reading: ParticleReading) -> Mapping[str, AnyArray]:
        position = mirrored_at_all(np.asarray(reading["position"]), self._symmetry)
        volume = np.tile(reading.volume, 2 ** len(self._symmetry))
        spacing = float(np.cbrt(reading.volume.mean()))
        return {"volume": np.array(cavity_volume(position, spacing, volume=volume))}


class _AttachedRegion(AttachedSensor):
    def __init__(
        self, solid: Solid, quantities: tuple[str, ...], chosen: IndexArray | None
    ) -> None:
        self._solid, self._quantities, self._chosen = solid, quantities, chosen

    def read(self, reading: ParticleReading) -> Mapping[str, AnyArray]:
        chosen = self._chosen
        if chosen is None:
            chosen = np.flatnonzero(self._solid.contains(reading["position"]))
        weight = reading.volume[chosen]
        return {name: weighted_mean(reading[name][chosen], weight) for name in self._quantities}


class _AttachedSection(AttachedSensor):
    def __init__(
        self,
        *,
        point: FloatArray,
        normal: FloatArray,
        thickness: float,
        among: IndexArray | None,
    ) -> None:
        self._point, self._normal = point, normal
        self._thickness, self._among = thickness, among

    def read(self, reading: ParticleReading) -> Mapping[str, AnyArray]:
        height = np.abs((reading["position"] - self._point) @ self._normal)
        chosen = np.flatnonzero(height < 0.5 * self._thickness)
        if self._among is not None:
            chosen = np.intersect1d(chosen, self._among, assume_unique=True)
        present = reading.volume[chosen] * reading["volume_ratio"][chosen]
        stress = weighted_mean(reading["stress"][chosen], present)
        area = float(present.sum()) / self._thickness
        force = np.nan_to_num(stress) @ self._normal * area
        return {"force": force, "area": np.array(area), "stress": stress}


def weighted_mean(values: AnyArray, weight: FloatArray) -> AnyArray:
    """Mean over the first axis with these weights; NaN over nothing."""
    total = float(weight.sum())
    if total == 0.0:
        return np.full(values.shape[1:], np.nan)
    mean: AnyArray = np.tensordot(weight, np.asarray(values, np.float64), axes=(0, 0)) / total
    return mean


def _check_quantities(quantities: tuple[str, ...]) -> None:
    if isinstance(quantities, str):
        raise ScenarioError(
            "quantities", f"is the text {quantities!r}", f'Give a tuple: ("{quantities}",).'
        )
    is_a("quantities", quantities, (tuple, list), 'Give a tuple of names: ("pressure",).')
    if not quantities:
        known = ", ".join(QUANTITIES)
        raise ScenarioError("quantities", "are none", f"Give at least one of {known}.")
    for quantity in quantities:
        one_of("quantities", quantity, QUANTITIES)
