"""Shapes of rigid bodies: volume and inertia against closed forms; meshes that are refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vulnus.core.errors import InputFileError, ScenarioError
from vulnus.core.handoff import TriangleSurface
from vulnus.injury.bodies.drawn_shapes import BladeShape, Box, Cylinder, Ogive
from vulnus.injury.bodies.mesh_shape import MeshShape
from vulnus.injury.bodies.shapes import Sphere

# The sums over the samples are asked to be within 1 % (POINTS_ACROSS is chosen for it).
CLOSE = 0.01


def cube(size: float = 0.01) -> TriangleSurface:
    """A cube from 0 to `size` [m] on all axes, facing outwards."""
    corner = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], np.float32)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return TriangleSurface(
        vertices=corner * np.float32(size), triangles=np.array(triangles, np.int32)
    )


def assert_solid(shape, volume, inertia):
    assert shape.volume == pytest.approx(volume, rel=CLOSE)
    assert np.allclose(shape.unit_inertia, np.diag(inertia), atol=CLOSE * max(inertia))


def test_a_sphere_has_two_fifths_of_its_mass_times_radius_squared():
    ball = Sphere(0.003)
    assert ball.unit_inertia[1, 1] == pytest.approx(0.4 * ball.volume * 0.003**2)


def test_a_cylinder_has_its_closed_forms():
    r, length = 0.0027, 0.007
    volume = math.pi * r**2 * length
    across = volume * (3.0 * r**2 + length**2) / 12.0
    assert_solid(Cylinder(r, length), volume, (0.5 * volume * r**2, across, across))


def test_a_box_has_its_closed_forms():
    a, b, c = 0.02, 0.01, 0.004
    v = a * b * c
    inertia = (v * (b**2 + c**2) / 12.0, v * (a**2 + c**2) / 12.0, v * (a**2 + b**2) / 12.0)
    assert_solid(Box((a, b, c)), v, inertia)


def test_an_ogive_is_the_solid_of_revolution_of_its_profile():
    r, length, nose = 0.00285, 0.019, 0.010
    shape = Ogive(r, length, nose)
    rho = (r**2 + nose**2) / (2.0 * r)
    x = np.linspace(0.0, length, 20001)
    s = np.maximum(x - (length - nose), 0.0)
    area = np.pi * (np.sqrt(rho**2 - s**2) + r - rho) ** 2
    volume = np.trapezoid(area, x)
    centre = np.trapezoid(area * x, x) / volume
    along = np.trapezoid(area**2 / (2.0 * np.pi), x)
    across = 0.5 * along + np.trapezoid(area * (x - centre) ** 2, x)
    assert_solid(shape, volume, (along, across, across))
    assert shape.centre_of_mass == pytest.approx([centre, 0.0, 0.0], abs=CLOSE * length)
    assert shape.upper[0] == pytest.approx(length - centre, rel=CLOSE)


def test_a_nose_shorter_than_the_radius_is_half_an_ellipsoid():
    shape = Ogive(0.004, 0.003, 0.003)
    assert shape.volume == pytest.approx(2.0 / 3.0 * math.pi * 0.004**2 * 0.003, rel=CLOSE)


def test_a_blade_is_a_plate_that_thins_to_its_edges():
    """Half thickness at the distance e from the nearest edge: t/2 min(1, e / bevel)."""
    length, width, thickness, tip = 0.06, 0.02, 0.002, 0.02
    shape = BladeShape(length, width, thickness, tip)
    x, z = np.meshgrid(np.linspace(0.0, length, 1201), np.linspace(0.0, width / 2, 401))
    from_side = 0.5 * width - z
    normal = np.array([0.5 * width, tip]) / np.hypot(0.5 * width, tip)
    from_tip = (length - x) * normal[0] - z * normal[1]
    edge = np.maximum(np.minimum(from_side, from_tip), 0.0)
    thick = thickness * np.minimum(edge / shape.bevel, 1.0)
    volume = 2.0 * np.trapezoid(np.trapezoid(thick, x[0], axis=1), z[:, 0])
    moment = 2.0 * np.trapezoid(np.trapezoid(thick * x, x[0], axis=1), z[:, 0])
    assert shape.volume == pytest.approx(volume, rel=CLOSE)
    assert shape.inner_radius == pytest.approx(0.5 * thickness, rel=0.02)
    assert shape.centre_of_mass[0] == pytest.approx(moment / volume, rel=CLOSE)


def test_the_distance_of_a_box_is_that_to_its_faces_edges_and_corners():
    box = Box((0.02, 0.01, 0.01))
    grid = box.distance
    x, y, z = np.broadcast_arrays(*grid.axes())
    beyond = [np.abs(c) - h for c, h in ((x, 0.01), (y, 0.005), (z, 0.005))]
    outside = np.sqrt(sum(np.maximum(b, 0.0) ** 2 for b in beyond))
    expected = outside + np.minimum(np.maximum.reduce(beyond), 0.0)
    # The box's centre is its centre of mass, up to the round-off of sums.
    assert np.max(np.abs(grid.values - expected)) < 1e-7


@pytest.fixture(scope="module")
def cylinder_stl(tmp_path_factory):
    """A cylinder of 6 mm by 20 mm along x in millimetres, off the origin."""
    import pyvista as pv

    path = tmp_path_factory.mktemp("stl") / "pin.stl"
    pv.Cylinder(center=(50.0, 0.0, 0.0), direction=(1, 0, 0), radius=3.0, height=20.0,
                resolution=96).triangulate().save(path)  # fmt: skip
    return path


def test_an_stl_file_gives_the_solid_it_bounds(cylinder_stl):
    shape = MeshShape.from_stl(cylinder_stl)
    r, length = 0.003, 0.02
    volume = math.pi * r**2 * length
    across = volume * (3.0 * r**2 + length**2) / 12.0
    assert_solid(shape, volume, (0.5 * volume * r**2, across, across))
    assert shape.centre_of_mass == pytest.approx([0.05, 0.0, 0.0], abs=1e-5)
    assert shape.inner_radius == pytest.approx(r, rel=0.02)
    grid = shape.distance
    x, y, z = np.broadcast_arrays(*grid.axes())
    slab, barrel = np.abs(x) - 0.5 * length, np.hypot(y, z) - r
    outside = np.hypot(np.maximum(slab, 0.0), np.maximum(barrel, 0.0))
    expected = outside + np.minimum(np.maximum(slab, barrel), 0.0)
    # A tenth of a sampling cell: the sagitta of 96 sides, and the sampled surface further off.
    assert np.max(np.abs(grid.values - expected)) < 0.1 * grid.spacing


def test_a_hollow_body_is_hollow():
    """A cube of 10 mm with a cavity of 6 mm: the inner triangles face the cavity."""
    outer, inner = cube(0.01), cube(0.006)
    vertices = np.concatenate([outer.vertices, inner.vertices + np.float32(0.002)])
    triangles = np.concatenate([outer.triangles, inner.triangles[:, ::-1] + 8])
    shape = MeshShape(TriangleSurface(vertices=vertices, triangles=triangles))
    assert shape.volume == pytest.approx(0.01**3 - 0.006**3, rel=0.02)


def open_cube():
    return TriangleSurface(vertices=cube().vertices, triangles=cube().triangles[:-1])


def inside_out():
    return TriangleSurface(vertices=cube().vertices, triangles=cube().triangles[:, ::-1])


def one_flipped():
    triangles = cube().triangles.copy()
    triangles[3] = triangles[3][::-1]
    return TriangleSurface(vertices=cube().vertices, triangles=triangles)


def flat():
    vertices = cube().vertices * np.array([1, 1, 0], np.float32)
    return TriangleSurface(vertices=vertices, triangles=cube().triangles)


def empty():
    return TriangleSurface(vertices=cube().vertices, triangles=np.zeros((0, 3), np.int32))


@pytest.mark.parametrize(
    ("make", "problem"),
    [(open_cube, "open"), (inside_out, "inside out"), (one_flipped, "both ways"),
     (flat, "no volume"), (empty, "no triangles")],
)  # fmt: skip
def test_a_mesh_that_bounds_no_solid_is_refused_by_name(make, problem):
    with pytest.raises(InputFileError, match=problem) as error:
        MeshShape(make(), source="arrow.stl")
    assert error.value.subject == "arrow.stl"


def test_an_open_stl_file_is_refused_by_its_path(tmp_path):
    import pyvista as pv

    path = tmp_path / "sheet.stl"
    pv.Plane().triangulate().save(path)
    with pytest.raises(InputFileError, match="open") as error:
        MeshShape.from_stl(path)
    assert "sheet.stl" in error.value.subject


def test_a_file_that_is_no_stl_is_refused_by_its_path(tmp_path):
    path = tmp_path / "poem.stl"
    path.write_text("so much depends upon a red wheel barrow\n")
    with pytest.raises(InputFileError) as error:
        MeshShape.from_stl(path)
    assert "poem.stl" in error.value.subject
    with pytest.raises(InputFileError, match="exist"):
        MeshShape.from_stl(tmp_path / "none.stl")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Sphere(0.0),
        lambda: Cylinder(-0.001, 0.01),
        lambda: Box((0.01, math.nan, 0.01)),
        lambda: Ogive(0.003, 0.01, 0.02),
        lambda: BladeShape(0.05, 0.02, 0.002, 0.06),
    ],
)
def test_impossible_sizes_are_refused(make):
    with pytest.raises(ScenarioError):
        make()
