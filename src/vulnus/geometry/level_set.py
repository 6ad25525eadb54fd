"""The sparse narrow-band level set: made from particles, tubes, masks or functions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vulnus.core.arrays import (
    BoolArray,
    Float32Array,
    FloatArray,
    IntArray,
    Vector3,
)
from vulnus.core.errors import VulnusError
from vulnus.core.handoff import TriangleSurface

from . import _native
from .signed_distance import mask_signed_distance, without_stairs

NARROW_BAND_HALF_WIDTH = 3.0
"""Half width of the band [voxels]; OpenVDB's, and that of the appendix of the design note."""

CROWDED_NEIGHBOURS = 20.0
"""Neighbours within two radii from which a particle flows in full; chosen: two thirds of the 32
that a particle inside a cubic lattice of one radius' spacing has."""

STAIR_LIMIT = 0.4
"""Largest move of a mask's surface when its stairs are taken off [voxels of the mask]; chosen:
under the 0.5 at which a part of two voxels would vanish."""

MAXIMUM_BLOCKS = 40_000_000
"""Blocks of the bounding box of a dense field; beyond it the voxel is a slip of units."""


def _vectors(points: object, name: str) -> FloatArray:
    """`points` as a contiguous (n, 3) float64 array, all finite."""
    array = np.ascontiguousarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise VulnusError(name, f"shape {array.shape} is not (n, 3)", "Give one row a point.")
    if not np.isfinite(array).all():
        raise VulnusError(name, "holds values that are not finite", "Check where it comes from.")
    return array


def _check_voxel(voxel: float) -> None:
    if not (np.isfinite(voxel) and voxel > 0.0):
        raise VulnusError("voxel", f"{voxel!r} m is not positive", "Give a length in metres.")


