"""The order of the stages and what becomes of a run that stops, fails or goes on.

Imaging, anatomy, injury, bleeding and pictures are stand-ins that count their calls; the
circulation and everything about the run directory are real.
"""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from reference.injury_outcomes import injury_outcome

from vulnus import pipeline
from vulnus.cli import main
from vulnus.core.errors import AnatomyError, ScenarioError, StorageError
from vulnus.core.handoff import (
    BleedLedger,
    BleedOutcome,
    BleedWaveforms,
    InjuredLimb,
    InjuryOutcome,
    LabelVolume,
    LimbModel,
    ParticleFrame,
    ShotLine,
    VesselInjury,
)
from vulnus.hemorrhage import Openings
from vulnus.scenario import load_scenario
from vulnus.storage import RunStore

CUT = VesselInjury(
    artery="anterior_tibial",
    arc_length=0.15,
    arc_fraction=0.45,
    gap=9e-3,
    lumen_radius=1.4e-3,
    position=(0.0, 0.0, 0.0),
    position_proximal=(0.0, 0.0, 5e-3),
    position_distal=(0.0, 0.0, -5e-3),
    axis_proximal=(0.0, 0.0, -1.0),
    axis_distal=(0.0, 0.0, 1.0),
)


def points(count: int = 8) -> np.ndarray:
    return np.arange(3 * count, dtype=np.float32).reshape(count, 3)


def limb_model() -> LimbModel:
    return LimbModel(
        position=points(),
        tissue=np.full(8, 2, np.uint8),
        volume=np.ones(8, np.float32),
        spacing=3e-3,
        arteries=(),
        surfaces={},
        side="left",
        source="made up",
    )


def injured_limb(*injuries: VesselInjury) -> InjuredLimb:
    return InjuredLimb(
        position=points(),
        reference_position=points(),
        tissue=np.full(8, 2, np.uint8),
        volume=np.ones(8, np.float32),
        damage=np.zeros(8, np.float32),
        spacing=3e-3,
        arteries=(),
        injuries=injuries,
        shot=ShotLine((0.0, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 1.0, 0.0), 9e-3, 350.0),
        entry_area=6.4e-5,
        exit_area=8e-5,
        time=1e-3,
        steps=100,
        particle_steps_per_second=9e6,
        surfaces={},
        side="left",
    )


def bleed_outcome() -> BleedOutcome:
    time = np.linspace(0.0, 1.0, 11)
    volume = 2e-6 * time
    return BleedOutcome(
        waveforms=BleedWaveforms(time, *(np.full(11, p) for p in (13e3, 11e3, 1e3)), time * 1e-6),
        ledger=BleedLedger(time, volume, 0.5 * volume, 0.5 * volume, 0 * volume, 0 * volume),
        period=0.8,
        mean_flow_per_beat=np.array([2e-6, 1e-6]),
        barrier_crossings=0,
        particle_count=70,
        steps=1000,
        particle_steps_per_second=2e6,
    )


