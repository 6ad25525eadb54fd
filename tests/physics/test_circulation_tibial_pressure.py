"""The pulse on its way to the uninjured and to the severed anterior tibial artery (Fig. 4)."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.circulation import CirculationParameters, build_tree, summarise_cycle
from vulnus.circulation.womersley import poiseuille_resistance, wave_speed
from vulnus.core.units import MILLIMETRE_OF_MERCURY

pytestmark = pytest.mark.physics

LEG = (
    "left common iliac",
    "left external iliac 1",
    "left external iliac 2",
    "left femoral 1",
    "left femoral 2",
    "left popliteal 1",
    "left popliteal 2",
    "left anterior tibial 1",
)
AORTA = (
    "ascending aorta",
    "aortic arch 1",
    "aortic arch 2",
    "thoracic aorta 1",
    "thoracic aorta 2",
    "thoracic aorta 3",
    "abdominal aorta 1",
    "abdominal aorta 2",
    "abdominal aorta 3",
)


@pytest.fixture(scope="module")
def tree():
    return build_tree(CirculationParameters())


def summary(tree, name, position=0.0):
    return tree.pressure_summary(tree.table.id_of[name], position)


def foot_time(time, pressure):
    """When the tangent of the steepest rise meets the diastolic pressure [s], around the cycle."""
    start = int(np.argmin(pressure))
    shifted = np.roll(pressure, -start)
    steepest = int(np.argmax(np.diff(shifted)))
    slope = (shifted[steepest + 1] - shifted[steepest]) / (time[1] - time[0])
    delay = steepest * (time[1] - time[0]) - (shifted[steepest] - shifted.min()) / slope
    return time[start] + delay


def test_root_carries_the_measured_signal(tree):
    aorta = summarise_cycle(tree.time, tree.pressure_aorta())
    assert aorta.mean == pytest.approx(90.2 * MILLIMETRE_OF_MERCURY, rel=1e-3)
    assert aorta.systolic == pytest.approx(112.0 * MILLIMETRE_OF_MERCURY, rel=5e-3)
    assert aorta.diastolic == pytest.approx(65.1 * MILLIMETRE_OF_MERCURY, rel=5e-3)


def test_mean_pressure_falls_slowly_down_to_the_knee(tree):
    """Conduit arteries cost the mean a few mmHg; resistance sits behind the ends."""
    means = [summary(tree, name).mean for name in AORTA + LEG]
    assert np.all(np.diff(means) < 0.0)
    assert 2.0 < (means[0] - means[-1]) / MILLIMETRE_OF_MERCURY < 10.0


def test_mean_pressure_drop_along_the_tibial_is_poiseuilles(tree):
    segment = tree.table.id_of["left anterior tibial 2"]
    drop = summary(tree, "left anterior tibial 2").mean
    drop -= summary(tree, "left anterior tibial 2", 0.15).mean
    tube = poiseuille_resistance(np.array(0.15), np.array(1e-3), 4e-3)
    assert drop == pytest.approx(float(tube) * tree.mean_flow(segment), rel=1e-9)


def test_pulse_is_amplified_towards_the_knee_and_damped_in_the_shank(tree):
    """Ankle over aortic pulse pressure is 1.1-1.3 in adults; narrow tubes damp it again."""
    aorta, knee = summary(tree, "ascending aorta"), summary(tree, "left anterior tibial 1")
    foot = summary(tree, "left anterior tibial 3", 0.15)
    assert 1.05 < knee.pulse / aorta.pulse < 1.4
    assert knee.systolic > aorta.systolic
    assert foot.pulse < knee.pulse


def test_foot_of_the_wave_arrives_with_the_speed_of_the_walls(tree):
    segment = tree.table.id_of["left anterior tibial 1"]
    aorta = foot_time(tree.time, tree.pressure_aorta())
    knee = foot_time(tree.time, tree.pressure(segment, 0.0))
    speed = wave_speed(tree.table, density=1060.0, poisson_ratio=0.5)
    rows = [tree.table.row(tree.table.id_of[name]) for name in AORTA + LEG[:-1]]
    travel = float(np.sum(tree.table.length[rows] / speed[rows]))
    # viscosity slows the wave, the stiffening wall hastens it; ±30 % covers both
    assert (knee - aorta) % tree.period == pytest.approx(travel, rel=0.3)


def test_resting_flow_of_the_leg_and_the_heart(tree):
    litre_per_minute = 1e-3 / 60.0
    assert 4.0 < tree.mean_flow(1) / litre_per_minute < 6.0
    leg = tree.mean_flow(tree.table.id_of["left external iliac 1"]) / litre_per_minute
    assert 0.25 < leg < 0.65  # PHYSICS.md 6: common femoral 350-635 ml/min


def test_severed_artery_peaks_lower_and_later_than_the_aorta(tree):
    """Fig. 4: smaller amplitude and a slight delay of the peak in the injured artery."""
    for fraction in (0.2, 0.5, 0.8):
        port = tree.injury_port(*tree.locate("anterior_tibial", fraction))
        beat = port.bleed(0.0)
        aorta = summarise_cycle(beat.time, beat.pressure_aorta)
        artery = summarise_cycle(beat.time, beat.pressure_artery)
        assert artery.systolic < aorta.systolic
        assert artery.pulse < aorta.pulse
        assert 0.0 < artery.peak_time - aorta.peak_time < 0.2


def test_bleeding_is_pulsatile_at_the_hearts_rate(tree):
    flow = tree.injury_port(*tree.locate("anterior_tibial", 0.5)).bleed(0.0).flow_injury
    spectrum = np.abs(np.fft.rfft(flow))
    assert np.argmax(spectrum[1:]) == 0  # the first harmonic is the largest
    assert 0.2 < np.ptp(flow) / np.mean(flow) < 1.5


@pytest.mark.parametrize("rate", [0.8, 1.2, 2.0, 3.0])
def test_faster_hearts_keep_the_mean_pressure(rate):
    tree = build_tree(CirculationParameters(heart_rate=rate))
    at_rest = build_tree(CirculationParameters())
    name = "left anterior tibial 2"
    assert tree.period == pytest.approx(1.0 / rate)
    assert summary(tree, name).mean == pytest.approx(summary(at_rest, name).mean, rel=1e-12)


def test_pressure_at_the_root_follows_the_heart_to_the_last_harmonic():
    for harmonics in (64, 128, 256):
        tree = build_tree(CirculationParameters(harmonics=harmonics))
        segment, position = tree.locate("anterior_tibial", 0.5)
        systolic = tree.pressure_summary(segment, position).systolic
        reference = build_tree(CirculationParameters()).pressure_summary(segment, position)
        # 1 %: what harmonics above 64 carry
        assert systolic == pytest.approx(reference.systolic, rel=0.01)