class LevelSet:
    """A narrow-band signed distance [m], negative inside, on sparse blocks of 8³ voxels.

    Voxel (i, j, k) lies at `voxel * (i, j, k)` in the patient frame for every level set of that
    voxel, so that surfaces of moving matter do not flicker from frame to frame. Level sets are
    not changed by their methods; operations give new ones.
    """

    def __init__(self, native: _native.LevelSet) -> None:
        self._native = native

    @classmethod
    def from_particles(
        cls,
        position: FloatArray | Float32Array,
        radius: float | FloatArray,
        *,
        voxel: float,
        half_width: float = NARROW_BAND_HALF_WIDTH,
        keep_droplets: bool = False,
    ) -> LevelSet:
        """The union of spheres around particles.

        `position` (n, 3) [m], `radius` [m] scalar or (n,). Spheres smaller than the grid can hold
        (radius under 0.88 voxel) are drawn with that radius; none is dropped. The distance is
        exact outside the union and near its surface; deep inside overlaps it is a bound. With
        `keep_droplets` each voxel remembers how crowded its nearest particle is, and
        `mean_curvature_flow` moves it in that measure, so that single drops stay.
        """
        _check_voxel(voxel)
        centres = _vectors(position, "position")
        radii = np.ascontiguousarray(
            np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(centres),))
        )
        if len(radii) and not (np.isfinite(radii).all() and radii.min() > 0.0):
            raise VulnusError("radius", "holds a value that is not positive", "Give metres.")
        weights = np.empty(0, dtype=np.float32)
        if keep_droplets and len(radii):
            reach = 2.0 * float(radii.max())
            weights = _native.neighbour_weights(centres, reach, CROWDED_NEIGHBOURS)
        return cls(_native.LevelSet.union_of_spheres(centres, radii, weights, voxel, half_width))

    @classmethod
    def from_tube(
        cls,
        points: FloatArray,
        radius: FloatArray,
        *,
        voxel: float,
        half_width: float = NARROW_BAND_HALF_WIDTH,
    ) -> LevelSet:
        """A tube with round ends along a polyline: `points` (n, 3) [m], `radius` (n,) [m]."""
        _check_voxel(voxel)
        centres = _vectors(points, "points")
        radii = np.ascontiguousarray(np.broadcast_to(radius, (len(centres),)), dtype=np.float64)
        if not len(radii) or not (np.isfinite(radii).all() and radii.min() > 0.0):
            raise VulnusError("tube", "needs points with positive radii", "Check the centre-line.")
        return cls(_native.LevelSet.tube(centres, radii, voxel, half_width))

    @classmethod
    def from_dense(
        cls,
        distance: Float32Array,
        *,
        origin: FloatArray,
        spacing: FloatArray,
        direction: FloatArray,
        voxel: float,
        half_width: float = NARROW_BAND_HALF_WIDTH,
    ) -> LevelSet:
        """A signed distance [m] (nx, ny, nz) on a grid of any direction and spacing, resampled.

        The centre of voxel (i, j, k) lies at `origin + direction @ (spacing * (i, j, k))`. Beyond
        the grid the nearest value holds, for the width of the band.
        """
        _check_voxel(voxel)
        field = np.ascontiguousarray(distance, dtype=np.float32)
        axes = np.asarray(direction, dtype=np.float64) * np.asarray(spacing, dtype=np.float64)
        inverse = np.linalg.inv(axes)
        start = np.asarray(origin, dtype=np.float64)
        to_index = np.ascontiguousarray(np.column_stack([inverse, -inverse @ start]))
        corner_index = np.stack(
            np.meshgrid(*[(0.0, n - 1.0) for n in field.shape], indexing="ij"), axis=-1
        ).reshape(-1, 3)
        corners = start + corner_index @ axes.T
        low, high = corners.min(axis=0), corners.max(axis=0)
        if np.prod((high - low) / (8.0 * voxel) + 2.0) > MAXIMUM_BLOCKS:
            problem = f"{1e3 * voxel:g} mm is too fine for a box of {1e3 * (high - low)} mm"
            raise VulnusError("voxel", problem, "Take a larger voxel.")
        native = _native.LevelSet.from_field(
            field, to_index, voxel, half_width, _vector3(low), _vector3(high)
        )
        return cls(native)

    @classmethod
    def from_mask(
        cls,
        mask: BoolArray,
        *,
        origin: FloatArray,
        spacing: FloatArray,
        direction: FloatArray,
        voxel: float,
        smoothing: float = 0.0,
        stair_smoothing: float = 0.0,
        half_width: float = NARROW_BAND_HALF_WIDTH,
    ) -> LevelSet:
        """The surface of a (nx, ny, nz) mask, half way between voxels in and out.

        `smoothing` [m] is the standard deviation of a Gaussian on the signed distance; it deletes
        parts thinner than about twice that, so keep it 0 for thin tissue. `stair_smoothing`
        [voxels of the mask] takes off the stairs by a filter of that width, without moving any
        place by more than 0.4 voxel, so that parts of two voxels stay (constrained as in Whitaker
        2000, doi:10.1145/353888.353899), and keeps the volume. Where the mask touches the border
        of the grid its inside goes on beyond; pad the mask to close it there.
        """
        # A block is skipped by the distance at its middle: nine voxels and the labels' own step
        # beyond the band are enough to tell.
        steps, start = np.asarray(spacing, dtype=np.float64), np.asarray(origin, dtype=np.float64)
        reach = (half_width + 9.0) * voxel + (1.0 + 2.0 * stair_smoothing) * float(steps.max())
        distance = mask_signed_distance(
            np.asarray(mask, dtype=bool), steps, reach=reach, smoothing=smoothing
        )

        def on_grid(field: Float32Array, first: FloatArray, step: FloatArray) -> LevelSet:
            return cls.from_dense(
                field,
                origin=first,
                spacing=step,
                direction=direction,
                voxel=voxel,
                half_width=half_width,
            )

        level_set = on_grid(distance, start, steps)
        if stair_smoothing > 0.0:
            first = start + np.asarray(direction, dtype=np.float64) @ (0.5 * steps)
            smooth = on_grid(without_stairs(distance, stair_smoothing), first, 2.0 * steps)
            limit = STAIR_LIMIT * float(np.prod(steps)) ** (1.0 / 3.0)
            smooth = cls(smooth._native.limited(level_set._native, limit))
            level_set = smooth.with_volume(level_set.volume())
        # Anisotropic spacing leaves slopes other than 1 beside the surface; 4 steps of 0.5 voxel
        # straighten two voxels on each side of it, all that smoothing and meshing look at.
        return level_set.redistance(4, 0.5)

    @classmethod
    def from_function(
        cls,
        function: Callable[[FloatArray], FloatArray],
        *,
        bounds: tuple[Vector3, Vector3],
        voxel: float,
        half_width: float = NARROW_BAND_HALF_WIDTH,
    ) -> LevelSet:
        """A signed distance function of (n, 3) points [m], evaluated inside a box."""
        _check_voxel(voxel)
        low = np.floor(np.asarray(bounds[0]) / voxel).astype(np.int64) - 1
        high = np.ceil(np.asarray(bounds[1]) / voxel).astype(np.int64) + 1
        axes = [
            voxel * np.arange(a, b + 1, dtype=np.float64) for a, b in zip(low, high, strict=True)
        ]
        plane = np.stack(np.meshgrid(axes[1], axes[2], indexing="ij"), axis=-1).reshape(-1, 2)
        distance = np.empty([len(axis) for axis in axes], dtype=np.float32)
        for i, x in enumerate(axes[0]):
            points = np.column_stack([np.full(len(plane), x), plane])
            distance[i] = np.asarray(function(points)).reshape(distance.shape[1:])
        return cls.from_dense(
            distance,
            origin=voxel * low.astype(np.float64),
            spacing=np.full(3, voxel),
            direction=np.eye(3),
            voxel=voxel,
            half_width=half_width,
        )

    @property
    def voxel(self) -> float:
        """Edge of a voxel [m]."""
        return self._native.voxel

    @property
    def band(self) -> float:
        """Largest |distance| that is stored [m]: half width times voxel."""
        return float(self._native.background)

    @property
    def block_count(self) -> int:
        """Blocks of 8³ voxels in memory."""
        return self._native.block_count

    @property
    def memory_bytes(self) -> int:
        """Bytes of values, weights and the table of blocks."""
        return self._native.memory_bytes

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner [m] of the stored blocks; empty sets have low > high."""
        box = np.asarray(self._native.index_bounds(), dtype=np.float64) * self.voxel
        return box[:3], box[3:]

    @property
    def blocks(self) -> tuple[IntArray, Float32Array]:
        """Block coordinates (n, 3) in units of 8 voxels and their values (n, 512), z fastest."""
        return self._native.block_arrays()

    def mean_curvature_flow(self, iterations: int = 5) -> LevelSet:
        """Smooth by explicit mean curvature steps of h²/3, each with one re-distance step.

        A sphere's radius R shrinks as R² - 2/3 h² a step (h the voxel), so drops of a few voxels
        vanish; see `from_particles(keep_droplets=True)`.
        """
        native = self._native.copy()
        flow = _native.BandFlow(native)
        for _ in range(iterations):
            flow.curvature_step()
        return LevelSet(native)

    def redistance(self, steps: int = 5, courant: float = 0.3) -> LevelSet:
        """Straighten the slope to 1 by Godunov steps of `courant` voxels."""
        native = self._native.copy()
        flow = _native.BandFlow(native)
        for _ in range(steps):
            flow.redistance_step(courant)
        return LevelSet(native)

    def offset(self, distance: float) -> LevelSet:
        """The surface moved outward by `distance` [m]; it must stay inside the band."""
        if abs(distance) >= self.band:
            problem = f"{1e3 * distance:g} mm is not inside the band of ±{1e3 * self.band:g} mm"
            raise VulnusError("offset", problem, "Build the level set with a larger half_width.")
        native = self._native.copy()
        native.offset(distance)
        return LevelSet(native)

    def union(self, other: LevelSet) -> LevelSet:
        """Inside either set; both must have one voxel size."""
        self._check_same_grid(other)
        return LevelSet(self._native.united(other._native))

    def intersection(self, other: LevelSet) -> LevelSet:
        """Inside both sets; both must have one voxel size."""
        self._check_same_grid(other)
        return LevelSet(self._native.intersected(other._native))

    def difference(self, other: LevelSet) -> LevelSet:
        """Inside this set and outside the other; both must have one voxel size."""
        self._check_same_grid(other)
        return LevelSet(self._native.without(other._native))

    def cut(self, normal: Vector3, offset: float) -> LevelSet:
        """The part where `normal · x <= offset` [m]; `normal` is a unit vector."""
        return LevelSet(self._native.cut(normal, offset))

    def sample(self, points: FloatArray | Float32Array) -> Float32Array:
        """Distance [m] at `points` (n, 3), trilinear; ± the band's half width outside of it."""
        return self._native.sample(_vectors(points, "points"))

    def gradient(self, points: FloatArray | Float32Array) -> FloatArray:
        """Gradient (n, 3) of the trilinear distance: near a surface, its outward normal."""
        return self._native.gradient(_vectors(points, "points"))

    def to_surface(self) -> TriangleSurface:
        """The zero level by marching cubes: welded, closed, outward, the same on every run."""
        vertices, triangles = self._native.surface()
        return TriangleSurface(vertices=vertices, triangles=triangles)

    def with_volume(self, volume: float) -> LevelSet:
        """The surface moved evenly, out or in, to hold `volume` [m³] to first order.

        Gives back what smoothing took; the move must stay inside the band.
        """
        step = 0.1 * self.voxel
        area = (self.offset(step).volume() - self.offset(-step).volume()) / (2.0 * step)
        return self.offset((volume - self.volume()) / area) if area > 0.0 else self

    def volume(self) -> float:
        """Volume inside [m³], with the cut part of each voxel at the surface."""
        return self._native.volume()

    def _check_same_grid(self, other: LevelSet) -> None:
        if self.voxel != other.voxel:
            problem = f"voxels of {1e3 * self.voxel:g} and {1e3 * other.voxel:g} mm do not combine"
            raise VulnusError("level set", problem, "Build both with one voxel.")


def _vector3(values: FloatArray) -> Vector3:
    return (float(values[0]), float(values[1]), float(values[2]))
