"""Poisson-disk points: smallest distance, density, completeness, determinism."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vulnus.core.errors import VulnusError
from vulnus.geometry import LevelSet, sample_poisson_disk

R = 10e-3


@pytest.fixture(scope="module")
def ball():
    return LevelSet.from_particles([[0.3, -0.5, 0.7]], R, voxel=0.5e-3)


@pytest.mark.parametrize("spacing", [0.4e-3, 0.61e-3, 1.5e-3])
def test_no_two_points_are_nearer_than_the_spacing(ball, spacing):
    points = sample_poisson_disk(ball, spacing=spacing, seed=1).astype(np.float64)
    nearest = cKDTree(points).query(points, k=2)[0][:, 1]
    assert nearest.min() >= spacing  # exactly, as the numbers that are handed over
    assert ball.sample(points).max() < 0.0


def test_density_is_that_of_a_full_set(ball):
    spacing = 0.4e-3
    points = sample_poisson_disk(ball, spacing=spacing, seed=1)
    # 0.71 inside (Bridson's own shell: 0.58; uniform sequential addition ends at 0.733).
    assert 0.69 < len(points) * spacing**3 / ball.volume() < 0.75


def test_no_hole_could_take_another_point(ball):
    spacing = 0.8e-3
    points = sample_poisson_disk(ball, spacing=spacing, seed=2)
    rng = np.random.default_rng(0)
    places = ball.bounds[0] + rng.uniform(size=(60_000, 3)) * (ball.bounds[1] - ball.bounds[0])
    places = places[ball.sample(places) < 0.0]
    gap = cKDTree(points).query(places)[0]
    # 20 candidates a point leave a few slivers: under 1 % of places, none wider than 1.4 spacings.
    assert (gap > spacing).mean() < 0.01
    assert gap.max() < 1.4 * spacing


def test_seed_decides_and_repeats(ball):
    a, b, c = (sample_poisson_disk(ball, spacing=1e-3, seed=s) for s in (1, 1, 2))
    assert a.tobytes() == b.tobytes()
    assert a.tobytes() != c.tobytes()


def test_threads_do_not_change_a_bit(ball, with_threads):
    sets = []
    for threads in (1, 2):
        with_threads(threads)
        sets.append(sample_poisson_disk(ball, spacing=1e-3, seed=4).tobytes())
    assert sets[0] == sets[1]


def test_every_separate_part_gets_points():
    rng = np.random.default_rng(7)
    centres = 0.03 * np.stack(np.meshgrid(*[np.arange(3.0)] * 3), axis=-1).reshape(-1, 3)
    centres += rng.uniform(-5e-3, 5e-3, centres.shape)
    drops = LevelSet.from_particles(centres, 4e-3, voxel=0.5e-3)
    points = sample_poisson_disk(drops, spacing=1e-3, seed=3)
    owner = cKDTree(centres).query(points)[1]
    counts = np.bincount(owner, minlength=27)
    expected = 0.72 * 4 / 3 * np.pi * 4**3
    assert counts.min() > 0.85 * expected  # points crowd the surface; parts differ by chance


def test_function_and_bounds():
    box = ((0.0, 0.0, 0.0), (0.01, 0.02, 0.03))
    points = sample_poisson_disk(
        lambda p: np.linalg.norm(p - 0.01, axis=1) - 8e-3, spacing=1e-3, seed=1, bounds=box
    )
    assert np.linalg.norm(points - 0.01, axis=1).max() < 8e-3 + 1e-4  # a tenth of its voxel
    assert (points >= 0.0).all()
    assert (points <= box[1]).all()
    assert len(points) > 500


def test_bad_input_is_named(ball):
    with pytest.raises(VulnusError, match="spacing"):
        sample_poisson_disk(ball, spacing=0.0, seed=1)
    with pytest.raises(VulnusError, match="bounds"):
        sample_poisson_disk(lambda p: p[:, 0], spacing=1.0, seed=1)
    empty = LevelSet.from_particles(np.empty((0, 3)), 1.0, voxel=1.0)
    assert sample_poisson_disk(empty, spacing=1.0, seed=1).shape == (0, 3)
