"""Cameras see all that they shall, as near as they can."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vulnus.visualization.camera import frame_points, frame_sphere, side_direction, unit

coordinates = st.floats(-0.5, 0.5)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(
    points=arrays(float, (12, 3), elements=coordinates),
    toward=st.tuples(coordinates, coordinates, st.floats(-0.2, 0.2)),
    size=st.sampled_from([(320, 540), (960, 540), (200, 200)]),
)
def test_all_points_lie_inside_the_frame(points, toward, size) -> None:
    direction = unit(np.add(toward, (1.0, 0.0, 0.0)))
    width, height = size
    camera = frame_points(
        points, toward_camera=direction, up=(0, 0, 1), width=width, height=height, margin=0.05
    )
    pixels = camera.project(points)
    border = 1e-6 * max(size)  # rounding
    assert np.all(pixels[:, 0] > 0.05 * width * 0.9 - border)
    assert np.all(pixels[:, 0] < width * (1 - 0.05 * 0.9) + border)
    assert np.all(pixels[:, 1] > 0.05 * height * 0.9 - border)
    assert np.all(pixels[:, 1] < height * (1 - 0.05 * 0.9) + border)


def test_the_frame_is_filled_in_one_direction() -> None:
    rng = np.random.default_rng(2)
    points = rng.uniform(-0.1, 0.1, (50, 3)) * [1.0, 1.0, 3.0]
    camera = frame_points(
        points, toward_camera=(1, 0, 0), up=(0, 0, 1), width=400, height=400, margin=0.0
    )
    pixels = camera.project(points)
    # The nearest camera touches two opposite borders with some point.
    assert np.isclose(pixels[:, 1].min(), 0.0, atol=1e-6)
    assert np.isclose(pixels[:, 1].max(), 400.0, atol=1e-6)


def test_a_point_above_is_drawn_higher() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]])
    camera = frame_points(points, toward_camera=(1, 1, 0), up=(0, 0, 1), width=100, height=100)
    low, high = camera.project(points)
    assert high[1] < low[1]


def test_close_view_shows_the_disk_across_the_shorter_side() -> None:
    camera = frame_sphere(
        (0.1, 0.2, 0.3), 0.02, toward_camera=(0, -1, 0), up=(0, 0, 1), width=300, height=500
    )
    edge = camera.project(np.array([[0.1 + 0.02, 0.2, 0.3], [0.1 - 0.02, 0.2, 0.3]]))
    assert np.allclose(np.sort(edge[:, 0]), [0.0, 300.0], atol=1e-6)


def test_a_lying_limb_is_seen_across_its_axis() -> None:
    direction = side_direction((0, -1, 0), long_axis=(0, 0, 1), facing=(0, 1, 0))
    assert abs(direction[2]) < 1e-6  # the limb's axis runs across the picture
    assert direction @ np.array([0.0, -1.0, 0.0]) > 0.0  # the viewer stands above the ground


def test_a_standing_limb_is_seen_with_the_jet_aside_but_towards_the_viewer() -> None:
    direction = side_direction((0, 0, 1), long_axis=(0, 0, 1), facing=(0, 1, 0))
    assert 0.3 < direction[1] < 0.8
