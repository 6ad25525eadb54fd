"""Solids that bodies of an experiment fill: blocks, balls, rods, shells, tubes and what they make.

block = Block(size=(0.1, 0.05, 0.05), centre=(0.05, 0, 0))
bored = block - Rod(radius=5e-3, length=0.2, axis="x")
turned = bored.rotated(rotation_about("z", np.radians(30)))

All lengths are metres. A solid is never changed; its methods give new ones.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..checked_values import length, positive, refuse_too_many, vector, whole_number
from ..checked_values import points as checked_points
from .rotations import Axis, axis_frame, rotation_matrix

if TYPE_CHECKING:
    from .combined_solids import Difference, Intersection, Union

POINTS_PER_PASS = 500_000  # [chosen: a pass takes a few tens of milliseconds and 50 MB]
LARGEST_SEED = 2**31 - 1
QUADRATURE_CELLS = 100  # cells along the longest edge where a volume is measured [chosen]


@dataclass(frozen=True, slots=True, eq=False)
class FilledPoints:
    """Points that fill a solid: `position` (n, 3) [m] and the `volume` (n,) [m³] of each."""

    position: FloatArray
    volume: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Solid(ABC):
    """A closed region of space, described in its own frame and put to its place.

    `centre` [m] is where the origin of its own frame stands; `rotation` (3, 3) turns its own axes
    to the world's. Solids combine: `a | b` (union), `a - b` (difference), `a & b` (intersection).
    """

    centre: Vector3 = (0.0, 0.0, 0.0)
    rotation: AnyArray | None = None

    def __post_init__(self) -> None:
        """Refuse a place or a turn that is none."""
        vector("centre", self.centre)
        if self.rotation is not None:
            rotation_matrix(self.rotation)

    @abstractmethod
    def _local_distance(self, local: FloatArray) -> FloatArray:
        """Signed distance (n,) [m] at points (n, 3) of the solid's own frame."""

    @abstractmethod
    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner (3,) [m] in the solid's own frame; infinite without bounds."""

    def _exact_volume(self) -> float | None:
        """Volume [m³] in closed form, None where there is none."""
        return None

    @property
    def thinnest(self) -> float:
        """Thickness [m] of the thinnest part, as far as it is known: what a grid must resolve."""
        lower, upper = self._local_bounds()
        return float(np.min(upper - lower))

    @property
    def frame(self) -> FloatArray:
        """Rotation (3, 3) from the solid's own axes to the world's."""
        return np.eye(3) if self.rotation is None else rotation_matrix(self.rotation)

    def signed_distance(self, points: AnyArray) -> FloatArray:
        """Signed distance (n,) [m] at world points (n, 3) [m]: negative inside.

        Exact for the simple solids; for combined ones exact beside the faces, else a bound.
        """
        world = checked_points("points", points)
        return self._local_distance((world - np.asarray(self.centre)) @ self.frame)

    def contains(self, points: AnyArray) -> BoolArray:
        """Whether each of the world points (n, 3) [m] is inside, (n,)."""
        inside: BoolArray = self.signed_distance(points) < 0.0
        return inside

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner (3,) [m] of a box along the world's axes around the solid."""
        lower, upper = self._local_bounds()
        if not np.isfinite([lower, upper]).all():
            if np.array_equal(self.frame, np.eye(3)):
                return lower + self.centre, upper + self.centre
            return np.full(3, -np.inf), np.full(3, np.inf)
        corners = np.stack(np.meshgrid(*zip(lower, upper, strict=True)), axis=-1).reshape(-1, 3)
        world = corners @ self.frame.T + np.asarray(self.centre)
        return world.min(axis=0), world.max(axis=0)

    @property
    def volume(self) -> float:
        """Volume [m³]; where there is no closed form, measured to about 0.3 %."""
        exact = self._exact_volume()
        return self._measured_volume() if exact is None else exact

    def moved(self, by: Vector3) -> Self:
        """The same solid moved by the vector `by` [m]."""
        return replace(self, centre=triple(np.add(self.centre, vector("by", by))))

    def rotated(self, rotation: AnyArray, *, about: Vector3 | None = None) -> Self:
        """The same solid turned by a rotation matrix (3, 3) or a scipy `Rotation`.

        It turns about the point `about` [m]; without one, about its own centre.
        """
        turn = rotation_matrix(rotation)
        pivot = np.asarray(self.centre if about is None else vector("about", about))
        centre = triple(turn @ (np.asarray(self.centre) - pivot) + pivot)
        return replace(self, rotation=turn @ self.frame, centre=centre)

    def lattice(self, spacing: float) -> FilledPoints:
        """Points on a lattice along the solid's own axes that fill it; volumes add up to its own.

        `spacing` [m] is adjusted, by less than half of it, so that whole layers fit between the
        faces of the solid's own box.
        """
        lower, upper = self._box()
        step = length("spacing", spacing)
        counts = np.maximum(1, np.rint((upper - lower) / step)).astype(int)
        refuse_too_many("solid", float(np.prod((upper - lower) / step)))
        layers = _layers(lower, (upper - lower) / counts, counts)
        kept = [local[self._local_distance(local) < 0.0] for local in layers]
        return self._filled(np.concatenate(kept))

    def poisson_disk(self, density: float, seed: int) -> FilledPoints:
        """About `density` [1/m³] random points, no two close; volumes add up to the solid's own."""
        from vulnus.geometry.poisson_disk import EXPECTED_DENSITY, sample_poisson_disk

        lower, upper = self._box()
        refuse_too_many("solid", float(np.prod(upper - lower)) * positive("density", density))
        spacing = float((EXPECTED_DENSITY / density) ** (1.0 / 3.0))
        local = sample_poisson_disk(
            self._local_distance,
            spacing=spacing,
            seed=whole_number("seed", seed, LARGEST_SEED),
            bounds=(triple(lower - spacing), triple(upper + spacing)),
        ).astype(np.float64)
        return self._filled(local[self._local_distance(local) < 0.0])

    def _filled(self, local: FloatArray) -> FilledPoints:
        position = local @ self.frame.T + np.asarray(self.centre)
        return FilledPoints(position, np.full(len(local), self.volume / max(len(local), 1)))

    def _box(self) -> tuple[FloatArray, FloatArray]:
        lower, upper = self._local_bounds()
        if not np.isfinite([lower, upper]).all():
            raise ScenarioError(
                "solid", "it has no bounds", "Cut it out of one that has: block & HalfSpace(...)."
            )
        if not (upper > lower).all():
            raise ScenarioError("solid", "nothing is left of it", "Check sizes and places [m].")
        return lower, upper

    def _measured_volume(self) -> float:
        lower, upper = self._box()
        step = float(np.max(upper - lower)) / QUADRATURE_CELLS
        counts = np.maximum(1, np.ceil((upper - lower) / step)).astype(int)
        steps = (upper - lower) / counts
        total = 0.0
        for local in _layers(lower, steps, counts):
            part = np.clip(0.5 - self._local_distance(local) / np.mean(steps), 0.0, 1.0)
            total += float(part.sum())
        return total * float(np.prod(steps))

    def __or__(self, other: Solid) -> Union:
        from .combined_solids import Union

        return Union(parts=(self, other))

    def __sub__(self, other: Solid) -> Difference:
        from .combined_solids import Difference

        return Difference(whole=self, taken=other)

    def __and__(self, other: Solid) -> Intersection:
        from .combined_solids import Intersection

        return Intersection(parts=(self, other))


