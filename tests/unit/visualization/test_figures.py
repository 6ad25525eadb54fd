"""Figures hold the run's numbers in the units of their axes; files are whole or absent."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import StorageError
from vulnus.visualization.figure_style import save_figure
from vulnus.visualization.figures import cycle_figure, flow_figure, ledger_figure, pressure_figure
from vulnus.visualization.particle_figures import passage_figure, slices_figure
from vulnus.visualization.picture import write_whole

PNG = b"\x89PNG\r\n\x1a\n"
ML_PER_MIN = 6e7
MMHG = 133.322387415


def test_cycle_shows_aorta_dashed_artery_solid_and_flow(outcome) -> None:
    figure = cycle_figure(outcome.waveforms, artery="anterior_tibial")
    left, right = figure.axes
    aorta, artery = left.lines
    assert aorta.get_linestyle() == "--"
    assert artery.get_linestyle() == "-"
    assert np.allclose(aorta.get_ydata(), outcome.waveforms.pressure_aorta / MMHG)
    assert np.allclose(artery.get_ydata(), outcome.waveforms.pressure_artery / MMHG)
    assert np.allclose(right.lines[0].get_ydata(), outcome.waveforms.flow_injury * ML_PER_MIN)
    assert "mmHg" in left.get_ylabel()
    assert "ml/min" in right.get_ylabel()


def test_flow_figure_steps_through_the_means_of_the_beats(outcome) -> None:
    axes = flow_figure(outcome).axes[0]
    assert np.allclose(axes.lines[0].get_ydata(), outcome.waveforms.flow_injury * ML_PER_MIN)
    steps = axes.patches[0].get_data()
    assert np.allclose(steps.values, outcome.mean_flow_per_beat * ML_PER_MIN)
    assert np.allclose(steps.edges, [0.0, 0.8, 1.6])


def test_pressure_figure_has_three_curves(outcome) -> None:
    axes = pressure_figure(outcome).axes[0]
    wound = [line for line in axes.lines if "wound" in str(line.get_label())]
    assert len(axes.lines) == 3
    assert np.allclose(wound[0].get_ydata(), outcome.waveforms.pressure_injury / MMHG)


def test_ledger_stack_reaches_what_was_injected(outcome) -> None:
    axes = ledger_figure(outcome.ledger).axes[0]
    tops = [area.get_paths()[0].vertices[:, 1].max() for area in axes.collections]
    assert np.isclose(max(tops), outcome.ledger.injected[-1] * 1e6)
    assert np.isclose(tops[0], outcome.ledger.in_limb[-1] * 1e6)
    assert "ml" in axes.get_ylabel()


def test_passage_has_a_row_for_each_instant_and_points_in_the_paper_s_colours(
    wound, injury_frames
) -> None:
    figure = passage_figure(wound, injury_frames)
    assert len(figure.axes) == 2 * len(injury_frames)
    first = figure.axes[0].collections[0]
    colours = first.get_facecolors()[:, :3]
    yellow = np.array([0xE8, 0xC9, 0x3F]) / 255.0
    assert np.any(np.all(np.isclose(colours, yellow), axis=1))


def test_slices_run_from_proximal_to_distal(labels) -> None:
    figure = slices_figure(labels, count=4)
    heights = [float(axes.get_title().split()[2]) for axes in figure.axes]
    assert heights == sorted(heights, reverse=True)


def test_figures_become_png_files(outcome, tmp_path) -> None:
    path = save_figure(flow_figure(outcome), tmp_path / "figures" / "flow.png", 60)
    assert path.read_bytes().startswith(PNG)
    assert [item.name for item in path.parent.iterdir()] == ["flow.png"]  # no partial file stays


def test_a_write_that_breaks_leaves_the_old_file(tmp_path) -> None:
    path = tmp_path / "picture.png"
    path.write_bytes(b"old")

    def full_disk(partial) -> None:
        partial.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    with pytest.raises(StorageError, match=r"picture\.png.*No space left"):
        write_whole(path, full_disk)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
