"""Places on the limb's arteries as segments and positions of the tree."""

from __future__ import annotations

import pytest

from vulnus.circulation import CirculationParameters, build_tree, open_injury_port
from vulnus.core.errors import CirculationError
from vulnus.core.handoff import VesselInjury


@pytest.mark.parametrize(
    ("artery", "fraction", "name", "position"),
    [
        ("anterior_tibial", 0.0, "left anterior tibial 1", 0.0),
        ("anterior_tibial", 0.0125 / 0.325, "left anterior tibial 1", 0.0125),
        ("anterior_tibial", 0.175 / 0.325, "left anterior tibial 2", 0.15),
        ("anterior_tibial", 1.0, "left anterior tibial 3", 0.15),
        ("posterior_tibial", 0.5, "left posterior tibial 1", 0.161),
        ("posterior_tibial", 0.75, "left posterior tibial 2", 0.0805),
        ("popliteal", 0.25, "left popliteal 1", 0.047),
    ],
)
def test_fraction_of_the_length_finds_the_segment(tree, artery, fraction, name, position):
    segment, place = tree.locate(artery, fraction)
    assert segment == tree.table.id_of[name]
    assert place == pytest.approx(position, abs=1e-12)


def test_fraction_counts_before_length_and_length_without_it(tree):
    assert tree.locate("popliteal", 0.25, 0.9) == tree.locate("popliteal", 0.25)
    assert tree.locate("popliteal", arc_length=0.047) == tree.locate("popliteal", 0.25)


def test_right_side_has_its_own_segments():
    right = build_tree(CirculationParameters(), side="right")
    segment, _ = right.locate("anterior_tibial", 0.5)
    assert right.table.names[right.table.row(segment)] == "right anterior tibial 2"


def test_fibular_exists_where_it_is_cut(tree):
    with pytest.raises(CirculationError, match="severed"):
        tree.locate("fibular", 0.5)
    cut = build_tree(CirculationParameters(), severed="fibular")
    segment, position = cut.locate("fibular", 0.75)
    assert cut.table.names[cut.table.row(segment)] == "left fibular 2"
    assert position == pytest.approx(0.5 * 0.159)


def test_posterior_tibial_is_the_same_artery_with_and_without_the_fibular():
    place = [
        build_tree(CirculationParameters(), severed=severed).locate("posterior_tibial", 0.75)
        for severed in (None, "fibular")
    ]
    assert place[0] == pytest.approx(place[1])


@pytest.mark.parametrize("artery", ["femoral", "aorta", "", "left anterior tibial 2"])
def test_unknown_artery_is_refused_with_the_known_ones(tree, artery):
    with pytest.raises(CirculationError, match="anterior_tibial, posterior_tibial"):
        tree.locate(artery, 0.5)


@pytest.mark.parametrize(("fraction", "length"), [(-0.1, None), (1.1, None), (None, 1.0)])
def test_places_beyond_the_artery_are_refused(tree, fraction, length):
    with pytest.raises(CirculationError, match="anterior_tibial"):
        tree.locate("anterior_tibial", fraction, length)


def test_a_place_must_be_given(tree):
    with pytest.raises(CirculationError, match="not given"):
        tree.locate("anterior_tibial")


@pytest.mark.parametrize("artery", ["anterior_tibial", "fibular"])
def test_injury_opens_its_port_with_its_own_lumen(artery):
    here, axis = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    injury = VesselInjury(
        artery=artery,
        arc_length=0.1,
        arc_fraction=0.4,
        gap=0.01,
        lumen_radius=1.2e-3,
        position=here,
        position_proximal=here,
        position_distal=here,
        axis_proximal=axis,
        axis_distal=axis,
    )
    port = open_injury_port(CirculationParameters(), injury)
    assert port.lumen_radius == 1.2e-3
    assert port.bleed(0.0).mean_flow > 0.0
