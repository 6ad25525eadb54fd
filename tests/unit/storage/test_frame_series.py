"""Frames open in other programs, and come back with their time."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vulnus.core.errors import StorageError
from vulnus.core.handoff import ParticleFrame
from vulnus.storage import FrameSeries


def frame(index: int, count: int = 50) -> ParticleFrame:
    rng = np.random.default_rng(index)
    return ParticleFrame(
        index=index,
        time=0.04 * index,
        position=rng.random((count, 3), dtype=np.float32),
        point_data={
            "velocity_m_per_s": rng.random((count, 3), dtype=np.float32),
            "pressure_pa": rng.random(count, dtype=np.float32),
            "tissue": np.arange(count, dtype=np.uint8),
        },
        frame_data={
            "projectile_position_m": rng.random((2, 3)),
            "projectile_rotation": rng.random((2, 9)),
        },
    )


@pytest.mark.parametrize("count", [0, 1, 5000])
def test_pyvista_opens_a_frame(tmp_path: Path, count: int) -> None:
    pyvista = pytest.importorskip("pyvista")
    series, kept = FrameSeries(tmp_path, "bleed"), frame(3, count)
    series.save(kept)
    mesh = pyvista.read(series.path(3))
    assert mesh.n_points == mesh.n_cells == count
    if count:
        assert np.array_equal(mesh.points, kept.position)
        for name, values in kept.point_data.items():
            assert np.array_equal(mesh.point_data[name], values)
        assert mesh.field_data["TimeValue"][0] == kept.time
        for name, values in kept.frame_data.items():
            assert np.array_equal(mesh.field_data[name], values)
        assert mesh.verts.reshape(-1, 2)[-1].tolist() == [1, count - 1]


def test_the_index_lists_files_and_times(tmp_path: Path) -> None:
    series = FrameSeries(tmp_path, "bleed")
    for index in range(3):
        series.save(frame(index))
    index = json.loads((tmp_path / "bleed.vtkhdf.series").read_text())
    assert index["files"] == [
        {"name": f"bleed_000{i}.vtkhdf", "time": pytest.approx(0.04 * i)} for i in range(3)
    ]
    assert [item.index for item in series] == [0, 1, 2]
    assert len(series) == 3


def test_a_frame_comes_back_to_the_bit_and_its_file_is_the_same_every_time(tmp_path: Path) -> None:
    series, kept = FrameSeries(tmp_path, "wound"), frame(1)
    series.save(kept)
    first = series.path(1).read_bytes()
    back = series.load(1)
    assert np.array_equal(back.position, kept.position)
    assert back.time == kept.time
    assert set(back.point_data) == set(kept.point_data)
    assert set(back.frame_data) == set(kept.frame_data)
    for name, values in kept.frame_data.items():
        assert np.array_equal(back.frame_data[name], values)
    series.save(back)
    assert series.path(1).read_bytes() == first


def test_a_run_that_goes_on_from_an_earlier_frame_forgets_the_later_ones(tmp_path: Path) -> None:
    series = FrameSeries(tmp_path, "bleed")
    for index in (0, 1, 2, 3, 1):
        series.save(frame(index))
    assert list(series.times()) == [0, 1]


def test_a_damaged_frame_or_index_is_told(tmp_path: Path) -> None:
    series = FrameSeries(tmp_path, "bleed")
    series.save(frame(0))
    series.path(0).write_bytes(series.path(0).read_bytes()[:300])
    with pytest.raises(StorageError, match="bleed_0000"):
        series.load(0)
    series.index_path.write_text("{")
    with pytest.raises(StorageError, match="series"):
        series.times()
