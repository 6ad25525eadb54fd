"""From labels to material points: tissues, volumes, cut ends, surfaces, placement."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vulnus.anatomy import AnatomyParameters, build_limb, compare_volumes
from vulnus.core.handoff import Tissue
from vulnus.geometry import surface_volume

from .conftest import (
    ARTERY_RADIUS,
    BONE_RADIUS,
    LENGTH,
    MARROW_RADIUS,
    RADIUS,
    SKIN,
    rotation,
)

COARSE = AnatomyParameters(particle_spacing=1.5e-3, skin_thickness=SKIN)
BALL = np.pi * LENGTH


@pytest.fixture(scope="module")
def labels(make_limb):
    return make_limb(fat=True)


@pytest.fixture(scope="module")
def limb(labels):
    return build_limb(labels, COARSE)


def part(limb, *tissues):
    return float(limb.volume[np.isin(limb.tissue, tissues)].astype(float).sum())


def test_volumes_of_all_tissues_are_those_of_the_shapes(limb):
    bone, marrow, artery = BONE_RADIUS**2, MARROW_RADIUS**2, ARTERY_RADIUS**2
    exact = {
        Tissue.SKIN: RADIUS**2 - (RADIUS - SKIN) ** 2,
        Tissue.FAT: (RADIUS - SKIN) ** 2 - (RADIUS - SKIN - 4e-3) ** 2,
        Tissue.MUSCLE: (RADIUS - SKIN - 4e-3) ** 2 - bone - artery,
        Tissue.BONE: bone - marrow,
        Tissue.MARROW: marrow,
        Tissue.ARTERY: artery,
    }
    # Voxels count the circle 0.3 % short, smoothing takes as much.
    assert part(limb, *exact) == pytest.approx(BALL * RADIUS**2, rel=1e-2)
    for tissue, square in exact.items():
        # Labels of 1 mm count these circles to a few percent; thin parts do no worse here. The
        # marrow's border is that of its voxels.
        assert part(limb, tissue) == pytest.approx(BALL * square, rel=0.05), tissue.name


def test_volumes_of_points_sum_to_the_closed_surface(limb):
    assert limb.volume.astype(float).sum() == pytest.approx(
        surface_volume(limb.surfaces["skin"]), rel=5e-3
    )
    assert limb.volume.min() > 0.0


def test_one_poisson_set_over_all_tissues(limb):
    points = limb.position.astype(float)
    assert cKDTree(points).query(points, k=2)[0][:, 1].min() >= limb.spacing
    assert 0.70 < len(points) * limb.spacing**3 / limb.volume.sum() < 0.76


def test_skin_is_a_shell_of_its_thickness_and_absent_at_the_cut_ends(limb, labels):
    middle = labels.origin + labels.spacing * (np.array(labels.labels.shape) - 1) / 2
    local = limb.position - middle
    depth = RADIUS - np.hypot(local[:, 0], local[:, 1])
    skin = limb.tissue == Tissue.SKIN
    # The border is sharp to a fraction of the label's voxel (1 mm).
    assert depth[skin].max() < SKIN + 0.5e-3
    assert depth[~skin].min() > SKIN - 0.5e-3
    end = np.abs(np.abs(local[:, 2]) - LENGTH / 2) < 1.5e-3
    assert end.sum() > 500
    assert (limb.tissue[end & (depth > SKIN + 0.5e-3)] != Tissue.SKIN).all()


def test_limb_ends_at_the_border_of_the_image(limb, labels):
    low = labels.origin[2] - 0.5e-3
    high = low + LENGTH
    vertices = limb.surfaces["skin"].vertices
    for z, edge in ((vertices[:, 2].min(), low), (vertices[:, 2].max(), high)):
        assert z == pytest.approx(edge, abs=1e-5)
    assert limb.position[:, 2].min() >= low
    assert limb.position[:, 2].max() <= high


def test_a_thin_artery_survives_as_a_tube(limb, labels):
    axis = labels.arteries[0].points
    in_artery = limb.position[limb.tissue == Tissue.ARTERY].astype(float)
    away = cKDTree(axis).query(in_artery)[0]
    assert len(in_artery) > 0.5 * np.pi * ARTERY_RADIUS**2 * LENGTH / limb.spacing**3
    assert away.max() < np.hypot(ARTERY_RADIUS, 1e-3) + 0.1e-3  # axis points every 2 mm
    along = np.sort(in_artery[:, 2])
    assert np.diff(along).max() < 8e-3  # no long stretch without a point


def test_surfaces_are_named_closed_and_of_the_right_size(limb):
    assert set(limb.surfaces) == {"skin", "bone", "muscle", "anterior_tibial"}
    exact = {
        "skin": RADIUS,
        "muscle": RADIUS - SKIN - 4e-3,
        "bone": BONE_RADIUS,
        "anterior_tibial": ARTERY_RADIUS,
    }
    for name, radius in exact.items():
        # Chords of the mesh cut a tube of three voxels' radius by 3 %.
        assert surface_volume(limb.surfaces[name]) == pytest.approx(BALL * radius**2, rel=0.06)


@pytest.mark.parametrize("spacing", [(1e-3, 1e-3, 1e-3), (0.8e-3, 1.2e-3, 2.1e-3)])
def test_a_rotated_grid_gives_the_rotated_limb(make_limb, spacing):
    turn, origin = rotation([1, 2, 3], 0.8), np.array([0.3, -0.2, 0.9])
    straight = build_limb(make_limb(spacing), COARSE)
    turned = build_limb(make_limb(spacing, turn, origin), COARSE)
    back = (turned.position.astype(float) - origin) @ turn
    for tissue in (Tissue.SKIN, Tissue.MUSCLE, Tissue.BONE, Tissue.ARTERY):
        a, b = straight.position[straight.tissue == tissue], back[turned.tissue == tissue]
        # Points differ by chance; their outer bounds agree within a spacing.
        np.testing.assert_allclose(a.min(axis=0), b.min(axis=0), atol=limb_tolerance(tissue))
        np.testing.assert_allclose(a.max(axis=0), b.max(axis=0), atol=limb_tolerance(tissue))
        assert part(straight, tissue) == pytest.approx(part(turned, tissue), rel=0.04)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def limb_tolerance(tissue):
    return 4e-3 if tissue == Tissue.ARTERY else 1.2e-3  # one point in 1.5 mm along the artery


def test_a_mirrored_limb_stays_mirrored(make_limb):
    """Left and right are told apart: the artery lies on the side where the labels have it."""
    limb = build_limb(make_limb(), COARSE)
    artery = limb.position[limb.tissue == Tissue.ARTERY].mean(axis=0)
    bone = limb.position[limb.tissue == Tissue.BONE].mean(axis=0)
    assert artery[0] < bone[0] - 10e-3
    assert artery[1] < bone[1] - 6e-3


def test_seed_decides_and_repeats_to_the_bit(labels, limb):
    again = build_limb(labels, COARSE)
    other = build_limb(
        labels, AnatomyParameters(particle_spacing=1.5e-3, skin_thickness=SKIN, seed=2)
    )
    assert again.position.tobytes() == limb.position.tobytes()
    assert again.tissue.tobytes() == limb.tissue.tobytes()
    assert again.volume.tobytes() == limb.volume.tobytes()
    assert again.position.tobytes() != other.position.tobytes()


def test_two_resolutions_agree(labels, limb):
    fine = build_limb(labels, AnatomyParameters(particle_spacing=1e-3, skin_thickness=SKIN))
    for tissue in (Tissue.SKIN, Tissue.FAT, Tissue.MUSCLE, Tissue.BONE, Tissue.MARROW):
        assert part(fine, tissue) == pytest.approx(part(limb, tissue), rel=0.03)
    expected = len(limb.position) * 1.5**3
    assert len(fine.position) == pytest.approx(expected, rel=0.03)  # less crowding at the skin


def test_without_a_skin_label_the_shell_is_made(make_limb, caplog):
    labels = make_limb()
    bare = np.where(labels.labels == Tissue.SKIN, Tissue.MUSCLE, labels.labels).astype(np.uint8)
    limb = build_limb(
        type(labels)(
            bare,
            *[
                getattr(labels, n)
                for n in ("origin", "spacing", "direction", "arteries", "source", "side")
            ],
        ),
        COARSE,
    )
    exact = BALL * (RADIUS**2 - (RADIUS - SKIN) ** 2)
    assert part(limb, Tissue.SKIN) == pytest.approx(exact, rel=0.05)
    assert "no skin label" in caplog.text


def test_a_closed_foot_end_has_skin_all_over(make_limb):
    """Padded by air the limb is not cut: its flat ends are skin too."""
    labels = make_limb()
    room = np.pad(labels.labels, ((0, 0), (0, 0), (4, 4)))
    closed = type(labels)(
        room,
        labels.origin - [0, 0, 4e-3],
        labels.spacing,
        labels.direction,
        labels.arteries,
        labels.source,
        labels.side,
    )
    limb = build_limb(closed, COARSE)
    z = limb.position[:, 2]
    assert (limb.tissue[z > z.max() - 1e-3] == Tissue.SKIN).mean() > 0.8  # the rest: bone, artery


def test_comparison_of_volumes_tells_each_tissue(labels, limb):
    changes = {c.tissue: c for c in compare_volumes(labels, limb)}
    assert set(changes) == set(Tissue) - {Tissue.AIR, Tissue.CANCELLOUS}
    assert changes[Tissue.BONE].in_labels == (labels.labels == Tissue.BONE).sum() * 1e-9
    assert abs(changes[Tissue.MUSCLE].change_fraction) < 0.02


def test_progress_is_told(labels):
    class Told:
        notes: list[float]

        def begin(self, _stage, total, _unit):
            self.notes = [total]

        def update(self, completed, _note=""):
            self.notes.append(completed)

        def end(self):
            self.notes.append(100.0)

    told = Told()
    build_limb(labels, COARSE, told)
    assert told.notes[0] == 100.0
    assert told.notes[1:] == sorted(told.notes[1:])
