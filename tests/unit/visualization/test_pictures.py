"""Ray-traced pictures: one small still by the scalar variant; what happens without Mitsuba."""

from __future__ import annotations

import builtins
import importlib.util

import numpy as np
import pytest

from vulnus.core.errors import RenderError
from vulnus.core.handoff import Tissue
from vulnus.visualization import (
    BloodSurfaceParameters,
    FilmParameters,
    RunToDraw,
    Surroundings,
    VisualizationParameters,
    blood_surface,
    draw_all,
)
from vulnus.visualization.frames import FramesOnDemand, points_in_passage
from vulnus.visualization.limb_view import view_limb
from vulnus.visualization.picture import to_srgb
from vulnus.visualization.tubes import artery_tubes, tube
from vulnus.visualization.variant import choose_variant, find_llvm

SMALL = VisualizationParameters(
    renderer="scalar",
    width=160,
    height=90,
    samples=4,
    figure_dots_per_inch=40,
    film=FilmParameters(enabled=False),
)


@pytest.fixture(scope="module")
def view(wound):
    return view_limb(wound, Surroundings())


def skip_without_mitsuba() -> None:
    """Without importing it: what imports it first decides which LLVM it takes."""
    if importlib.util.find_spec("mitsuba") is None:
        pytest.skip("Mitsuba is not installed (vulnus[render])")


def test_a_small_still_shows_skin_bone_and_blood(view, bleed_frames) -> None:
    skip_without_mitsuba()
    from vulnus.visualization.render import Renderer
    from vulnus.visualization.stills import bleed_view

    blood = blood_surface(bleed_frames[-1].position, 2e-3, BloodSurfaceParameters())
    renderer = Renderer(SMALL)
    assert renderer.variant == "scalar_rgb"
    picture = bleed_view(renderer, view, blood)
    assert picture.shape == (90, 160, 3)
    shown = to_srgb(picture).astype(int)
    red, green, blue = shown[..., 0], shown[..., 1], shown[..., 2]
    assert np.mean((red > 90) & (red > 2 * green)) > 0.002  # blood and arteries
    assert np.mean((red > 150) & (red - blue > 25) & (green - blue > 8)) > 0.01  # flesh and bone
    assert np.mean((abs(red - blue) < 25) & (red > 120)) > 0.2  # the neutral backdrop


@pytest.fixture
def without_mitsuba(monkeypatch) -> None:
    real = importlib.util.find_spec

    def find(name, package=None):
        return None if name == "mitsuba" else real(name, package)

    monkeypatch.setattr(importlib.util, "find_spec", find)


@pytest.fixture
def run(wound, labels, injury_frames, bleed_frames, outcome) -> RunToDraw:
    return RunToDraw(
        wound=wound,
        labels=labels,
        beat=outcome.waveforms,
        outcome=outcome,
        injury_frames=injury_frames,
        bleed_frames=FramesOnDemand(len(bleed_frames), bleed_frames.__getitem__),
        blood_spacing=2e-3,
    )


@pytest.mark.usefixtures("without_mitsuba")
def test_everything_is_drawn_but_rays_where_mitsuba_is_missing(run, tmp_path) -> None:
    with pytest.raises(RenderError, match=r"pip install 'vulnus\[render\]'"):
        choose_variant("auto")
    drawn = draw_all(run, SMALL, tmp_path)
    names = {path.name for path in drawn.files}
    assert names == {
        "cycle.png",
        "flow.png",
        "pressure.png",
        "blood_loss.png",
        "passage.png",
        "slices.png",
        "pipeline.png",
    }
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn.files)
    assert len(drawn.complaints) == 1
    assert "vulnus[render]" in drawn.complaints[0]


def test_a_wound_that_does_not_bleed_is_drawn(wound, tmp_path) -> None:
    parameters = VisualizationParameters(
        stills=False, figure_dots_per_inch=40, film=FilmParameters(enabled=False)
    )
    drawn = draw_all(RunToDraw(wound=wound), parameters, tmp_path)
    assert [path.name for path in drawn.files] == ["pipeline.png"]
    assert drawn.complaints == ()


def test_nothing_is_drawn_where_it_is_switched_off(wound, tmp_path) -> None:
    drawn = draw_all(RunToDraw(wound=wound), VisualizationParameters(enabled=False), tmp_path)
    assert drawn.files == ()
    assert not list(tmp_path.iterdir())


def test_a_tracer_that_fails_once_is_tried_again_and_then_named(view, monkeypatch) -> None:
    skip_without_mitsuba()
    from vulnus.visualization.render import Renderer

    renderer = Renderer(SMALL)
    real, failures = renderer.mitsuba.render, [RuntimeError("busy")]

    def fail_first(*rest, **named):
        if failures:
            raise failures.pop()
        return real(*rest, **named)

    monkeypatch.setattr(renderer.mitsuba, "render", fail_first)
    camera = view.whole_camera(np.zeros((0, 3)), 16, 16)
    arranged = renderer.arrange(view.inside, view.studio, camera)
    assert renderer.render(arranged, camera, samples=1).colour.shape == (16, 16, 3)
    failures += [RuntimeError("busy"), RuntimeError("busy")]
    with pytest.raises(RenderError, match=r"could not be traced \(busy\)"):
        renderer.render(arranged, camera, samples=1)


