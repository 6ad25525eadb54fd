"""Solids made of others or of anything that tells a signed distance.

half_a_ball = Ball(radius=0.02) & HalfSpace(point=(0, 0, 0), normal=(1, 0, 0))
gyroid = FunctionSolid(function=distance, lower=(-0.02,) * 3, upper=(0.02,) * 3)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray, Vector3
from vulnus.core.errors import ScenarioError
from vulnus.geometry.mesh import surface_volume

from ..checked_values import has_methods, is_a, numbers, shown, vector
from .mesh_shape import MeshShape
from .rotations import Axis, axis_vector
from .shape_distance import distance_to
from .solids import Solid


@dataclass(frozen=True, kw_only=True, eq=False)
class Union(Solid):
    """All that is in any of the `parts`."""

    parts: tuple[Solid, ...]

    def __post_init__(self) -> None:
        """Refuse a union of nothing."""
        Solid.__post_init__(self)
        _check_parts(self.parts)

    @property
    def thinnest(self) -> float:
        """Thickness [m] of the thinnest part."""
        return min(part.thinnest for part in self.parts)

    def _local_distance(self, local: FloatArray) -> FloatArray:
        nearest: FloatArray = np.minimum.reduce([p.signed_distance(local) for p in self.parts])
        return nearest

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        bounds = [part.bounds for part in self.parts]
        return (
            np.minimum.reduce([lower for lower, _ in bounds]),
            np.maximum.reduce([upper for _, upper in bounds]),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Intersection(Solid):
    """What is in all of the `parts`."""

    parts: tuple[Solid, ...]

    def __post_init__(self) -> None:
        """Refuse an intersection of nothing."""
        Solid.__post_init__(self)
        _check_parts(self.parts)

    def _local_distance(self, local: FloatArray) -> FloatArray:
        farthest: FloatArray = np.maximum.reduce([p.signed_distance(local) for p in self.parts])
        return farthest

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        bounds = [part.bounds for part in self.parts]
        return (
            np.maximum.reduce([lower for lower, _ in bounds]),
            np.minimum.reduce([upper for _, upper in bounds]),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Difference(Solid):
    """What is in the `whole` but not in what is `taken` away."""

    whole: Solid
    taken: Solid

    def __post_init__(self) -> None:
        """Refuse what is no solid."""
        Solid.__post_init__(self)
        _check_parts((self.whole, self.taken))

    @property
    def thinnest(self) -> float:
        """Thickness [m] of the whole: how thin the rest is, is not known."""
        return self.whole.thinnest

    def _local_distance(self, local: FloatArray) -> FloatArray:
        inside, away = self.whole.signed_distance(local), self.taken.signed_distance(local)
        return np.maximum(inside, -away)

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        return self.whole.bounds


@dataclass(frozen=True, kw_only=True, eq=False)
class HalfSpace(Solid):
    """All on the side of a plane that `normal` points to; only of use to cut other solids.

    `point` [m] is on the plane; `normal` is any vector or the name of an axis.
    """

    point: Vector3
    normal: Axis

    def __post_init__(self) -> None:
        """Refuse a normal without direction."""
        Solid.__post_init__(self)
        vector("point", self.point)
        axis_vector("normal", self.normal)

    @property
    def thinnest(self) -> float:
        """Without limit."""
        return float("inf")

    def _local_distance(self, local: FloatArray) -> FloatArray:
        normal = axis_vector("normal", self.normal)
        distance: FloatArray = -(local - np.asarray(self.point)) @ normal
        return distance

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        normal = axis_vector("normal", self.normal)
        lower = np.where(normal == 1.0, self.point, -np.inf)
        upper = np.where(normal == -1.0, self.point, np.inf)
        return lower, upper


@dataclass(frozen=True, kw_only=True, eq=False)
class FunctionSolid(Solid):
    """The inside of a signed distance `function` of points (n, 3) [m], negative inside, (n,) [m].

    `lower` and `upper` [m] are two corners of a box that holds all of it. The function need not be
    a true distance, but its slope beside the surface must be about 1.
    """

    function: Callable[[FloatArray], AnyArray]
    lower: Vector3
    upper: Vector3

    def __post_init__(self) -> None:
        """Refuse a function that does not give one finite number a point."""
        Solid.__post_init__(self)
        has_methods("function", self.function, ("__call__",), "a function of points (n, 3) [m]")
        lower, upper = vector("lower", self.lower), vector("upper", self.upper)
        if not np.all(np.asarray(upper) > lower):
            raise ScenarioError("upper", f"is {upper}, must be above lower {lower}", "Swap them?")
        self._local_distance(np.array([lower, upper]))

    def _local_distance(self, local: FloatArray) -> FloatArray:
        try:
            given = self.function(local)
        except Exception as error:
            told = f"failed with {type(error).__name__}: {error}"
            raise ScenarioError("function", told, "It takes points (n, 3) [m].") from error
        distance = numbers(given)
        if distance.shape != (len(local),) or not np.isfinite(distance).all():
            raise ScenarioError(
                "function",
                f"gave shape {distance.shape} for {len(local)} points, or a value not finite",
                "It takes points (n, 3) [m] and gives distances (n,) [m], negative inside.",
            )
        return distance

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        return np.asarray(self.lower, np.float64), np.asarray(self.upper, np.float64)


@dataclass(frozen=True, kw_only=True, eq=False)
class ClosedSurface(Solid):
    """The inside of a closed triangle mesh, in the mesh's own coordinates: `MeshShape(surface)`.

    `ClosedSurface(mesh=MeshShape.from_stl("bone.stl"))` reads an STL file in millimetres. The
    distance is sampled at a sixteenth of `MeshShape.thinnest`; the volume is the mesh's own.
    """

    mesh: MeshShape

    def __post_init__(self) -> None:
        """Refuse what is no mesh."""
        Solid.__post_init__(self)
        is_a("mesh", self.mesh, MeshShape, 'Give a MeshShape.from_stl("bone.stl").')

    @property
    def thinnest(self) -> float:
        """Thickness [m] that the sampling of the mesh resolves."""
        lower, upper = self._local_bounds()
        return self.mesh.thinnest or float(np.min(upper - lower))

    def _local_distance(self, local: FloatArray) -> FloatArray:
        return distance_to(self.mesh, local - self.mesh.centre_of_mass)

    def _local_bounds(self) -> tuple[FloatArray, FloatArray]:
        return self.mesh.drawn_box()

    def _exact_volume(self) -> float:
        return surface_volume(self.mesh.surface)


def _check_parts(parts: tuple[Solid, ...]) -> None:
    if not isinstance(parts, tuple) or not parts or not all(isinstance(p, Solid) for p in parts):
        told = f"are {shown(parts)}"
        raise ScenarioError("parts", told, "Give a tuple of at least one solid.")