@dataclass(frozen=True, kw_only=True, eq=False)
class Block(Solid):
    """A box with the edges `size` [m] along its own axes, about `centre`."""

    size: Vector3

    def __post_init__(self) -> None:
        """Refuse edges that are not positive."""
        Solid.__post_init__(self)
        for name, edge in zip("xyz", vector("size", self.size), strict=True):
            length(f"size along {name}", edge)

    def _local_distance(self, local: FloatArray) -> FloatArray:
        beyond = np.abs(local) - 0.5 * np.asarray(self.size)
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        distance: FloatArray = outside + np.minimum(beyond.max(axis=1), 0.0)
        return distance

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        half = 0.5 * np.asarray(self.size, np.float64)
        return -half, half

    def _exact_volume(self) -> float:
        return float(np.prod(self.size))


@dataclass(frozen=True, kw_only=True, eq=False)
class Ball(Solid):
    """A full sphere of `radius` [m]."""

    radius: float

    def __post_init__(self) -> None:
        """Refuse a radius that is not positive."""
        Solid.__post_init__(self)
        length("radius", self.radius)

    def _local_distance(self, local: FloatArray) -> FloatArray:
        distance: FloatArray = np.linalg.norm(local, axis=1) - self.radius
        return distance

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        return np.full(3, -self.radius), np.full(3, self.radius)

    def _exact_volume(self) -> float:
        return float(4.0 / 3.0 * np.pi * self.radius**3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shell(Solid):
    """A hollow ball between `inner_radius` and `outer_radius` [m]."""

    inner_radius: float
    outer_radius: float

    def __post_init__(self) -> None:
        """Refuse radii that are not positive or not in order."""
        Solid.__post_init__(self)
        _check_radii(self.inner_radius, self.outer_radius)

    @property
    def thinnest(self) -> float:
        """Thickness [m] of the wall."""
        return self.outer_radius - self.inner_radius

    def _local_distance(self, local: FloatArray) -> FloatArray:
        radius = np.linalg.norm(local, axis=1)
        distance: FloatArray = np.maximum(radius - self.outer_radius, self.inner_radius - radius)
        return distance

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        return np.full(3, -self.outer_radius), np.full(3, self.outer_radius)

    def _exact_volume(self) -> float:
        return float(4.0 / 3.0 * np.pi * (self.outer_radius**3 - self.inner_radius**3))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Round(Solid):
    """What rods and tubes share: `length` [m] along `axis`, about `centre`."""

    length: float
    axis: Axis = "z"

    def __post_init__(self) -> None:
        Solid.__post_init__(self)
        length("length", self.length)
        axis_frame(self.axis)

    @property
    def frame(self) -> FloatArray:
        """Rotation (3, 3) from the solid's own axes, z along it, to the world's."""
        own = np.eye(3) if self.rotation is None else rotation_matrix(self.rotation)
        turned: FloatArray = own @ axis_frame(self.axis)
        return turned

    def rotated(self, rotation: AnyArray, *, about: Vector3 | None = None) -> Self:
        """The same solid turned; see `Solid.rotated`. Its `axis` is then its own z."""
        turned = Solid.rotated(self, rotation, about=about)
        return replace(turned, axis="z")


@dataclass(frozen=True, kw_only=True, eq=False)
class Rod(_Round):
    """A full cylinder of `radius` [m], `length` [m] long along `axis`, about `centre`."""

    radius: float

    def __post_init__(self) -> None:
        """Refuse a radius or a length that is not positive."""
        _Round.__post_init__(self)
        length("radius", self.radius)

    def _local_distance(self, local: FloatArray) -> FloatArray:
        around = np.hypot(local[:, 0], local[:, 1]) - self.radius
        return _crossed(around, np.abs(local[:, 2]) - 0.5 * self.length)

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        half = np.array([self.radius, self.radius, 0.5 * self.length])
        return -half, half

    def _exact_volume(self) -> float:
        return float(np.pi * self.radius**2 * self.length)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tube(_Round):
    """A round tube between two radii [m], `length` [m] long along `axis`, about `centre`."""

    inner_radius: float
    outer_radius: float

    def __post_init__(self) -> None:
        """Refuse radii and lengths that are not positive or not in order."""
        _Round.__post_init__(self)
        _check_radii(self.inner_radius, self.outer_radius)

    @property
    def thinnest(self) -> float:
        """Thickness [m] of the wall or the length, whichever is less."""
        return min(self.outer_radius - self.inner_radius, self.length)

    def _local_distance(self, local: FloatArray) -> FloatArray:
        radius = np.hypot(local[:, 0], local[:, 1])
        around = np.maximum(radius - self.outer_radius, self.inner_radius - radius)
        return _crossed(around, np.abs(local[:, 2]) - 0.5 * self.length)

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        half = np.array([self.outer_radius, self.outer_radius, 0.5 * self.length])
        return -half, half

    def _exact_volume(self) -> float:
        return float(np.pi * (self.outer_radius**2 - self.inner_radius**2) * self.length)


def triple(values: AnyArray) -> Vector3:
    """Three numbers as a tuple of floats."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def _crossed(first: FloatArray, second: FloatArray) -> FloatArray:
    """Signed distance of the common part of two fields whose gradients are at right angles."""
    outside = np.hypot(np.maximum(first, 0.0), np.maximum(second, 0.0))
    distance: FloatArray = outside + np.minimum(np.maximum(first, second), 0.0)
    return distance


def _layers(lower: FloatArray, steps: FloatArray, counts: AnyArray) -> Iterator[FloatArray]:
    """Centres (n, 3) of the cells of a lattice from `lower`, some layers of x at a time."""
    x, y, z = (lower[a] + (np.arange(counts[a]) + 0.5) * steps[a] for a in range(3))
    at_once = max(1, POINTS_PER_PASS // (len(y) * len(z)))
    for first in range(0, len(x), at_once):
        axes = np.meshgrid(x[first : first + at_once], y, z, indexing="ij")
        yield np.stack(axes, axis=-1).reshape(-1, 3)


def _check_radii(inner: float, outer: float) -> None:
    length("inner_radius", inner)
    length("outer_radius", outer)
    if not outer > inner:
        raise ScenarioError(
            "outer_radius", f"is {outer:g} m, must be > inner_radius {inner:g} m", "Swap them?"
        )
