"""What a stage hands on comes back to the bit, and a damaged file is never taken for it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from reference.injury_outcomes import injury_outcome

from vulnus.core.handoff import (
    ArteryCentreline,
    InjuredLimb,
    LabelVolume,
    ShotLine,
    Tissue,
    TriangleSurface,
    VesselInjury,
)
from vulnus.storage.handoff_file import DamagedFileError, read_handoff, read_note, write_handoff

LEAVES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False)
    | st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))
    | st.sampled_from(Tissue)
)
TREES = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(
            st.text(st.characters(categories=["L", "P"]), max_size=8), inner, max_size=4
        )
    ),
    max_leaves=12,
)


def same(a: Any, b: Any) -> bool:
    """Equality to the bit, type included, through dataclasses, tuples and mappings."""
    if dataclasses.is_dataclass(a):
        return type(a) is type(b) and all(
            same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a)
        )
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return type(a) is type(b) and a == b


def injured_limb(count: int = 40) -> InjuredLimb:
    rng = np.random.default_rng(3)
    points = rng.random((count, 3), dtype=np.float32)
    skin = TriangleSurface(points, np.zeros((4, 3), np.int32), {"normal": points})
    cut = VesselInjury(
        artery="anterior_tibial",
        arc_length=0.1,
        arc_fraction=1 / 3,
        gap=9e-3,
        lumen_radius=1.5e-3,
        position=(0.1, 0.2, 0.3),
        position_proximal=(0.0, 0.0, 0.0),
        position_distal=(0.0, 0.0, 0.1),
        axis_proximal=(0.0, 0.0, -1.0),
        axis_distal=(0.0, 0.0, 1.0),
    )
    return InjuredLimb(
        position=points,
        reference_position=points,
        tissue=np.full(count, Tissue.MUSCLE, np.uint8),
        volume=points[:, 0].copy(),
        damage=points[:, 1].copy(),
        spacing=1.5e-3,
        arteries=(),
        injuries=(cut,),
        shot=ShotLine((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0), 9e-3, 350.0),
        entry_area=6.4e-5,
        exit_area=1.1e-4,
        time=1e-3,
        steps=200,
        particle_steps_per_second=1e7,
        surfaces={"skin": skin},
        side="left",
    )


@settings(derandomize=True, max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(content=TREES)
def test_any_tree_comes_back(tmp_path: Path, content: Any) -> None:
    write_handoff(tmp_path / "x.h5", content, {})
    assert same(read_handoff(tmp_path / "x.h5")[0], content)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int32, np.int64, np.uint8, np.bool_])
@pytest.mark.parametrize("shape", [(0, 3), (), (7,), (300, 300)])
def test_arrays_come_back_to_the_bit(tmp_path: Path, dtype: type, shape: tuple[int, ...]) -> None:
    array = np.asarray(np.random.default_rng(1).random(shape) * 200).astype(dtype)
    write_handoff(tmp_path / "x.h5", {"a": array}, {})
    assert same(read_handoff(tmp_path / "x.h5")[0], {"a": array})


def test_hand_off_types_come_back(tmp_path: Path) -> None:
    artery = ArteryCentreline("popliteal", np.eye(3), np.ones(3))
    labels = LabelVolume(
        np.arange(24, dtype=np.uint8).reshape(2, 3, 4),
        np.zeros(3),
        np.ones(3),
        np.eye(3),
        (artery, artery),
        "made up",
    )
    kinds = (labels, injured_limb(), injury_outcome(injured_limb()))
    for index, content in enumerate(kinds):
        path = tmp_path / f"{index}.h5"
        write_handoff(path, content, {"wall": 1.25})
        back, note = read_handoff(path)
        assert same(back, content)
        assert note == read_note(path) == {"wall": "1.25"}


def test_the_comparison_can_fail() -> None:
    limb = injured_limb()
    assert not same(limb, dataclasses.replace(limb, exit_area=limb.exit_area * (1 + 1e-15)))


def test_damage_anywhere_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "x.h5"
    write_handoff(path, injured_limb(), {})
    whole = path.read_bytes()
    for place in range(0, len(whole), len(whole) // 40):
        if 90 < place < 512:
            continue  # the empty rest of the header block means nothing
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(DamagedFileError):
            read_handoff(path)
    for length in (0, 100, 512, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(DamagedFileError):
            read_handoff(path)


def test_other_hdf5_tools_open_it(tmp_path: Path) -> None:
    import h5py

    write_handoff(tmp_path / "x.h5", {"a": np.arange(3)}, {})
    with h5py.File(tmp_path / "x.h5") as file:
        assert list(file["content/000000/array"]) == [0, 1, 2]


def test_what_cannot_be_kept_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="set"):
        write_handoff(tmp_path / "x.h5", {"a": {1, 2}}, {})


def test_what_two_states_share_is_written_once(tmp_path: Path) -> None:
    limb = injured_limb(20_000)
    moved = dataclasses.replace(limb, position=limb.position + np.float32(0.1))
    write_handoff(tmp_path / "one.h5", injury_outcome(limb), {})
    write_handoff(tmp_path / "two.h5", injury_outcome(limb, temporary=moved), {})
    one, two = ((tmp_path / name).stat().st_size for name in ("one.h5", "two.h5"))
    # 1 %: the headers of the groups of the second limb.
    assert two - one == pytest.approx(limb.position.nbytes, rel=0.01)
    back, _ = read_handoff(tmp_path / "two.h5")
    assert same(back.temporary, moved)
    assert same(back.permanent, limb)