class Stages:
    """Stand-ins that count; `fail` names the stage that raises `error` when it is reached."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.calls: Counter[str] = Counter()
        self.fail: dict[str, BaseException] = {}
        self.injuries: tuple[VesselInjury, ...] = (CUT,)
        for room, name, stage in (
            (pipeline.imaging, "load_labels", self.load_labels),
            (pipeline.anatomy, "build_limb", self.build_limb),
            (pipeline.injury, "shoot", self.shoot),
            (pipeline.hemorrhage, "prepare", self.prepare),
            (pipeline.coupling, "bleed_out", self.bleed_out),
            (pipeline.visualization, "draw_all", self.draw),
        ):
            monkeypatch.setattr(room, name, stage, raising=False)

    def count(self, stage: str) -> None:
        self.calls[stage] += 1
        if stage in self.fail:
            raise self.fail.pop(stage)

    def load_labels(self, *_: Any) -> LabelVolume:
        self.count("imaging")
        return LabelVolume(
            np.ones((2, 2, 2), np.uint8), np.zeros(3), np.ones(3), np.eye(3), (), "made up"
        )

    def build_limb(self, labels: LabelVolume, *_: Any) -> LimbModel:
        assert labels.source == "made up"
        self.count("anatomy")
        return limb_model()

    def shoot(self, limb: LimbModel, _: Any, **given: Any) -> InjuryOutcome:
        assert limb.spacing == 3e-3
        for index in range(3):
            given["on_frame"](ParticleFrame(index, 1e-4 * index, points(), {}))
        self.count("injury")
        return injury_outcome(injured_limb(*self.injuries))

    def prepare(self, wound: InjuredLimb, *_: Any) -> SimpleNamespace:
        assert wound.severed_segment == CUT.artery
        return SimpleNamespace(openings=Openings(leaks=True, area=3e-5))

    def bleed_out(self, port: Any, solver: Any, _: Any, **given: Any) -> BleedOutcome:
        assert solver.openings.leaks
        assert 0.5 < port.period < 1.5
        given["on_frame"](ParticleFrame(0, 0.0, points(), {}))
        given["checkpoint"].save({"step": 1})
        self.count("hemorrhage")
        return bleed_outcome()

    def draw(self, run: Any, *_: Any) -> pipeline.visualization.Drawn:
        assert run.wound.steps == 100
        assert len(run.injury_frames) == 3
        assert run.injury_frames[2].index == 2
        self.count("visualization")
        return pipeline.visualization.Drawn((Path("figures/flow.png"),), ("no film",))


@pytest.fixture
def stages(monkeypatch: pytest.MonkeyPatch) -> Stages:
    return Stages(monkeypatch)


def run(directory: Path, *, resume: bool = False, until: str | None = None) -> list[str]:
    said: list[str] = []
    scenario = load_scenario("demo")
    with RunStore.create(directory, scenario.text, resume=resume) as store:
        pipeline.run_scenario(scenario, store, until=until, say=said.append)
    return said


REQUIRED = (
    "wound.severed_segment",
    "wound.entry_area_mm2",
    "wound.exit_area_mm2",
    "bleeding.duration_s",
    "bleeding.injected_ml",
    "bleeding.out_of_limb_ml",
    "bleeding.mean_flow_first_beat_ml_per_min",
    "bleeding.mean_flow_last_beat_ml_per_min",
    "bleeding.volume_error_fraction",
    "bleeding.barrier_crossings",
    "cost.wall_s",
    "cost.peak_memory_mb",
    "cost.injury_particle_steps_per_s",
    "cost.hemorrhage_particle_steps_per_s",
)


def required(directory: Path) -> dict[str, Any]:
    summary = json.loads((directory / "summary.json").read_text())
    return {name: summary[name.split(".")[0]][name.split(".")[1]] for name in REQUIRED}


def test_a_run_leaves_everything_of_the_handbook(tmp_path: Path, stages: Stages) -> None:
    said = run(tmp_path / "run")
    found = {path.name for path in (tmp_path / "run").iterdir()}
    assert {
        "scenario.toml",
        "provenance.json",
        "summary.json",
        "waveforms.csv",
        "ledger.csv",
        "wound",
        "bleed",
        "checkpoints",
    } <= found
    summary = required(tmp_path / "run")
    assert summary["wound.severed_segment"] == "anterior_tibial"
    assert summary["wound.entry_area_mm2"] == pytest.approx(64.0)
    assert summary["bleeding.injected_ml"] == pytest.approx(2.0)
    assert summary["bleeding.mean_flow_first_beat_ml_per_min"] == pytest.approx(120.0)
    assert summary["bleeding.mean_flow_last_beat_ml_per_min"] == pytest.approx(60.0)
    assert summary["bleeding.volume_error_fraction"] == 0.0
    assert set(summary["cost.wall_s"]) == set(pipeline.STAGES)
    assert summary["cost.peak_memory_mb"] > 10
    assert None not in summary.values()
    assert all(count == 1 for count in stages.calls.values())
    assert "anterior tibial artery is cut" in " ".join(said)
    assert list((tmp_path / "run" / "checkpoints").glob("*.running.h5")) == []


def test_of_several_cut_arteries_the_others_are_said_not_to_bleed(
    tmp_path: Path, stages: Stages
) -> None:
    stages.injuries = (CUT, dataclasses.replace(CUT, artery="posterior_tibial"))
    said = run(tmp_path / "run")
    assert "also torn, but not bled: posterior tibial (transected)" in " ".join(said)


def test_a_run_without_a_cut_says_so_and_ends_well(tmp_path: Path, stages: Stages) -> None:
    stages.injuries = ()
    said = run(tmp_path / "run")
    assert "cut no artery" in " ".join(said)
    assert stages.calls["hemorrhage"] == 0
    assert stages.calls["visualization"] == 1
    summary = required(tmp_path / "run")
    assert summary["wound.severed_segment"] is None
    assert summary["wound.entry_area_mm2"] == pytest.approx(64.0)
    assert [value for name, value in summary.items() if name.startswith("bleeding.")] == [0] * 7
    assert summary["cost.hemorrhage_particle_steps_per_s"] is None
    assert len((tmp_path / "run" / "waveforms.csv").read_text().splitlines()) == 1


def test_a_run_that_ends_with_the_bleeding_leaves_its_tables(
    tmp_path: Path, stages: Stages
) -> None:
    run(tmp_path / "run", until="injury")
    assert required(tmp_path / "run")["bleeding.injected_ml"] is None  # cut, not yet bled
    run(tmp_path / "run", until="hemorrhage", resume=True)
    assert required(tmp_path / "run")["bleeding.injected_ml"] == pytest.approx(2.0)
    assert len((tmp_path / "run" / "ledger.csv").read_text().splitlines()) == 12
    assert stages.calls["visualization"] == 0


@pytest.mark.parametrize("last", pipeline.STAGES)
def test_until_stops_after_its_stage_and_resume_goes_on(
    tmp_path: Path, stages: Stages, last: str
) -> None:
    run(tmp_path / "run", until=last)
    done = pipeline.STAGES.index(last) + 1
    kept = {path.stem for path in (tmp_path / "run" / "checkpoints").glob("*.h5")}
    assert kept == set(pipeline.STAGES[:done])
    run(tmp_path / "run", resume=True)
    assert all(count == 1 for count in stages.calls.values())
    assert required(tmp_path / "run")["bleeding.duration_s"] == 1.0


def test_until_a_stage_that_is_not_one_lists_the_stages(tmp_path: Path, stages: Stages) -> None:
    with pytest.raises(ScenarioError, match=r"Did you mean injury\? Stages: imaging, anatomy"):
        run(tmp_path / "run", until="injry")
    assert not stages.calls


@pytest.mark.parametrize("stage", [s for s in pipeline.STAGES if s != "circulation"])
@pytest.mark.parametrize("trouble", [KeyboardInterrupt(), RuntimeError("x"), AnatomyError(*"abc")])
def test_what_was_finished_before_a_trouble_is_kept(
    tmp_path: Path, stages: Stages, stage: str, trouble: BaseException
) -> None:
    stages.fail[stage] = trouble
    with pytest.raises(type(trouble)):
        run(tmp_path / "run")
    outcome = json.loads((tmp_path / "run" / "provenance.json").read_text())["outcome"]
    assert outcome == ("interrupted" if isinstance(trouble, KeyboardInterrupt) else "failed")
    run(tmp_path / "run", resume=True)
    assert stages.calls.pop(stage) == 2
    assert all(count == 1 for count in stages.calls.values())
    assert required(tmp_path / "run")["bleeding.duration_s"] == 1.0


@pytest.mark.usefixtures("stages")
def test_a_finished_run_is_left_alone(tmp_path: Path) -> None:
    run(tmp_path / "run")
    before = {
        path: path.stat().st_mtime_ns for path in (tmp_path / "run").rglob("*") if path.is_file()
    }
    said = run(tmp_path / "run", resume=True)
    assert "finished: nothing is left to do" in " ".join(said)
    after = {path: path.stat().st_mtime_ns for path in before}
    changed = {path.name for path in before if before[path] != after[path]} - {".lock"}
    assert changed == set()
    with pytest.raises(StorageError, match="run here already"):
        run(tmp_path / "run")


def test_another_scenario_does_not_go_on_with_a_run(tmp_path: Path, stages: Stages) -> None:
    run(tmp_path / "run", until="anatomy")
    other = load_scenario("demo_short")
    with (
        RunStore.create(tmp_path / "run", other.text, resume=True) as store,
        pytest.raises(StorageError, match=r"anatomy\.particle_spacing_mm was"),
    ):
        pipeline.run_scenario(other, store)
    assert stages.calls["anatomy"] == 1


def test_other_threads_may_go_on_with_a_run(tmp_path: Path, stages: Stages) -> None:
    run(tmp_path / "run", until="anatomy")
    scenario = load_scenario("demo")
    text = scenario.text.replace("\nthreads = 0", "\nthreads = 1")
    assert text != scenario.text
    other = dataclasses.replace(scenario, text=text, threads=1)
    with RunStore.create(tmp_path / "run", text, resume=True) as store:
        pipeline.run_scenario(other, store)
    assert stages.calls["anatomy"] == 1
    assert stages.calls["hemorrhage"] == 1


def test_a_damaged_stage_end_is_made_again_from_the_one_before(
    tmp_path: Path, stages: Stages
) -> None:
    run(tmp_path / "run", until="injury")
    kept = tmp_path / "run" / "checkpoints" / "injury.h5"
    kept.write_bytes(kept.read_bytes()[:-100])
    said = run(tmp_path / "run", resume=True)
    assert "injury is computed again" in " ".join(said)
    assert stages.calls["injury"] == 2
    assert stages.calls["anatomy"] == 1


@pytest.mark.usefixtures("stages")
def test_cost_of_a_run_in_two_sessions_is_that_of_all_its_stages(tmp_path: Path) -> None:
    run(tmp_path / "run", until="circulation")
    run(tmp_path / "run", resume=True)
    assert set(required(tmp_path / "run")["cost.wall_s"]) == set(pipeline.STAGES)


def test_the_command_line_ends_with_the_errors_own_code(
    tmp_path: Path, stages: Stages, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ["-o", str(tmp_path / "run")]
    stages.fail["anatomy"] = AnatomyError("bone", "the volume has none", "Take another volume")
    assert main(["run", "demo", *where]) == AnatomyError.exit_code
    assert "bone: the volume has none." in capsys.readouterr().err
    stages.fail["injury"] = RuntimeError("odd")
    assert main(["run", "demo", *where, "--resume"]) == 70
    assert "defect in vulnus" in capsys.readouterr().err
    stages.fail["hemorrhage"] = KeyboardInterrupt()
    assert main(["run", *where, "--resume"]) == 130
    assert f"vulnus run -o {tmp_path / 'run'} --resume" in capsys.readouterr().err
    assert main(["run", *where, "--resume"]) == 0
    shown = capsys.readouterr().err
    assert "anterior tibial" in shown
    assert "2 ml in 1 s" in shown
    assert main(["run", "demo", *where]) == StorageError.exit_code
    assert main(["render", str(tmp_path / "run")]) == 0
    assert stages.calls["visualization"] == 2
    assert main(["render", str(tmp_path / "nothing")]) == StorageError.exit_code


def test_render_needs_a_finished_injury(
    tmp_path: Path, stages: Stages, capsys: pytest.CaptureFixture[str]
) -> None:
    run(tmp_path / "run", until="anatomy")
    assert main(["render", str(tmp_path / "run")]) == StorageError.exit_code
    assert "no finished injury" in capsys.readouterr().err
    assert stages.calls["visualization"] == 0


def test_demo_takes_the_next_free_directory(
    tmp_path: Path, stages: Stages, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["demo"]) == main(["demo"]) == 0
    assert {path.name for path in (tmp_path / "runs").iterdir()} == {"demo", "demo-2"}
    assert stages.calls["visualization"] == 2
