"""What holds blood back: intact skin, bone, the ends of the limb, and a platform.

Bone and skin "as stationary particles" (Chong 2017, §2.3), but of a watertight solid and at the
blood's own spacing: material points are too far apart to stop smaller blood particles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, Float32Array, FloatArray, Vector3
from vulnus.core.handoff import InjuredLimb, Tissue

from . import _native
from .distance_grid import NodeGrid, closed_solid
from .parameters import HemorrhageParameters, PlatformParameters
from .skin_bonds import skin_bond_middles

NODE_LIMIT = 24_000_000
"""Nodes of the limb's distance grids; chosen: about 100 MB each. The cell grows to keep it."""

LAYER_THINNING = 0.9
"""Least distance of barrier particles over the blood's spacing; chosen: no gap above 1.5."""

BONE_TISSUES = (Tissue.BONE, Tissue.CANCELLOUS, Tissue.MARROW)


@dataclass(frozen=True, slots=True, eq=False)
class LimbBarriers:
    """Signed distances [m] on one grid, negative in the solid, and the barrier's particles.

    `barrier` of intact skin, bone and the limb's ends; `limb` of the whole limb as it was with
    what bulges out of it (the wound's tract counts as inside); `particles` (n, 3) [m];
    `skin_depth` [m] is how far skin reaches below the limb's surface.
    """

    grid: NodeGrid
    barrier: Float32Array
    limb: Float32Array
    particles: FloatArray
    skin_depth: float


def intact(wound: InjuredLimb, parameters: HemorrhageParameters) -> BoolArray:
    """Which material points still hold together (n,)."""
    if parameters.barrier_model == "presence":
        return np.ones(len(wound.damage), dtype=bool)
    return np.asarray(wound.damage < parameters.barrier_damage)


def limb_grid(wound: InjuredLimb, whole: BoolArray, spacing: float) -> NodeGrid:
    """The grid over the limb, before and after, at half the coarser of the two spacings."""
    kept = wound.position[whole]
    lower = np.minimum(wound.reference_position.min(axis=0), kept.min(axis=0))
    upper = np.maximum(wound.reference_position.max(axis=0), kept.max(axis=0))
    margin = 3.0 * wound.spacing + 2.0 * spacing
    cell = 0.5 * max(spacing, wound.spacing)
    volume = float(np.prod(upper - lower + 2.0 * margin))
    cell = max(cell, (volume / NODE_LIMIT) ** (1.0 / 3.0))
    return NodeGrid.around(lower, upper, cell, margin)


def opened(
    grid: NodeGrid, solid: Float32Array, kept: AnyArray, failed: AnyArray, spacing: float
) -> Float32Array:
    """A solid with holes where its nearest material point has failed."""
    if len(failed) == 0:
        return solid
    reach = 2.0 * spacing
    to_failed = grid.distance_to(failed, reach)
    to_kept = grid.distance_to(kept, reach)
    hole = np.where(to_failed < reach, to_kept - to_failed, np.float32(-reach))
    return np.maximum(solid, np.float32(0.5) * hole)


def bone_solid(wound: InjuredLimb, grid: NodeGrid, whole: BoolArray) -> Float32Array:
    """Signed distance [m] of intact bone with its marrow, open where it failed."""
    bone = np.isin(wound.tissue, BONE_TISSUES)
    kept, failed = wound.position[bone & whole], wound.position[bone & ~whole]
    solid = closed_solid(grid, kept, wound.spacing)
    return opened(grid, solid, kept, failed, wound.spacing)


def limb_solid(wound: InjuredLimb, grid: NodeGrid, whole: BoolArray) -> Float32Array:
    """Signed distance [m] of the limb before the injury, with what bulges out of it now."""
    points = np.concatenate([wound.reference_position, wound.position[whole]])
    return closed_solid(grid, points, wound.spacing)


def skin_depth(wound: InjuredLimb, grid: NodeGrid, limb: Float32Array, least: float) -> float:
    """How far skin reaches below the limb's surface [m], from its points; at least `least`."""
    points = wound.reference_position[wound.tissue == Tissue.SKIN]
    if len(points) == 0:
        return 0.0
    distance, _ = grid.sample(limb, points)
    return max(least, float(np.percentile(-distance, 90.0)))


