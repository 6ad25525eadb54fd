"""Centre-lines: names, units, order from proximal to distal, and errors that name the key."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vulnus.core.errors import InputFileError
from vulnus.imaging import ImagingParameters, load_labels
from vulnus.imaging.centrelines import artery_name

from . import volumes as v


def leg(folder: Path) -> Path:
    """A block of soft tissue 60 x 60 x 200 mm with bone and an artery voxel, corner at 0."""
    labels = np.full((30, 30, 100), 2, dtype=np.uint8)
    labels[10:14, 10:14] = 3
    labels[20, 20, 50] = 4
    return v.write_nrrd(
        folder / "leg.nrrd",
        labels,
        **{"space directions": 2.0 * np.eye(3), "space origin": np.ones(3)},
    )


def line(start, end, count=41) -> list[list[float]]:
    return np.linspace(start, end, count).tolist()


def segment(name, points, radius=1.5, **extra):
    return {"name": name, "points_mm": points, "radius_mm": [radius] * len(points), **extra}


TREE = [
    segment("popliteal artery", line([30, 40, 195], [30, 40, 140]), 2.5),
    segment("Left anterior tibial artery", line([30, 10, 20], [30, 38, 150])),
    segment("fibular artery (by position)", line([31, 40, 139], [45, 40, 10])),
]


def write(folder: Path, segments=TREE, name="artery_centrelines_lps_mm.json", **fields) -> Path:
    path = folder / name
    path.write_text(json.dumps({"space": "LPS", "units": "mm", "segments": segments} | fields))
    return path


def read(folder: Path, segments=TREE, **fields):
    path = write(folder, segments, **fields)
    volume = load_labels(ImagingParameters(source=leg(folder), centrelines=path))
    return {artery.name: artery for artery in volume.arteries}


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("anterior tibial artery", "anterior_tibial"),
        ("anterior_tibial_artery", "anterior_tibial"),
        ("Left Popliteal Artery", "popliteal"),
        ("fibular artery (by position)", "fibular"),
        ("peroneal artery", "fibular"),
        ("dorsalis pedis artery", "dorsalis_pedis"),
        ("PosteriorTibialArtery", "posterior_tibial"),
    ],
)
def test_names_become_snake_case_without_side(name, expected):
    assert artery_name(name) == expected


def test_arteries_run_from_proximal_to_distal(tmp_path):
    arteries = read(tmp_path)
    assert list(arteries) == ["popliteal", "anterior_tibial", "fibular"]
    for artery in arteries.values():
        assert artery.points[0, 2] > artery.points[-1, 2]
    # The anterior tibial artery came distal end first; its radii turn with its points.
    np.testing.assert_allclose(arteries["anterior_tibial"].points[0], [0.030, 0.038, 0.150])
    assert arteries["anterior_tibial"].parent == "popliteal"
    assert arteries["popliteal"].parent is None


def test_contact_with_the_parent_decides_before_height(tmp_path):
    rising = segment("recurrent artery", line([30, 37, 149], [30, 10, 190], 21), 0.8)
    artery = read(tmp_path, [*TREE, rising])["recurrent"]
    np.testing.assert_allclose(artery.points[0], [0.030, 0.037, 0.149])


def test_ras_and_metres_are_converted(tmp_path):
    flipped = [
        s
        | {"points_mm": (1e-3 * np.array(s["points_mm"]) * [-1, -1, 1]).tolist()}
        | {"radius_mm": [1e-3 * r for r in s["radius_mm"]]}
        for s in TREE
    ]
    arteries = read(tmp_path, flipped, space="RAS", units="m")
    for name, artery in read(tmp_path).items():
        np.testing.assert_allclose(arteries[name].points, artery.points, atol=1e-12)
        np.testing.assert_allclose(arteries[name].radius, artery.radius, rtol=1e-12)


def test_the_radius_that_was_voxelised_is_taken(tmp_path):
    drawn = [s | {"radius_drawn": [1.1] * len(s["points_mm"])} for s in TREE]
    arteries = read(tmp_path, drawn, voxelized_radius="radius_drawn")
    np.testing.assert_allclose(arteries["popliteal"].radius, 1.1e-3)


def test_lines_are_cut_at_the_volume(tmp_path):
    long = [TREE[0] | {"points_mm": line([30, 40, 395], [30, 40, 140])}]
    artery = read(tmp_path, long)["popliteal"]
    assert 0.19 < artery.points[0, 2] <= 0.2
    assert len(artery.points) == len(artery.radius) < 41


def test_an_artery_outside_the_volume_is_left_out_with_a_warning(tmp_path):
    plantar = segment("plantar artery", line([30, 40, -50], [30, 10, -60]))
    with pytest.warns(UserWarning, match="plantar"):
        assert "plantar" not in read(tmp_path, [*TREE, plantar])


def test_lines_in_another_frame_are_refused(tmp_path):
    with pytest.raises(InputFileError, match="none of its centre-lines lies"):
        read(tmp_path, space="RAS")


def test_lines_in_the_air_are_refused(tmp_path):
    labels = np.zeros((30, 30, 100), dtype=np.uint8)
    labels[:5, :5] = 3
    grid = {"space directions": 2.0 * np.eye(3), "space origin": np.ones(3)}
    path = v.write_nrrd(tmp_path / "leg.nrrd", labels, **grid)
    with pytest.raises(InputFileError, match="lie in the limb"):
        load_labels(ImagingParameters(source=path, centrelines=write(tmp_path)))


def test_the_file_beside_the_volume_is_found(tmp_path):
    write(tmp_path)
    assert len(load_labels(ImagingParameters(source=leg(tmp_path))).arteries) == 3
    write(tmp_path, name="artery_centrelines_old.json")
    with pytest.raises(InputFileError, match="several centre-line files"):
        load_labels(ImagingParameters(source=leg(tmp_path)))


def test_a_volume_with_arteries_but_no_lines_warns(tmp_path):
    with pytest.warns(UserWarning, match="no artery can be cut"):
        assert load_labels(ImagingParameters(source=leg(tmp_path))).arteries == ()


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"name": None}, "segments[0].name"),
        ({"points_mm": None}, "segments[0].points_mm"),
        ({"points_mm": [[0, 0, 0]]}, "segments[0].points_mm"),
        ({"points_mm": [[0, 0], [1, 1]]}, "segments[0].points_mm"),
        ({"points_mm": [[0, 0, 0], [1, 1]]}, "segments[0].points_mm"),
        ({"points_mm": [[0, 0, 0], [0, 0, float("nan")]]}, "segments[0].points_mm"),
        ({"points_mm": [[0, 0, 0], [0, 0, 0]], "radius_mm": [1, 1]}, "segments[0].points_mm"),
        ({"radius_mm": [1.0]}, "segments[0].radius_mm"),
        ({"radius_mm": [-1.0] * 41}, "segments[0].radius_mm"),
        ({"radius_mm": "wide"}, "segments[0].radius_mm"),
        ({"parent": 3}, "segments[0].parent"),
    ],
)
def test_errors_name_the_key(tmp_path, change, key):
    with pytest.raises(InputFileError) as caught:
        read(tmp_path, [TREE[0] | change, *TREE[1:]])
    assert key in caught.value.subject
    assert "artery_centrelines" in caught.value.subject


@pytest.mark.parametrize(
    ("fields", "key"),
    [
        ({"space": "RSA"}, "space"),
        ({"units": "inch"}, "units"),
        ({"segments": []}, "segments"),
        ({"segments": [TREE[0], TREE[0]]}, "segments[1].name"),
        ({"segments": ["popliteal"]}, "segments[0]"),
    ],
)
def test_errors_of_the_file_name_the_key(tmp_path, fields, key):
    segments = fields.pop("segments", TREE)
    with pytest.raises(InputFileError) as caught:
        read(tmp_path, segments, **fields)
    assert caught.value.subject.endswith(key)


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"segments": [}', "\xff\xfe"])
def test_broken_json_is_refused(tmp_path, text):
    path = tmp_path / "lines.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputFileError, match=r"lines\.json"):
        load_labels(ImagingParameters(source=leg(tmp_path), centrelines=path))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputFileError, match="no such file"):
        load_labels(ImagingParameters(source=leg(tmp_path), centrelines=tmp_path / "no.json"))
