"""Native sparse level sets, meshes and Poisson-disk points, used by several stages.

`LevelSet` is a narrow-band signed distance on 8³ blocks (negative inside, metres, LPS);
`sample_poisson_disk` fills one with points; the mesh functions measure triangle surfaces.
"""

from .level_set import LevelSet
from .mesh import interpolate_to_vertices, surface_area, surface_volume, vertex_normals
from .poisson_disk import sample_poisson_disk

__all__ = [
    "LevelSet",
    "interpolate_to_vertices",
    "sample_poisson_disk",
    "surface_area",
    "surface_volume",
    "vertex_normals",
]