def test_passes_add_up_to_the_samples_and_stay_short() -> None:
    from vulnus.visualization.render import split_samples

    assert split_samples(16, 160 * 90) == [16]
    for samples, pixels in ((16, 960 * 540), (7, 960 * 540), (1, 4000 * 4000)):
        shares = split_samples(samples, pixels)
        assert sum(shares) == samples
        assert min(shares) >= 1
        assert max(shares) == 1 or max(shares) * pixels < 2_000_000


def test_llvm_that_does_not_work_falls_back_or_complains(monkeypatch) -> None:
    skip_without_mitsuba()
    monkeypatch.setattr("vulnus.visualization.variant.llvm_works", lambda: False)
    assert choose_variant("auto") == "scalar_rgb"
    with pytest.raises(RenderError, match="LLVM"):
        choose_variant("llvm")


def test_llvm_is_looked_for_below_the_interpreter_s_prefix(tmp_path, monkeypatch) -> None:
    library = tmp_path / "lib" / "libLLVM.so.23.1"
    library.parent.mkdir()
    library.touch()
    for name in ("prefix", "base_prefix", "exec_prefix"):
        monkeypatch.setattr(f"sys.{name}", str(tmp_path))
    assert find_llvm() == library


def test_film_without_pyav_says_how_to_get_it(tmp_path, monkeypatch) -> None:
    from vulnus.visualization.film import write_film

    real = builtins.__import__

    def refuse(name, *rest):
        if name == "av":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(RenderError, match=r"vulnus\[render\]"):
        write_film(tmp_path / "film.mp4", [np.zeros((8, 8, 3), np.uint8)], 24.0)


def test_the_tissue_s_surface_shows_skin_outside_and_flesh_in_the_hole(view) -> None:
    colour = view.tissue.vertex_data["colour"]
    assert colour.shape == view.tissue.vertices.shape
    place = view.tissue.vertices - np.array([0.012, 0.0, 0.08])
    in_hole = np.hypot(place[:, 0], place[:, 2]) < 0.006
    in_hole &= np.abs(place[:, 1]) < 0.012
    far = np.abs(place[:, 2]) > 0.04
    outside = far & (np.hypot(view.tissue.vertices[:, 0], view.tissue.vertices[:, 1]) > 0.028)
    assert in_hole.any()
    # Muscle and stain reflect a tenth of green that skin does.
    assert np.median(colour[in_hole, 1]) < 0.5 * np.median(colour[outside, 1])
    assert view.is_outside(np.array([[0.012, 0.0, 0.08]]))[0]
    assert not view.is_outside(np.array([[0.0, 0.0, 0.02]]))[0]


def test_platform_lies_below_the_lowest_point_across_gravity(wound) -> None:
    lying = Surroundings(gravity=(0.0, 9.8, 0.0), platform_gap=5e-3)
    seen = view_limb(wound, lying)
    assert not seen.is_upright
    platform = seen.studio.platform
    assert platform is not None
    lowest = wound.reference_position[:, 1].max()
    assert np.isclose(platform.point[1], lowest + 5e-3, atol=1e-6)  # float32 positions
    assert np.allclose(platform.normal, (0.0, -1.0, 0.0))


def test_arteries_are_closed_tubes_with_a_gap_where_they_are_cut(wound) -> None:
    surface = artery_tubes(wound.arteries, widen=1.0)
    gap = np.abs(surface.vertices[:, 2] - 0.08) < 0.004
    assert surface.triangles.shape[0] > 0
    assert not gap.any()
    whole = tube(np.array([[0.0, 0, 0], [0, 0, 0.1]]), np.array([0.01, 0.01]), sides=64)
    corners = whole.vertices[whole.triangles].astype(float)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    # A 64-gon holds 0.16 % less than its circle; positive means outward.
    assert np.isclose(volume, np.pi * 0.01**2 * 0.1, rtol=2e-3)


def test_frames_of_a_window_are_completed_by_the_resting_limb(wound, injury_frames) -> None:
    points, reference = points_in_passage(injury_frames[-1], wound)
    assert points.position.shape == wound.position.shape
    order = np.lexsort(reference.T.round(6))
    expected = np.lexsort(wound.reference_position.T.round(6))
    assert np.allclose(reference[order], wound.reference_position[expected], atol=1e-6)
    assert np.array_equal(points.tissue[order], wound.tissue[expected])
    assert np.count_nonzero(points.tissue == Tissue.BONE) == np.count_nonzero(
        wound.tissue == Tissue.BONE
    )
