"""Surfaces to look at: the blood's by the paper's sequence, the injured tissue's by its points.

The paper (§2.3, visualization): a signed distance field wraps around all particles, five
iterations of mean-curvature flow take the reconstruction noise away, marching cubes makes the
triangles. Voxel and radius are ours (`BloodSurfaceParameters`). A volume must never be measured
on such a mesh: spheres of one particle spacing hold 4.2 times a particle's volume.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..core.arrays import AnyArray, BoolArray, Float32Array, FloatArray, LabelArray
from ..core.handoff import InjuredLimb, Tissue, TriangleSurface
from .materials import tissue_colours
from .parameters import BloodSurfaceParameters

if TYPE_CHECKING:
    from ..geometry import LevelSet

_COLOUR_NEIGHBOURS = 8  # chosen: as many points as lie around one vertex of a Poisson-disk set
_TISSUE_ITERATIONS = 14  # chosen by eye: skin without the grain of its points
_SHRINK = 0.5  # spacings by which a union of spheres is taken back to the tissue's own size
HARD = (Tissue.BONE, Tissue.CANCELLOUS, Tissue.MARROW)


def empty_surface() -> TriangleSurface:
    """A surface without triangles."""
    return TriangleSurface(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))


def join_surfaces(surfaces: list[TriangleSurface]) -> TriangleSurface:
    """All triangles in one surface; data on vertices is dropped."""
    offsets = np.cumsum([0] + [surface.vertices.shape[0] for surface in surfaces])[:-1]
    vertices = np.concatenate([surface.vertices for surface in surfaces])
    triangles = np.concatenate(
        [surface.triangles + offset for surface, offset in zip(surfaces, offsets, strict=True)]
    )
    return TriangleSurface(vertices.astype(np.float32), triangles.astype(np.int32))


def blood_surface(
    position: AnyArray,
    spacing: float,
    parameters: BloodSurfaceParameters,
    *,
    velocity: AnyArray | None = None,
) -> TriangleSurface:
    """The closed surface around blood particles at `position` (n, 3) [m] of `spacing` [m].

    `velocity` (n, 3) [m/s], where given, comes back on the vertices under "velocity". Particles
    whose position is not finite are left out.
    """
    from ..geometry import LevelSet, interpolate_to_vertices

    finite = np.all(np.isfinite(position), axis=1)
    points = np.ascontiguousarray(np.asarray(position)[finite], dtype=np.float32)
    if points.shape[0] == 0:
        return empty_surface()
    radius = parameters.radius_ratio * spacing
    level_set = LevelSet.from_particles(
        points,
        radius,
        voxel=parameters.voxel_ratio * spacing,
        keep_droplets=parameters.keep_droplets,
    )
    surface = level_set.mean_curvature_flow(parameters.iterations).to_surface()
    if velocity is None:
        return surface
    data = {"velocity": np.asarray(velocity)[finite]}
    return interpolate_to_vertices(surface, points, data, radius=2.0 * radius)


@dataclass(frozen=True, slots=True, eq=False)
class TissuePoints:
    """Points of tissue to be drawn: `position` (n, 3) [m], `tissue` codes (n,), `damage` (n,) 0-1.

    `spacing` [m] is the smallest distance of two points before the injury.
    """

    position: Float32Array
    tissue: LabelArray
    damage: Float32Array
    spacing: float

    @classmethod
    def of(cls, wound: InjuredLimb) -> TissuePoints:
        """All points of an injured limb."""
        return cls(wound.position, wound.tissue, wound.damage, wound.spacing)

    def only(self, chosen: BoolArray) -> TissuePoints:
        """The points where `chosen` (n,) is true."""
        return TissuePoints(
            self.position[chosen], self.tissue[chosen], self.damage[chosen], self.spacing
        )

    def level_set(self, voxel_ratio: float = 0.5) -> LevelSet:
        """The signed distance of the tissue: a smoothed union of spheres, taken back to size.

        The number of iterations falls with the square of `voxel_ratio` (voxel over spacing), so
        that the same length is smoothed.
        """
        from ..geometry import LevelSet

        voxel = voxel_ratio * self.spacing
        iterations = round(_TISSUE_ITERATIONS * (0.5 / voxel_ratio) ** 2)
        union = LevelSet.from_particles(self.position, self.spacing, voxel=voxel)
        return union.mean_curvature_flow(iterations).offset(-_SHRINK * self.spacing)


def tissue_surface(points: TissuePoints, level_set: LevelSet) -> TriangleSurface:
    """The zero level of `level_set`, coloured by the tissue that lies there.

    "colour" on the vertices is linear RGB (n, 3), torn points stained; "roughness" (n,) is low
    where raw tissue is wet.
    """
    surface = level_set.to_surface()
    data = _appearance(points, surface.vertices)
    return TriangleSurface(surface.vertices, surface.triangles, data)


def bone_surface(wound: InjuredLimb, voxel_ratio: float = 0.5) -> TriangleSurface:
    """The bones after the passage: the limb's smooth surface while they are whole, else by points.

    Whole means that no point of bone moved by more than one spacing.
    """
    points = TissuePoints.of(wound)
    hard: BoolArray = np.isin(wound.tissue, HARD)
    if not hard.any():
        return empty_surface()
    moved = np.linalg.norm(wound.position[hard] - wound.reference_position[hard], axis=1)
    if float(np.max(moved)) < wound.spacing and "bone" in wound.surfaces:
        return wound.surfaces["bone"]
    return points.only(np.isin(points.tissue, HARD)).level_set(voxel_ratio).to_surface()


def _appearance(points: TissuePoints, vertices: Float32Array) -> dict[str, Float32Array]:
    from scipy.spatial import cKDTree

    count = min(_COLOUR_NEIGHBOURS, points.position.shape[0])
    distance, index = cKDTree(points.position).query(vertices, k=[*range(1, count + 1)], workers=-1)
    # Whole skin hides what lies just behind it: its points count as nearer than they are.
    whole_skin = (points.tissue == Tissue.SKIN) & (points.damage < 0.5)
    distance = np.maximum(distance - 0.6 * points.spacing * whole_skin[index], 0.0)
    weight = np.exp(-((distance / (0.65 * points.spacing)) ** 2)) + 1e-9
    weight /= weight.sum(axis=1, keepdims=True)
    covered = np.isin(points.tissue, [Tissue.SKIN, *HARD])
    dry = np.where(covered, 1.0, 0.35) * (1.0 - 0.6 * np.clip(points.damage, 0.0, 1.0))
    colours = tissue_colours(points.tissue, points.damage)
    colour = np.einsum("vk,vkc->vc", weight, colours[index])
    colour *= 1.0 + 0.05 * mottling(vertices)[:, None] * np.array([0.6, 1.0, 1.0])
    dryness = np.einsum("vk,vk->v", weight, dry[index])
    return {
        "colour": np.asarray(colour, dtype=np.float32),
        "roughness": np.asarray(0.12 + 0.36 * dryness, dtype=np.float32),
    }


def mottling(points: AnyArray) -> FloatArray:
    """A smooth, repeatable pattern (n,) within ±1 at the scale of 8-30 mm, as living skin has."""
    waves = np.array(  # wave vectors [1/m]; chosen: no two parallel, none a multiple of another
        [[210, 95, 140], [-130, 260, 70], [75, -160, 230], [330, 210, -290], [-370, 190, 310]]
    )
    phases = np.array([0.3, 1.9, 4.1, 2.7, 5.3])
    return np.asarray(np.sin(np.asarray(points, np.float64) @ waves.T + phases).mean(axis=1))
