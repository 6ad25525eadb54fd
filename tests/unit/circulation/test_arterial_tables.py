"""Reading, checking, repairing and naming the tables of segments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vulnus.circulation import CirculationParameters, build_tree
from vulnus.circulation.segments import (
    build_table,
    checksum_deviations,
    read_segments,
    stergiopulos91,
)
from vulnus.core.errors import CirculationError

MMHG_S_PER_ML = 133.322387415e6


def test_tree_of_the_paper_has_91_segments_and_28_ends():
    table = stergiopulos91()
    assert len(table.ids) == 91
    assert np.count_nonzero(np.isfinite(table.terminal_resistance)) == 28
    assert np.sum(table.length) == pytest.approx(7.21, abs=0.01)  # CIRCULATION.md 1.3
    volume = np.sum(np.pi * table.radius**2 * table.length)
    assert volume == pytest.approx(215e-6, rel=0.01)


def test_terminals_together_give_the_normal_peripheral_resistance():
    total = 1.0 / np.sum(1.0 / stergiopulos91().terminal_resistance)
    assert total == pytest.approx(1.007 * MMHG_S_PER_ML, rel=1e-3)  # CIRCULATION.md 1.4


def test_intercostals_leave_the_thoracic_aorta():
    table = stergiopulos91()
    parent = table.parent_row[table.row(table.id_of["intercostals"])]
    assert table.names[parent] == "thoracic aorta 1"


def test_names_are_unique_and_tell_the_side():
    table = stergiopulos91()
    assert len(set(table.names)) == 91
    for name, identity in (
        ("left anterior tibial 1", 81),
        ("left anterior tibial 2", 85),
        ("right anterior tibial 3", 90),
        ("left subclavian 1", 3),
        ("left common carotid 3", 15),
        ("right posterior tibial 2", 87),
    ):
        assert table.id_of[name] == identity


def test_left_and_right_limbs_mirror_each_other():
    table = stergiopulos91()
    for name in ("popliteal 1", "anterior tibial 2", "posterior tibial 1", "femoral 2"):
        left, right = (table.row(table.id_of[f"{side} {name}"]) for side in ("left", "right"))
        for column in ("length", "radius", "thickness", "youngs_modulus", "terminal_resistance"):
            assert getattr(table, column)[left] == getattr(table, column)[right]


def test_peroneal_branch_leaves_the_rest_of_the_tree_as_it_is():
    plain, with_branch = stergiopulos91(), stergiopulos91(peroneal=True)
    assert len(with_branch.ids) == 91 + 6  # a split posterior tibial and two segments, both sides
    for side in ("left", "right"):
        upper = with_branch.row(with_branch.id_of[f"{side} fibular 1"])
        lower = with_branch.row(with_branch.id_of[f"{side} fibular 2"])
        assert with_branch.length[upper] == with_branch.length[lower] == 0.159
        assert with_branch.thickness[lower] == 0.39e-3  # the table's 0.19 mm is a misprint
        assert np.isfinite(with_branch.terminal_resistance[lower])
    posterior = [name for name in with_branch.names if name.startswith("left posterior tibial")]
    whole = sum(with_branch.length[with_branch.row(with_branch.id_of[n])] for n in posterior)
    assert whole == pytest.approx(2 * 0.161)
    assert plain.radius.sum() < with_branch.radius.sum()


def test_checksum_finds_a_misprint(one_segment):
    sound = one_segment(
        1, 0, length=0.094, radius=2e-3, thickness=0.47e-3, quarter_wave_frequency=30.2
    )
    assert checksum_deviations([sound]) == []
    wrong = sound._replace(thickness=0.047e-3)
    assert "segment 1" in checksum_deviations([wrong])[0]
    assert checksum_deviations([wrong], skip=frozenset({1})) == []


def test_a_file_that_is_no_table_is_refused():
    with pytest.raises(CirculationError, match="not a table"):
        read_segments(Path(__file__), {})


@pytest.mark.filterwarnings("error")
def test_loading_the_paper_tree_warns_of_nothing():
    stergiopulos91.cache_clear()
    assert len(stergiopulos91().ids) == 91


@pytest.mark.parametrize(
    ("rows", "complaint"),
    [
        ([(1, 0), (2, 0)], "2 roots"),
        ([(1, 2), (2, 1)], "0 roots"),
        ([(1, 0), (2, 3), (3, 2)], "cycle"),
        ([(1, 0), (2, 7)], "unknown parent 7"),
        ([(1, 0), (1, 1)], "repeated"),
        ([], "0 roots"),
    ],
)
def test_a_table_that_is_no_tree_is_refused(one_segment, rows, complaint):
    segments = [one_segment(i, parent, resistance=1e9) for i, parent in rows]
    with pytest.raises(CirculationError, match=complaint):
        build_table(segments, subject="tree of a test")


@pytest.mark.parametrize("name", ["length", "radius", "thickness", "youngs_modulus"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_values_that_are_not_positive_are_refused(one_segment, name, value):
    wrong = one_segment(1, 0, resistance=1e9)._replace(**{name: value})
    with pytest.raises(CirculationError, match=name):
        build_table([wrong], subject="tree of a test")


def test_an_end_without_resistance_is_refused(one_segment):
    with pytest.raises(CirculationError, match="terminal resistance"):
        build_table([one_segment(1, 0)], subject="tree of a test")


def test_missing_table_is_refused(tmp_path):
    with pytest.raises(CirculationError, match=r"absent\.csv"):
        read_segments(tmp_path / "absent.csv", {})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("harmonics", 0),
        ("density", -1060.0),
        ("viscosity", 0.0),
        ("poisson_ratio", 0.6),
        ("wall_phase", 2.0),
        ("venous_pressure", float("nan")),
        ("terminal_compliance", -1.0),
        ("heart_rate", 0.0),
        ("aortic_mean_pressure", float("inf")),
        ("exit_loss_coefficient", -0.1),
        ("shunt_resistance", -1.0),
        ("tree", "oak"),
    ],
)
def test_unphysical_parameters_are_refused(name, value):
    with pytest.raises(CirculationError, match=name):
        build_tree(CirculationParameters(**{name: value}))


def test_unknown_segment_position_and_side_are_refused(tree):
    with pytest.raises(CirculationError, match="segment 92"):
        tree.pressure(92, 0.0)
    with pytest.raises(CirculationError, match="left anterior tibial 1"):
        tree.pressure(81, 0.026)
    with pytest.raises(CirculationError, match="side"):
        build_tree(CirculationParameters(), side="both")