def skin_solid(
    wound: InjuredLimb, grid: NodeGrid, whole: BoolArray, limb: Float32Array, least_depth: float
) -> Float32Array:
    """Signed distance [m] of intact skin, watertight although skin is but a point or two thick.

    Skin is what stands of the limb within the skin's depth below its surface: gaps between skin
    points are closed by the tissue under them, and by bonds of skin that hold where that is gone.
    It is open where a failed skin point is nearer than any that holds.
    """
    skin = wound.tissue == Tissue.SKIN
    standing = closed_solid(grid, wound.position[whole], wound.spacing)
    depth = skin_depth(wound, grid, limb, least_depth)
    solid = np.maximum(standing, -limb - np.float32(depth))
    sheet = np.concatenate([wound.position[skin & whole], skin_bond_middles(wound, whole)])
    own = closed_solid(grid, sheet, wound.spacing)
    np.minimum(solid, own, out=solid)
    kept, failed = wound.position[whole], wound.position[skin & ~whole]
    return opened(grid, solid, kept, failed, wound.spacing)


def surface_layers(
    grid: NodeGrid, distance: Float32Array, spacing: float, layer_count: int
) -> FloatArray:
    """Points (n, 3) [m] inside a solid in layers at depths 0.5, 1.5, ... spacings."""
    layers = []
    for layer in range(layer_count):
        level = -(layer + 0.5) * spacing
        near = np.argwhere(np.abs(distance - np.float32(level)) < 0.6 * grid.cell)
        points = grid.origin + grid.cell * near
        for _ in range(3):
            value, normal = grid.sample(distance, points)
            points = points - (value - level)[:, np.newaxis] * normal
        value, _ = grid.sample(distance, points)
        layers.append(points[np.abs(value - level) < 0.1 * spacing])
    candidates = np.ascontiguousarray(np.concatenate(layers))
    return candidates[_native.thin_points(candidates, LAYER_THINNING * spacing)]


def build_barriers(wound: InjuredLimb, parameters: HemorrhageParameters) -> LimbBarriers:
    """The limb's barriers at the blood's spacing."""
    from scipy.ndimage import gaussian_filter

    dx = parameters.particle_spacing
    whole = intact(wound, parameters)
    grid = limb_grid(wound, whole, dx)
    limb = limb_solid(wound, grid, whole)
    barrier = skin_solid(wound, grid, whole, limb, 1.5 * dx)
    np.minimum(barrier, bone_solid(wound, grid, whole), out=barrier)
    # Distances by whole voxels have steps; a little smoothing gives them a direction.
    barrier = gaussian_filter(barrier, 0.7, mode="nearest", truncate=3.0)
    layer_count = int(np.ceil(parameters.smoothing_ratio))
    particles = surface_layers(grid, barrier, dx, layer_count)
    return LimbBarriers(grid, barrier, limb, particles, skin_depth(wound, grid, limb, 1.5 * dx))


@dataclass(frozen=True, slots=True, eq=False)
class Platform:
    """A placed slab: face's middle `point` [m], unit `normal` and two axes in the face."""

    point: Vector3
    normal: Vector3
    along: Vector3
    across: Vector3
    half_extent: float
    thickness: float

    def corners(self) -> FloatArray:
        """The face's four corners (4, 3) [m]."""
        a, b = np.array(self.along), np.array(self.across)
        signs = ((1, 1), (1, -1), (-1, -1), (-1, 1))
        return np.array(self.point) + self.half_extent * np.array([i * a + j * b for i, j in signs])

    def particles(self, spacing: float) -> FloatArray:
        """Layers of stationary particles below the face (n, 3) [m]."""
        side = np.arange(-self.half_extent + 0.5 * spacing, self.half_extent, spacing)
        depth = np.arange(0.5 * spacing, self.thickness, spacing)
        u, v, w = (m.ravel()[:, np.newaxis] for m in np.meshgrid(side, side, depth, indexing="ij"))
        face = np.array(self.point) + u * np.array(self.along) + v * np.array(self.across)
        return np.asarray(face - w * np.array(self.normal))


def place_platform(
    wanted: PlatformParameters, limb_points: AnyArray, gravity: Vector3, thickness: float
) -> Platform:
    """The slab across gravity below the limb, or where the parameters put it."""
    up = np.array([0.0, 0.0, 1.0])
    if wanted.normal is not None:
        up = np.array(wanted.normal) / np.linalg.norm(wanted.normal)
    elif np.linalg.norm(gravity) > 0.0:
        up = -np.array(gravity) / np.linalg.norm(gravity)
    if wanted.point is not None:
        point = np.array(wanted.point)
    else:
        middle = 0.5 * (limb_points.min(axis=0) + limb_points.max(axis=0)).astype(np.float64)
        lowest = float((limb_points @ up).min()) - wanted.gap
        point = middle + (lowest - middle @ up) * up
    least = np.eye(3)[int(np.argmin(np.abs(up)))]
    along = np.cross(up, least)
    along /= np.linalg.norm(along)
    across = np.cross(up, along)
    p, n, a, b = ((float(v[0]), float(v[1]), float(v[2])) for v in (point, up, along, across))
    return Platform(p, n, a, b, wanted.half_extent, thickness)
