"""The surface that is drawn of a body is that of its shape."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.handoff import TriangleSurface
from vulnus.injury import BladeShape, Box, Cylinder, Ogive, Shape, Sphere
from vulnus.injury.shot.body_surface import body_surface


def volume(surface: TriangleSurface) -> float:
    corner = surface.vertices[surface.triangles].astype(np.float64)
    return float(np.einsum("tc,tc->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6.0)


@pytest.mark.parametrize(
    "shape",
    [
        Sphere(0.0045),
        Cylinder(0.0027, 0.0061),
        Ogive(0.0045, 0.0155, 0.009),
        Box((0.01, 0.02, 0.005)),
        BladeShape(0.12, 0.025, 0.002, 0.025),
    ],
)
def test_a_body_s_surface_holds_its_volume_within_its_box(shape: Shape) -> None:
    surface = body_surface(shape)
    # Marching cubes cuts corners and edges off: at ten samples across, a few per cent.
    assert volume(surface) == pytest.approx(shape.volume, rel=0.08)
    size = shape.upper - shape.lower
    assert np.all(surface.vertices.min(axis=0) > shape.lower - 0.02 * size.max())
    assert np.all(surface.vertices.max(axis=0) < shape.upper + 0.02 * size.max())
    assert np.allclose(np.ptp(surface.vertices, axis=0), size, rtol=0.08, atol=2e-4)
