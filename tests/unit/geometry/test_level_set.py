"""The sparse level set: distances, signs, grid, combinations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import VulnusError
from vulnus.geometry import LevelSet

H = 1e-3


def union_distance(points, centres, radii):
    """The law in NumPy: nearest of all spheres."""
    gaps = np.linalg.norm(points[:, None] - centres[None], axis=2) - radii[None]
    return gaps.min(axis=1)


def voxel_centres(level_set):
    blocks, values = level_set.blocks
    o = np.arange(512)
    local = np.stack([o // 64, o // 8 % 8, o % 8], axis=1)
    index = 8 * blocks[:, None].astype(float) + local[None]
    return level_set.voxel * index.reshape(-1, 3), values.reshape(-1)


@settings(max_examples=12, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 40))
def test_union_of_spheres_is_the_nearest_sphere_at_every_voxel(seed, count):
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-0.02, 0.02, (count, 3)) + rng.uniform(-0.5, 0.5, 3)
    radii = rng.uniform(1e-3, 9e-3, count)
    level_set = LevelSet.from_particles(centres, radii, voxel=H)
    points, phi = voxel_centres(level_set)
    exact = np.clip(union_distance(points, centres, radii), -3 * H, 3 * H)
    # float32 of lengths up to some 20 voxels: 1e-6 voxels each, a few of them added.
    assert np.abs(phi - exact).max() < 2e-5 * H


@settings(max_examples=8, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10_000))
def test_sign_is_right_everywhere_also_outside_the_band(seed):
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-0.03, 0.03, (4, 3))
    radii = rng.uniform(5e-3, 25e-3, 4)
    level_set = LevelSet.from_particles(centres, radii, voxel=H)
    points = rng.uniform(-0.06, 0.06, (4000, 3))
    exact = union_distance(points, centres, radii)
    clear = np.abs(exact) > H
    sampled = level_set.sample(points)
    assert (np.sign(sampled) == np.sign(exact))[clear].all()
    deep = np.abs(exact) > 4.8 * H  # all eight corners of the cell then lie beyond the band
    np.testing.assert_allclose(sampled[deep], 3 * H * np.sign(exact[deep]), rtol=1e-6)


def test_a_wide_sphere_keeps_no_values_inside():
    level_set = LevelSet.from_particles(np.zeros((1, 3)), 0.1, voxel=H)
    shell = 4 * np.pi * 0.1**2 * 6 * H / H**3
    assert level_set.block_count * 512 < 4 * shell  # blocks overhang the band on both sides
    assert level_set.sample([[0.0, 0.0, 0.0]])[0] == pytest.approx(-3 * H)


@pytest.mark.parametrize("radius", [1e-6, 0.3e-3, 0.8e-3])
def test_no_small_sphere_is_dropped(radius):
    rng = np.random.default_rng(3)
    centres = 0.02 * np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
    centres += rng.uniform(0, H, centres.shape)
    level_set = LevelSet.from_particles(centres, radius, voxel=H)
    surface = level_set.to_surface()
    nearest = np.rint(surface.vertices / 0.02).astype(int)
    assert len(np.unique(nearest, axis=0)) == 64


def test_grid_is_aligned_to_multiples_of_the_voxel():
    """A cloud moved by whole voxels gives the same mesh, moved: no flicker between frames."""
    rng = np.random.default_rng(5)
    # Positions on a lattice of voxel/64, so that the moved ones are the same binary numbers.
    voxel = 2.0**-10
    cloud = rng.integers(-1500, 1500, (300, 3)) * voxel / 64
    step = voxel * np.array([3, -17, 40])
    a = LevelSet.from_particles(cloud, 2 * voxel, voxel=voxel).to_surface()
    b = LevelSet.from_particles(cloud + step, 2 * voxel, voxel=voxel).to_surface()

    def sort(s):
        return s[np.lexsort(s.T)]

    np.testing.assert_allclose(sort(a.vertices + step), sort(b.vertices), atol=1e-3 * voxel)
    on_line = np.abs(a.vertices / voxel - np.rint(a.vertices / voxel)) < 1e-4
    assert (on_line.sum(axis=1) >= 2).all()  # every vertex lies on a grid edge


def test_threads_do_not_change_a_bit(with_threads):
    rng = np.random.default_rng(8)
    cloud = rng.normal(0, 6e-3, (5000, 3))
    results = []
    for threads in (1, 2, 3):
        with_threads(threads)
        level_set = LevelSet.from_particles(cloud, 1e-3, voxel=0.5e-3, keep_droplets=True)
        level_set = level_set.mean_curvature_flow(5)
        surface = level_set.to_surface()
        results.append((surface.vertices.tobytes(), surface.triangles.tobytes()))
        results[-1] += (level_set.volume(),)
    assert results[0] == results[1] == results[2]


def test_trilinear_sample_and_gradient_reproduce_a_plane():
    normal = np.array([2.0, -1.0, 2.0]) / 3
    plane = LevelSet.from_function(
        lambda p: p @ normal - 1e-4, bounds=((-0.01,) * 3, (0.01,) * 3), voxel=H
    )
    points = np.random.default_rng(1).uniform(-9e-3, 9e-3, (500, 3))
    points = points[np.abs(points @ normal) < 1e-3]
    np.testing.assert_allclose(plane.sample(points), points @ normal - 1e-4, atol=1e-5 * H)
    np.testing.assert_allclose(plane.gradient(points), np.tile(normal, (len(points), 1)), atol=1e-5)


def test_volumes_of_union_intersection_difference_and_cut():
    r, d = 10e-3, 8e-3
    a = LevelSet.from_particles([[0.0, 0.0, 0.0]], r, voxel=0.5e-3)
    b = LevelSet.from_particles([[d, 0.0, 0.0]], r, voxel=0.5e-3)
    ball = 4 / 3 * np.pi * r**3
    lens = np.pi * (4 * r + d) * (2 * r - d) ** 2 / 12  # of two equal spheres
    # The sampled volume is good to the curvature over a voxel: (h/R)² = 0.25 %.
    assert a.volume() == pytest.approx(ball, rel=4e-3)
    assert a.intersection(b).volume() == pytest.approx(lens, rel=1e-2)
    assert a.union(b).volume() == pytest.approx(2 * ball - lens, rel=4e-3)
    assert a.difference(b).volume() == pytest.approx(ball - lens, rel=1e-2)
    assert a.cut((0.6, 0.0, 0.8), 0.0).volume() == pytest.approx(ball / 2, rel=4e-3)
    assert a.offset(1e-3).volume() == pytest.approx(4 / 3 * np.pi * (r + 1e-3) ** 3, rel=4e-3)


def test_a_tube_has_the_volume_of_its_frustum():
    points = np.array([[0.0, 0.0, 0.0], [0.01, 0.02, 0.02]])  # 30 mm long
    tube = LevelSet.from_tube(points, np.array([2e-3, 4e-3]), voxel=0.4e-3)
    frustum = np.pi * 0.03 / 3 * (4 + 8 + 16) * 1e-6
    ends = 2 / 3 * np.pi * (8 + 64) * 1e-9
    # Slope 1/15 of the wall: the distance to the axis' radius is long by its square, 0.2 %.
    assert tube.volume() == pytest.approx(frustum + ends, rel=1e-2)


def rotation(axis, angle):
    axis = np.asarray(axis) / np.linalg.norm(axis)
    k = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * k.T + (1 - np.cos(angle)) * (k.T @ k.T)


@pytest.mark.parametrize("direction", [np.eye(3), rotation([1, 2, 3], 0.7)])
def test_mask_on_an_oblique_anisotropic_grid(direction):
    spacing, origin = np.array([0.7e-3, 1.1e-3, 1.9e-3]), np.array([0.1, -0.2, 0.3])
    index = np.stack(np.meshgrid(*[np.arange(n) for n in (60, 44, 30)], indexing="ij"), axis=-1)
    centre = np.array([30.0, 20.0, 14.0])
    mask = (((index - centre) * spacing) ** 2).sum(axis=-1) < 0.015**2
    level_set = LevelSet.from_mask(
        mask, origin=origin, spacing=spacing, direction=direction, voxel=0.7e-3
    )
    # The mask's own count of a 15 mm sphere is within 1 % of it; stairs of 1.9 mm cost another.
    assert level_set.volume() == pytest.approx(mask.sum() * spacing.prod(), rel=0.02)
    middle = origin + direction @ (spacing * centre)
    low, high = (f(level_set.to_surface().vertices, axis=0) for f in (np.min, np.max))
    np.testing.assert_allclose((low + high) / 2, middle, atol=1e-3)  # half the coarsest voxel


def test_smoothing_a_thin_plate_by_its_distance_deletes_it():
    """The trap that makes the skin a shell: 2 mm plate, sigma 1.5 mm (IMAGING, smoothing test)."""
    mask = np.zeros((40, 40, 40), dtype=bool)
    mask[5:-5, 5:-5, 19:21] = True
    grid = {"origin": np.zeros(3), "spacing": np.full(3, H), "direction": np.eye(3)}
    kept = LevelSet.from_mask(mask, voxel=0.5e-3, **grid)
    lost = LevelSet.from_mask(mask, voxel=0.5e-3, smoothing=1.5e-3, **grid)
    assert kept.volume() == pytest.approx(mask.sum() * H**3, rel=0.05)  # edges are rounded
    assert lost.volume() < 0.2 * kept.volume()


def test_stairs_go_and_thin_parts_stay():
    """A shallow slope loses its terraces; a plate of two voxels keeps its volume."""
    x, y, z = np.meshgrid(*[np.arange(64)] * 3, indexing="ij")
    grid = {"origin": np.zeros(3), "spacing": np.full(3, H), "direction": np.eye(3)}
    slope = z < 30 + x / 9.0 + y / 13.0
    normal = np.array([-1 / 9.0, -1 / 13.0, 1.0])

    def roughness(stair_smoothing):
        level_set = LevelSet.from_mask(slope, voxel=H, stair_smoothing=stair_smoothing, **grid)
        vertices = level_set.to_surface().vertices / H
        middle = (np.abs(vertices - 31.5) < 20).all(axis=1)
        return np.std(vertices[middle] @ normal / np.linalg.norm(normal))

    assert roughness(0.0) > 0.2  # a step of one voxel: 1/sqrt(12) of it
    assert roughness(2.0) < 0.3 * roughness(0.0)  # 0.26; the limit of 0.4 voxel leaves some
    plate = (np.abs(x - 31.5) < 1) & (np.abs(y - 31.5) < 20) & (np.abs(z - 31.5) < 20)
    kept = LevelSet.from_mask(plate, voxel=0.5 * H, stair_smoothing=2.0, **grid)
    assert kept.volume() > 0.45 * plate.sum() * H**3  # half a voxel off each side at most


def test_slabs_of_the_distance_transform_do_not_show(monkeypatch):
    from vulnus.geometry import signed_distance

    mask = np.random.default_rng(0).uniform(size=(70, 20, 20)) < 0.02
    kw = {"reach": 3e-3, "smoothing": 0.5e-3}
    whole = signed_distance.mask_signed_distance(mask, np.full(3, H), **kw)
    monkeypatch.setattr(signed_distance, "VOXELS_PER_PASS", 6000)
    parts = signed_distance.mask_signed_distance(mask, np.full(3, H), **kw)
    np.testing.assert_allclose(whole, parts, atol=1e-6 * H)


def test_empty_sets_are_allowed():
    empty = LevelSet.from_particles(np.empty((0, 3)), 1e-3, voxel=H)
    assert empty.volume() == 0.0
    assert len(empty.mean_curvature_flow(2).to_surface().vertices) == 0
    assert empty.sample([[0.0, 0.0, 0.0]])[0] == pytest.approx(3 * H)


@pytest.mark.parametrize(
    ("call", "subject"),
    [
        (lambda: LevelSet.from_particles(np.zeros((2, 2)), 1.0, voxel=H), "position"),
        (lambda: LevelSet.from_particles(np.full((2, 3), np.nan), 1.0, voxel=H), "position"),
        (lambda: LevelSet.from_particles(np.zeros((2, 3)), -1.0, voxel=H), "radius"),
        (lambda: LevelSet.from_particles(np.zeros((2, 3)), 1.0, voxel=0.0), "voxel"),
        (
            lambda: LevelSet.from_dense(
                np.ones((4, 4, 4)),
                origin=np.zeros(3),
                spacing=np.ones(3),
                direction=np.eye(3),
                voxel=1e-4,
            ),
            "voxel",
        ),
    ],
)
def test_bad_input_is_named(call, subject):
    with pytest.raises(VulnusError) as caught:
        call()
    assert caught.value.subject == subject
