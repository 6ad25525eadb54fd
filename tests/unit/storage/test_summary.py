"""The numbers of `summary.json` are those of the stages, in the units of their names."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from reference.injury_outcomes import injury_outcome

from vulnus.core.handoff import BleedLedger, BleedOutcome, BleedWaveforms, ProjectileHoles
from vulnus.storage import summarise

from .test_handoff_file import injured_limb

COST = {"injury": {"wall": 2.0, "peak_memory": 3e8}, "anatomy": {"wall": 1.0, "peak_memory": 1e8}}


def outcome(duration: float, beats: list[float]) -> BleedOutcome:
    time = np.linspace(0.0, duration, 5)
    return BleedOutcome(
        waveforms=BleedWaveforms(time, *(np.full(5, p * 133.322387415) for p in (90, 10, 1)), time),
        ledger=BleedLedger(time, time * 1e-6, time * 6e-7, time * 3e-7, time * 1e-7, time * 0),
        period=0.8,
        mean_flow_per_beat=np.array(beats),
        barrier_crossings=0,
        particle_count=10,
        steps=100,
        particle_steps_per_second=float("nan"),
    )


def test_volumes_and_flows_have_their_units() -> None:
    summary = summarise(injury_outcome(injured_limb()), outcome(2.0, [1e-6, 2e-6, 9e-6]), COST)
    bleeding = summary["bleeding"]
    assert bleeding["injected_ml"] == pytest.approx(2.0)
    assert bleeding["in_limb_ml"] == pytest.approx(1.2)
    assert bleeding["out_of_limb_ml"] == pytest.approx(0.6)
    assert bleeding["removed_ml"] == pytest.approx(0.2)
    assert bleeding["volume_error_fraction"] == pytest.approx(0.0, abs=1e-15)
    assert bleeding["mean_pressure_artery_mmhg"] == pytest.approx(10.0)
    assert summary["wound"]["entry_area_mm2"] == pytest.approx(64.0)
    assert summary["wound"]["injuries"][0]["gap_mm"] == pytest.approx(9.0)
    assert summary["cost"]["wall_s"] == {"injury": 2.0, "anatomy": 1.0}
    assert summary["cost"]["peak_memory_mb"] == 300.0
    assert summary["cost"]["hemorrhage_particle_steps_per_s"] is None  # JSON has no NaN


def test_first_and_last_beat_are_those_of_the_stage() -> None:
    bleeding = summarise(injury_outcome(injured_limb()), outcome(2.0, [1e-6, 3e-6, 2e-6]), COST)[
        "bleeding"
    ]
    assert bleeding["mean_flow_first_beat_ml_per_min"] == pytest.approx(60.0)
    assert bleeding["mean_flow_last_beat_ml_per_min"] == pytest.approx(120.0)


def test_what_is_not_cut_loses_nothing_and_what_has_not_bled_yet_is_not_known() -> None:
    wound = dataclasses.replace(injured_limb(), injuries=())
    cut = summarise(injury_outcome(injured_limb()), outcome(2.0, [1e-6]), COST)["bleeding"]
    uncut = summarise(injury_outcome(wound), None, COST)["bleeding"]
    not_yet = summarise(injury_outcome(injured_limb()), None, COST)["bleeding"]
    assert uncut.keys() == cut.keys() == not_yet.keys()
    assert uncut["injected_ml"] == uncut["mean_flow_last_beat_ml_per_min"] == 0
    assert uncut["mean_pressure_artery_mmhg"] is None
    assert not_yet["injected_ml"] is None


def test_both_states_and_the_report_are_told() -> None:
    """The state that bleeds stands at the top; a part that nothing came near has no distance."""
    permanent = dataclasses.replace(injured_limb(), entry_area=2e-5, exit_area=None)
    outcome = injury_outcome(permanent, temporary=injured_limb())
    wound = summarise(outcome, None, COST)["wound"]
    assert wound["state"] == "permanent"
    assert wound["entry_area_mm2"] == pytest.approx(20.0)
    assert wound["exit_area_mm2"] is None
    assert wound["states"]["temporary"]["entry_area_mm2"] == pytest.approx(64.0)
    report = wound["report"]
    assert report["energy_left_j"] == pytest.approx(20.0)
    assert report["temporary_cavity_ml"] == pytest.approx(30.0)
    assert report["permanent_cavity_ml"] == pytest.approx(1.0)
    assert [vessel["kind"] for vessel in report["arteries"]] == ["transected", "intact"]
    assert report["arteries"][1]["nearest_distance_mm"] is None
    assert report["cavity_collapsed"] is False
    assert (report["collapse_time_ms"], report["end_time_ms"]) == (None, 2.0)
    assert report["bone"]["debris_pieces"] == 0
    assert report["notes"] == []
    assert report["projectiles"][0]["tract_length_mm"] == pytest.approx(40.0)
    assert report["bone"]["fragment_masses_g"] == pytest.approx([1.0])
    chosen = dataclasses.replace(outcome, bleeds_from="temporary")
    assert summarise(chosen, None, COST)["wound"]["entry_area_mm2"] == pytest.approx(64.0)


def test_the_holes_of_every_projectile_and_crushed_pieces_are_told() -> None:
    other = ProjectileHoles((0.0, 0.01, 0.0), 3e-5, None, None)
    limb = dataclasses.replace(injured_limb(), other_holes=(other,))
    made = injury_outcome(limb)
    bone = dataclasses.replace(made.report.bone, debris_piece_mass=5e-5)
    report = dataclasses.replace(made.report, bone=bone, collapse_time=1.5e-3)
    wound = summarise(dataclasses.replace(made, report=report), None, COST)["wound"]
    first, second = wound["holes"]
    assert (first["entry_area_mm2"], first["exit_area_mm2"]) == pytest.approx((64.0, 110.0))
    assert first["entry_point_mm"] == wound["entry_point_mm"]
    assert second["entry_point_mm"] == pytest.approx([0.0, 10.0, 0.0])
    assert second["entry_area_mm2"] == pytest.approx(30.0)
    assert second["exit_area_mm2"] is second["exit_point_mm"] is None
    assert wound["report"]["collapse_time_ms"] == pytest.approx(1.5)
    assert wound["report"]["bone"]["debris_pieces"] == 40  # 2 g of 50 mg


def test_skin_that_has_become_sparse_is_told() -> None:
    bled = dataclasses.replace(outcome(1.0, [1e-6]), skin_open_area=2e-6, skin_sparse_area=3e-6)
    bleeding = summarise(injury_outcome(injured_limb()), bled, COST)["bleeding"]
    assert bleeding["skin_open_area_mm2"] == pytest.approx(2.0)
    assert bleeding["skin_sparse_area_mm2"] == pytest.approx(3.0)
