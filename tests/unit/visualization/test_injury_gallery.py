"""The gallery's pictures: balls where points are, instants that tell the story, whole sheets."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from vulnus.core.handoff import (
    BoneReport,
    InjuryOutcome,
    ParticleFrame,
    ShotLine,
    Tissue,
    TriangleSurface,
)
from vulnus.visualization import InjuryToDraw, VisualizationParameters, draw_injury_gallery
from vulnus.visualization.camera import frame_points
from vulnus.visualization.impact_view import ShotScene, instants
from vulnus.visualization.particle_balls import ball_surface, seen_from
from vulnus.visualization.projectile_view import projectiles_in
from vulnus.visualization.sheet import LegendEntry, compose, write_jpeg
from vulnus.visualization.surface import TissuePoints
from vulnus.visualization.wound_figures import wound_caption, wound_figure

SHOT = ShotLine((0.0, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 1.0, 0.0), 0.01, 100.0)


def points_of(position: np.ndarray, tissue: Tissue = Tissue.MUSCLE) -> TissuePoints:
    count = len(position)
    return TissuePoints(
        position.astype(np.float32),
        np.full(count, tissue, np.uint8),
        np.zeros(count, np.float32),
        1e-3,
    )


@pytest.mark.parametrize("round_balls", [True, False])
def test_each_ball_is_a_closed_sphere_around_its_point(*, round_balls: bool) -> None:
    place = np.array([[0.0, 0.0, 0.0], [0.1, 0.2, 0.3]])
    surface = ball_surface(points_of(place), round_balls=round_balls)
    assert len(surface.triangles) == 2 * (80 if round_balls else 20)
    corners = surface.vertices.reshape(2, -1, 3)
    radius = np.linalg.norm(corners - place[:, None], axis=2)
    assert np.allclose(radius, 0.62e-3, rtol=1e-4)
    assert np.allclose(corners.mean(axis=1), place, atol=1e-7)
    edges = np.sort(surface.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert np.all(uses == 2)  # closed
    side = surface.vertices[surface.triangles].astype(np.float64)
    outward = np.cross(side[:, 1] - side[:, 0], side[:, 2] - side[:, 0])
    middle = np.repeat(place, len(side) // 2, axis=0)
    assert np.all(np.einsum("tc,tc->t", outward, side.mean(axis=1) - middle) > 0.0)


def test_the_foremost_points_are_kept_and_those_far_behind_them_left_out() -> None:
    cells = 1e-3 * np.stack(np.meshgrid(*[np.arange(40)] * 3, indexing="ij"), -1).reshape(-1, 3)
    camera = frame_points(
        cells, toward_camera=(0.0, 0.0, 1.0), up=(0.0, 1.0, 0.0), width=300, height=300
    )
    seen = seen_from(points_of(cells), camera)
    depth = cells[:, 2]
    inner = np.all((cells[:, :2] > 8e-3) & (cells[:, :2] < 31e-3), axis=1)
    assert np.all(seen[depth > 0.030])
    assert not np.any(seen[inner & (depth < 0.020)])
    behind = points_of(cells + [0.0, 0.0, 10.0])  # behind the camera
    assert not np.any(seen_from(behind, camera))
    assert len(seen_from(points_of(np.zeros((0, 3))), camera)) == 0


def test_debris_does_not_hide_the_tissue_behind_it() -> None:
    flat = 1e-3 * np.stack(np.meshgrid(*[np.arange(40)] * 2, indexing="ij"), -1).reshape(-1, 2)
    wall = np.column_stack([flat, np.zeros(len(flat))])
    debris = np.column_stack([flat, np.full(len(flat), 0.03)])
    both = points_of(np.concatenate([wall, debris]))
    camera = frame_points(
        both.position, toward_camera=(0.0, 0.0, 1.0), up=(0.0, 1.0, 0.0), width=300, height=300
    )
    assert np.all(seen_from(both, camera))


def test_the_wall_of_a_wide_tract_is_kept_where_perspective_shows_it() -> None:
    cells = 1e-3 * np.stack(np.meshgrid(*[np.arange(40)] * 3, indexing="ij"), -1).reshape(-1, 3)
    beside = np.linalg.norm(cells[:, :2] - 0.0195, axis=1)
    radius = np.where(cells[:, 2] > 0.030, 8e-3, 12e-3)  # wider inside than at its mouth
    cells, beside, radius = (one[beside > radius] for one in (cells, beside, radius))
    camera = frame_points(
        cells,
        toward_camera=(0.0, 0.0, 1.0),
        up=(0.0, 1.0, 0.0),
        width=300,
        height=300,
        field_of_view=np.deg2rad(60.0),
    )
    seen = seen_from(points_of(cells), camera)
    mouth = camera.project(np.array([[0.0195, 0.0195, 0.039], [0.0275, 0.0195, 0.039]]))
    off = np.linalg.norm(camera.project(cells) - mouth[0], axis=1)
    visible = (off < 0.9 * np.ptp(mouth[:, 0])) & (beside < radius + 1e-3)
    assert np.count_nonzero(visible & (cells[:, 2] < 0.02)) > 100
    assert np.all(seen[visible])


def test_instants_are_before_inside_at_the_exit_at_the_largest_cavity_and_the_end() -> None:
    times = (np.arange(101) * 1e-4).tolist()  # the ball is out after 1.1 ms
    assert instants(times, SHOT, turning=4e-3) == [0, 5, 11, 40, 100]
    assert instants(times, SHOT, turning=10e-3) == [0, 5, 11, 55, 100]  # 55.5 of 100
    assert instants(times[:3], SHOT, turning=2e-4) == [0, 2]  # a run that ends early


def test_cameras_look_along_and_across_the_flight_with_proximal_up(wound) -> None:
    scene = ShotScene.of(wound)
    side = scene.side_camera(620, 280)
    entry, exit_ = side.project(np.array([wound.shot.entry_point, wound.shot.exit_point]))
    assert entry[0] < exit_[0]  # the flight goes to the right
    assert entry[0] > 0.0
    assert exit_[0] < 620
    above = side.project(np.array([wound.shot.entry_point]) + [0.0, 0.0, 0.01])
    assert above[0, 1] < entry[1]
    back = scene.back_camera(400, 280, 0.04)
    assert np.allclose(back.axes[2], scene.flight, atol=1e-12)
    assert np.allclose(back.project(np.array([wound.shot.exit_point])), [[200.0, 140.0]])


def test_a_sheet_holds_every_panel_and_its_words() -> None:
    red = np.zeros((50, 300, 3), np.uint8)
    red[...] = (200, 10, 10)
    blue = np.zeros((50, 200, 3), np.uint8)
    blue[...] = (10, 10, 200)
    legend = [LegendEntry((0.0, 0.5, 0.0), "grass")]
    wide = np.broadcast_to(blue[:, :1], red.shape)
    sheet = compose([[red, blue], [wide, blue]], titles=("a", "b"), legend=legend)
    assert np.count_nonzero(np.all(sheet == (200, 10, 10), axis=2)) == 50 * 300
    assert np.count_nonzero(np.all(sheet == (10, 10, 200), axis=2)) == 50 * (200 + 500)
    assert np.any(np.all(sheet == (0, 188, 0), axis=2))
    assert np.all(sheet[0] == 255)


def test_a_jpeg_for_a_page_stays_below_300_kilobytes(tmp_path) -> None:
    rng = np.random.default_rng(1)
    coarse = rng.integers(0, 256, (300, 200, 3), dtype=np.uint8)
    picture = coarse.repeat(4, 0).repeat(4, 1)
    path = write_jpeg(tmp_path / "deep" / "noise.jpg", picture)
    data = path.read_bytes()
    assert len(data) <= 300_000
    assert Image.open(io.BytesIO(data)).size == (800, 1200)
    plain = io.BytesIO()
    Image.fromarray(picture).save(plain, format="JPEG", quality=92)
    assert len(plain.getvalue()) > 300_000  # at full quality it would not fit


@pytest.mark.slow
def test_the_gallery_is_drawn(wound, wound_report, injury_frames, tmp_path) -> None:
    outcome = InjuryOutcome({"temporary": wound, "permanent": wound}, "permanent", wound_report)
    shown = InjuryToDraw(
        outcome=outcome,
        frames=injury_frames,
        times=[frame.time for frame in injury_frames],
    )
    files = draw_injury_gallery(
        shown,
        VisualizationParameters(samples=1, denoise=False),
        directory=tmp_path,
        name="rod",
    )
    assert [path.name for path in files] == ["report_rod.png", "passage_rod.jpg", "wound_rod.jpg"]
    for path in files[1:]:
        pixels = np.asarray(Image.open(path))
        assert pixels.std() > 20  # not blank
        assert np.mean(pixels.max(axis=2) < 8) < 0.02  # no black areas


def test_projectiles_are_where_the_frame_says() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    nail = TriangleSurface(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
    frame = ParticleFrame(
        0,
        1e-3,
        np.zeros((0, 3), np.float32),
        {},
        {
            "projectile_position_m": np.array([[1.0, 2.0, 3.0]]),
            "projectile_rotation": turn.reshape(1, 9),
        },
    )
    (placed,) = projectiles_in(frame, SHOT, [nail])
    assert np.allclose(placed.vertices, turn.T + [1.0, 2.0, 3.0])
    silent = ParticleFrame(0, 1e-3, np.zeros((0, 3), np.float32), {})
    (ball,) = projectiles_in(silent, SHOT, [nail])  # the paper's: at constant speed
    middle = 0.5 * (ball.vertices.min(axis=0) + ball.vertices.max(axis=0))
    assert np.allclose(middle, [0.0, 100.0 * 1e-3 - 0.005, 0.0], atol=1e-4)


def test_the_wound_figure_shows_the_report_s_numbers(wound_report) -> None:
    figure = wound_figure(wound_report)
    cavity, energy, tract = figure.axes
    assert np.allclose(cavity.lines[0].get_ydata(), wound_report.cavity.volume * 1e6)
    steps = energy.patches[0].get_data()
    deposit = wound_report.projectiles[0].energy
    share = np.diff(steps.edges) / 10.0 @ steps.values  # mm of J/cm
    assert np.isclose(share, deposit.total)
    assert [line.get_label() for line in tract.lines] == ["temporary", "permanent"]
    text = wound_caption(wound_report)
    for part in (
        "360 → 210 m/s",
        "left the limb",
        "100 J left on 60 mm",
        "cavity 50 ml at 3.0 ms",
        "5 ml at the end",
        "posterior tibial artery transected",
        "2 fragments",
    ):
        assert part in text, text
    quiet = replace(wound_report, vessels=(), bone=BoneReport(0.1, 0.0, ()))
    assert "no artery torn" in wound_caption(quiet)
    assert "bone" not in wound_caption(quiet)
