"""A rigid body from any closed surface mesh, such as an STL file."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import InputFileError
from vulnus.core.handoff import TriangleSurface
from vulnus.core.units import MILLIMETRE

from ..checked_values import is_a, length, positive
from .shapes import SampledShape
from .signed_distance import SignedDistance, sampling_grid

if TYPE_CHECKING:
    import pyvista as pv

STL_START = 4096
"""Bytes of an STL file that show its format [chosen: past any first line of text]."""

BAND = 2.0
"""Width [sampling points] of the band beside the surface where the exact distance is asked for;
beyond it the distance to a dense sample of the surface does."""


@dataclass(frozen=True, eq=False)
class MeshShape(SampledShape):
    """The solid inside a closed `surface` [m] whose triangles face outwards; nose towards +x.

    `thinnest` [m] is the thickness that the sampling resolves, by default the smallest edge of the
    box around it. `source` is named in errors.
    """

    surface: TriangleSurface
    thinnest: float | None = None
    source: str = "mesh"

    def __post_init__(self) -> None:
        """Refuse meshes that do not bound a solid."""
        is_a("mesh", self.surface, TriangleSurface, "Give a TriangleSurface or from_stl(path).")
        if self.thinnest is not None:
            length("mesh thinnest", self.thinnest)
        _check_closed(self.surface, self.source)

    @classmethod
    def from_stl(
        cls, path: str | Path, *, scale: float = MILLIMETRE, thinnest: float | None = None
    ) -> MeshShape:
        """Read an STL file whose unit is `scale` [m], by default millimetres."""
        positive("mesh scale", scale)
        is_a("STL file", path, (str, Path), "Give its path.")
        source = str(path)
        if not Path(path).is_file():
            raise InputFileError(source, "does not exist", "Check the path of the STL file.")
        _refuse_other_format(Path(path))
        import pyvista as pv

        try:
            with warnings.catch_warnings():  # what VTK complains about is told below
                warnings.simplefilter("ignore")
                mesh = cast("pv.PolyData", pv.read(source, force_ext=".stl"))
            mesh = mesh.triangulate().clean(tolerance=1e-7)
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise InputFileError(source, f"cannot be read ({error})", "Export it anew.") from error
        if mesh.n_cells == 0:
            raise InputFileError(source, "holds no triangles", "Export the surface as STL.")
        surface = TriangleSurface(
            vertices=np.asarray(mesh.points, np.float64).astype(np.float32) * np.float32(scale),
            triangles=np.asarray(mesh.faces.reshape(-1, 4)[:, 1:], np.int32),
        )
        return cls(surface, thinnest, source)

    def drawn_box(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the box around the mesh."""
        vertices = np.asarray(self.surface.vertices, np.float64)
        return vertices.min(axis=0), vertices.max(axis=0)

    def drawn(self) -> SignedDistance:
        """Exact distances beside the surface, those to a dense sample of it further away."""
        from scipy.ndimage import label
        from scipy.spatial import cKDTree

        lower, upper = self.drawn_box()
        thinnest = self.thinnest or float(np.min(upper - lower))
        first, spacing, counts = sampling_grid(lower, upper, thinnest)
        grid = SignedDistance(np.empty(counts, np.float32), first, spacing)
        points = np.stack(np.broadcast_arrays(*grid.axes()), axis=-1).reshape(-1, 3)
        mesh = _polydata(self.surface)
        dense = mesh.subdivide_adaptive(max_edge_len=0.75 * spacing, max_n_passes=12)
        apart = np.asarray(cKDTree(np.asarray(dense.points, np.float64)).query(points)[0])
        near = apart < BAND * spacing
        exact = _exact_distance(mesh, points[near])
        apart[near] = exact
        numbers = np.zeros(counts, np.int32)
        label(~near.reshape(counts), output=numbers)
        region, first_of, back = np.unique(numbers, return_index=True, return_inverse=True)
        sign = np.ones(len(region))  # region 0 is the band, whose signs are exact
        far = region > 0
        sign[far] = np.sign(_exact_distance(mesh, points[first_of[far]]))
        apart *= sign[back.ravel()]
        grid.values[...] = apart.reshape(counts)
        return grid


def _refuse_other_format(path: Path) -> None:
    """Refuse what is no STL file, before a library complains at length."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            start = file.read(STL_START)
    except OSError as error:
        raise InputFileError(str(path), f"cannot be read ({error})", "Check its rights.") from error
    count = int.from_bytes(start[80:84], "little") if len(start) >= 84 else 0
    binary = count > 0 and size >= 84 + 50 * count
    text = start.lstrip()[:5].lower() == b"solid" and b"facet" in start.lower()
    if not (binary or text):
        raise InputFileError(
            str(path), "is no STL file, is cut off, or holds no triangles", "Export it as STL."
        )


def _check_closed(surface: TriangleSurface, source: str) -> None:
    triangles = np.asarray(surface.triangles, np.int64)
    if len(triangles) == 0:
        raise InputFileError(source, "holds no triangles", "Export the surface anew.")
    vertices = np.asarray(surface.vertices, np.float64)
    if not np.all(np.isfinite(vertices)):
        raise InputFileError(source, "holds a vertex that is not finite", "Export it anew.")
    count = len(vertices)
    if triangles.min() < 0 or triangles.max() >= count:
        raise InputFileError(source, "has a triangle without its vertex", "Export it anew.")
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward, times = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    backward = np.unique(edges[:, 1] * count + edges[:, 0])
    sides = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1]
    if np.any(sides == 1):
        raise InputFileError(
            source,
            f"is open: {np.count_nonzero(sides == 1)} edges have one triangle only",
            "Close its holes; a rigid body needs a watertight surface.",
        )
    if np.any(times > 1) or not np.array_equal(forward, backward):
        raise InputFileError(
            source,
            "has triangles that face both ways or share an edge with more than one other",
            "Make its normals consistent and remove inner walls.",
        )
    corners = vertices[triangles]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    extent = float(np.prod(vertices.max(axis=0) - vertices.min(axis=0)))
    if not math.isfinite(volume) or abs(volume) <= 1e-6 * extent or extent <= 0.0:
        raise InputFileError(source, "encloses no volume", "Give a solid body.")
    if volume < 0.0:
        raise InputFileError(source, "is turned inside out", "Flip the normals of its triangles.")


def _polydata(surface: TriangleSurface) -> pv.PolyData:
    import pyvista as pv

    triangles = np.asarray(surface.triangles)
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    return pv.PolyData(np.asarray(surface.vertices, np.float64), faces)


def _exact_distance(mesh: pv.PolyData, points: FloatArray) -> FloatArray:
    """Signed distance [m] of points (n, 3) [m] to a closed mesh."""
    import pyvista as pv

    cloud = pv.PolyData(points).compute_implicit_distance(mesh)
    return np.asarray(cloud["implicit_distance"], np.float64)
