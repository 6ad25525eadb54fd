"""Severed arteries against the reference values of CIRCULATION.md 5.2 and 5.3.

Those were computed for the branch beside the intact vessel (mode "shunt", 1e7 Pa s/m³), without
venous pressure, with 135/74/99.7 mmHg in the aorta. The shape of that signal is not published;
here the aortic signal is scaled to its mean and pulse pressure, to which mean flows hardly react.
"""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.circulation import CirculationParameters, build_tree
from vulnus.core.units import MILLILITRE_PER_MINUTE, MILLIMETRE_OF_MERCURY

pytestmark = pytest.mark.physics

REFERENCE = {  # segment, position [m]: Z(0) [Pa s/m³], flows [ml/min] linear, K = 1.5, K = 2.5
    ("left anterior tibial 1", 0.025): (2.9e8, 2405, 961, 788),
    ("left anterior tibial 2", 0.150): (1.47e9, 410, 316, 284),
    ("left posterior tibial 1", 0.160): (3.5e8, 1996, 1344, 1171),
    ("left popliteal 2", 0.094): (2.1e8, 3361, 1928, 1638),
    ("left femoral 1", 0.127): (6.4e7, 10440, 3544, 2875),
}
RESISTANCE_TOLERANCE = 0.015  # the values are given to two or three digits
FLOW_TOLERANCE = 0.005  # the unknown shape of the pulse enters the mean through Q|Q| only


@pytest.fixture(scope="module")
def reference_tree():
    return build_tree(
        CirculationParameters(
            injury_mode="shunt",
            venous_pressure=0.0,
            aortic_mean_pressure=99.7 * MILLIMETRE_OF_MERCURY,
            aortic_pulse_pressure=(135.0 - 74.0) * MILLIMETRE_OF_MERCURY,
        )
    )


@pytest.mark.parametrize("place", REFERENCE, ids=lambda place: place[0])
def test_bleeding_rates(reference_tree, place):
    name, position = place
    resistance, *flows = REFERENCE[place]
    segment = reference_tree.table.id_of[name]
    for loss, expected in zip((0.0, 1.5, 2.5), flows, strict=True):
        port = reference_tree.injury_port(segment, position, exit_loss_coefficient=loss)
        assert port.impedance[0].real == pytest.approx(resistance, rel=RESISTANCE_TOLERANCE)
        flow = port.bleed(0.0).mean_flow / MILLILITRE_PER_MINUTE
        assert flow == pytest.approx(expected, rel=FLOW_TOLERANCE)


def test_jet_speed_of_the_tibial_mid_shank(reference_tree):
    port = reference_tree.injury_port(reference_tree.table.id_of["left anterior tibial 2"], 0.15)
    speed = port.bleed(0.0).mean_flow / (np.pi * port.lumen_radius**2)
    assert speed == pytest.approx(1.7, abs=0.05)  # m/s, CIRCULATION.md 5.3


def test_default_bleeding_is_clinically_plausible():
    """PHYSICS.md 6: 70-400 ml/min at the start; more than 700 is not plausible."""
    tree = build_tree(CirculationParameters())
    for fraction in (0.4, 0.6, 0.8):
        port = tree.injury_port(*tree.locate("anterior_tibial", fraction))
        beat = port.bleed(0.0)
        peak = np.max(beat.flow_injury) / MILLILITRE_PER_MINUTE
        assert 70.0 <= beat.mean_flow / MILLILITRE_PER_MINUTE <= 400.0
        assert peak <= 700.0


def test_a_transected_artery_bleeds_a_little_more_than_a_shunted_one():
    """The cut end no longer feeds the foot; the branch beside it does."""
    rates = []
    for mode in ("shunt", "transection"):
        tree = build_tree(CirculationParameters(injury_mode=mode))
        port = tree.injury_port(*tree.locate("anterior_tibial", 0.5))
        rates.append(port.bleed(0.0).mean_flow)
    assert 1.0 < rates[1] / rates[0] < 1.1
