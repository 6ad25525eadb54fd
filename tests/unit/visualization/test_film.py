"""The film: frames spread evenly, encoded whole, decodable at the right size and number."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import RenderError
from vulnus.visualization.camera import frame_points
from vulnus.visualization.film import (
    bleeding_caption,
    hold,
    part_around,
    spread_indices,
    write_film,
)


def test_frames_are_spread_with_first_and_last() -> None:
    assert spread_indices(5, 10) == [0, 1, 2, 3, 4]
    chosen = spread_indices(100, 7)
    assert len(chosen) == 7
    assert (chosen[0], chosen[-1]) == (0, 99)
    assert spread_indices(0, 3) == []


def test_pictures_are_held_equally_long() -> None:
    shown = hold([0, 1, 2], 10)
    assert len(shown) == 10
    assert max(shown.count(i) for i in range(3)) - min(shown.count(i) for i in range(3)) <= 1
    assert shown == sorted(shown)
    assert hold([0, 1, 2], 2) == [0, 1, 2]  # no picture is lost in a film that is too short
    assert hold([], 10) == []


def test_caption_reads_the_run_at_its_time(outcome) -> None:
    text = bleeding_caption(0.8, outcome)
    lost = 1e6 * np.interp(0.8, outcome.ledger.time, outcome.ledger.injected)
    assert "t = 0.80 s" in text
    assert "300 ml/min" in text  # 5e-6 m³/s at a zero of the sine
    assert f"lost {lost:.1f} ml" in text
    assert bleeding_caption(0.8, None) == "t = 0.80 s"


def test_part_of_a_picture_holds_its_points() -> None:
    everything = np.array([[-0.1, 0.0, -0.1], [0.1, 0.0, 0.1]])
    camera = frame_points(everything, toward_camera=(0, -1, 0), up=(0, 0, 1), width=200, height=100)
    points = np.array([[0.02, 0.0, 0.03], [0.04, 0.0, 0.01]])
    part = part_around(camera, points)
    assert part is not None
    x, y = camera.project(points).T
    assert part.left <= x.min() < x.max() <= part.left + part.width <= 200
    assert part.top <= y.min() < y.max() <= part.top + part.height <= 100
    assert part_around(camera, np.add(points, (5.0, 0.0, 0.0))) is None
    assert part_around(camera, np.zeros((0, 3))) is None


def test_film_decodes_to_its_frames(tmp_path) -> None:
    av = pytest.importorskip("av", reason="PyAV is not installed (vulnus[render])")
    ramp = np.linspace(0, 255, 64).astype(np.uint8)
    pictures = [np.full((48, 64, 3), 10 * k, np.uint8) + ramp[None, :, None] // 2 for k in range(9)]
    path = write_film(tmp_path / "film.mp4", pictures, 12.0)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height) == (64, 48)
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert float(stream.average_rate) == 12.0
        decoded = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    assert len(decoded) == len(pictures)
    # H.264 at crf 18 keeps smooth pictures within a few levels.
    assert np.abs(decoded[4].astype(int) - pictures[4]).mean() < 4.0
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")  # plays while it loads
    assert list(tmp_path.iterdir()) == [path]


def test_film_without_frames_is_refused(tmp_path) -> None:
    pytest.importorskip("av", reason="PyAV is not installed (vulnus[render])")
    with pytest.raises(RenderError, match="no frame"):
        write_film(tmp_path / "film.mp4", [], 24.0)
    assert not list(tmp_path.iterdir())
