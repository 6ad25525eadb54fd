"""What all pictures of one run share: the injured limb's meshes, the studio and the directions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..core.arrays import AnyArray, BoolArray, FloatArray, Vector3
from ..core.handoff import InjuredArtery, InjuredLimb, TriangleSurface
from .camera import Camera, frame_points, side_direction, unit
from .parameters import Surroundings
from .render import Layer, Platform, Studio
from .surface import TissuePoints, bone_surface, tissue_surface
from .tubes import artery_tubes

if TYPE_CHECKING:
    from ..geometry import LevelSet

_LYING_ELEVATION, _STANDING_ELEVATION = np.deg2rad(24.0), np.deg2rad(8.0)  # chosen by eye


@dataclass(frozen=True, slots=True, eq=False)
class LimbView:
    """The injured limb ready to be drawn.

    `level_set` is the tissue's signed distance, `tissue` its coloured surface, `bone` and
    `arteries` the inside, `projectiles` what flew, each in its own frame; `up` is against gravity,
    `long_axis` the limb's, `jet` the way blood leaves (unit vectors, (3,)).
    """

    wound: InjuredLimb
    level_set: LevelSet
    tissue: TriangleSurface
    bone: TriangleSurface
    arteries: TriangleSurface
    up: FloatArray
    long_axis: FloatArray
    jet: FloatArray
    studio: Studio
    projectiles: tuple[TriangleSurface, ...] = ()

    @property
    def outside(self) -> list[Layer]:
        """The opaque limb."""
        return [Layer(self.tissue, "tissue")]

    @property
    def inside(self) -> list[Layer]:
        """The limb without skin and muscle."""
        return [Layer(self.bone, "bone"), Layer(self.arteries, "artery")]

    def is_outside(self, points: AnyArray) -> BoolArray:
        """Which `points` (n, 3) [m] lie outside the tissue, in the open or in a hole."""
        if points.shape[0] == 0:
            return np.zeros(0, dtype=bool)
        return np.asarray(self.level_set.sample(points) > 0.0)

    @property
    def is_upright(self) -> bool:
        """Whether the limb stands rather than lies."""
        return abs(float(self.up @ self.long_axis)) > 0.7

    def whole_camera(self, points: AnyArray, width: int, height: int) -> Camera:
        """A view from the side on the limb and `points` (n, 3) [m]."""
        elevation = _STANDING_ELEVATION if self.is_upright else _LYING_ELEVATION
        parts = [self.tissue.vertices, np.asarray(points).reshape(-1, 3)]
        if self.studio.platform is not None:
            parts.append(self.studio.platform.corners)
        shown = np.concatenate(parts)
        return frame_points(
            shown,
            toward_camera=self.side(elevation),
            up=self.up,
            width=width,
            height=height,
        )

    def studio_for(self, camera: Camera) -> Studio:
        """The studio without ground, upright for `camera`: for views of the limb by itself."""
        return replace(self.studio, up=camera.up, platform=None)

    def side(self, elevation: float) -> FloatArray:
        """The direction towards a viewer beside the limb, unit vector (3,)."""
        return side_direction(
            self.up, long_axis=self.long_axis, facing=self.jet, elevation=elevation
        )


def view_limb(
    wound: InjuredLimb,
    surroundings: Surroundings,
    *,
    voxel_ratio: float = 0.5,
    projectiles: tuple[TriangleSurface, ...] = (),
) -> LimbView:
    """Build meshes and studio for an injured limb; some seconds for a million points.

    `voxel_ratio` is the meshes' voxel over the limb's spacing; a film does with coarser ones.
    """
    down = unit(surroundings.gravity)
    up = -down if np.any(down) else np.array([0.0, 0.0, 1.0])
    points = TissuePoints.of(wound)
    level_set = points.level_set(voxel_ratio)
    tissue = tissue_surface(points, level_set)
    centre = 0.5 * (tissue.vertices.max(axis=0) + tissue.vertices.min(axis=0)).astype(np.float64)
    radius = float(np.max(np.linalg.norm(tissue.vertices - centre, axis=1)))
    offset = tissue.vertices - tissue.vertices.mean(axis=0)
    long_axis = np.linalg.eigh((offset.T @ offset).astype(np.float64))[1][:, -1]
    long_axis = long_axis if long_axis[2] >= 0.0 else -long_axis  # towards the body, as z is
    platform = place_platform(wound, surroundings, up, radius)
    return LimbView(
        wound=wound,
        level_set=level_set,
        tissue=tissue,
        bone=bone_surface(wound, voxel_ratio),
        arteries=artery_tubes([_inside_limb(artery, wound) for artery in wound.arteries]),
        up=up,
        long_axis=long_axis,
        jet=unit(wound.shot.direction),
        studio=Studio(triple(centre), radius, triple(up), platform),
        projectiles=projectiles,
    )


def place_platform(
    wound: InjuredLimb, surroundings: Surroundings, up: FloatArray, radius: float
) -> Platform | None:
    """The ground across gravity, at its point or below the limb of `radius` [m]; None without."""
    if surroundings.platform_point is not None:
        point = np.asarray(surroundings.platform_point, dtype=np.float64)
    elif surroundings.platform_gap is not None:
        points = wound.reference_position
        point = 0.5 * (points.min(axis=0) + points.max(axis=0)).astype(np.float64)
        lowest = float((points @ up).min()) - surroundings.platform_gap
        point += (lowest - point @ up) * up
    else:
        return None
    extent = surroundings.platform_half_extent
    return Platform(triple(point), triple(up), 4.0 * radius, extent)


def triple(vector: AnyArray) -> Vector3:
    """An array (3,) as a plain tuple."""
    x, y, z = (float(component) for component in vector)
    return x, y, z


def _inside_limb(artery: InjuredArtery, wound: InjuredLimb) -> InjuredArtery:
    """The part of an artery that has tissue around it; a cut limb's arteries may go on beyond."""
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(wound.position).query(artery.points)
    covered = np.isfinite(distance) & (distance < 4.0 * wound.spacing)
    covered |= artery.damage >= 0.5  # the gap in the wound is not the end of the limb
    return replace(
        artery,
        reference_points=artery.reference_points[covered],
        points=artery.points[covered],
        radius=artery.radius[covered],
        damage=artery.damage[covered],
    )
