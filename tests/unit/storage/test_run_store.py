"""The run directory: nothing finished is lost, nothing of another run is touched."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vulnus.core.errors import StorageError
from vulnus.core.handoff import BleedLedger, BleedWaveforms
from vulnus.storage import FileCheckpoint, RunStore, StageBook, StageReachedError


def test_a_new_run_holds_its_scenario(tmp_path: Path) -> None:
    with RunStore.create(tmp_path / "a" / "run", "seed = 1\n") as store:
        assert store.scenario_text() == "seed = 1\n"
        assert not store.is_finished()


def test_a_run_with_something_finished_needs_resume(tmp_path: Path) -> None:
    with RunStore.create(tmp_path / "run", "x") as store:
        store.save_stage("imaging", (1, 2), {"wall": 1.0})
    with pytest.raises(StorageError, match="--resume"):
        RunStore.create(tmp_path / "run", "x")
    with RunStore.create(tmp_path / "run", "x", resume=True) as store:
        assert store.load_stage("imaging", tuple) == (1, 2)


def test_a_run_with_nothing_finished_may_be_begun_again(tmp_path: Path) -> None:
    RunStore.create(tmp_path / "run", "old").close()
    with RunStore.create(tmp_path / "run", "new") as store:
        assert store.scenario_text() == "new"


def test_a_directory_that_is_no_run_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("x")
    for resume in (False, True):
        with pytest.raises(StorageError, match="not a run"):
            RunStore.create(tmp_path, "x", resume=resume)
    assert [item.name for item in tmp_path.iterdir()] == ["thesis.txt"]


def test_a_file_or_a_closed_place_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(StorageError, match="not a directory"):
        RunStore.create(tmp_path / "file", "x")
    with pytest.raises(StorageError, match="file, not a directory"):
        RunStore.create(tmp_path / "file" / "run", "x")
    with pytest.raises(StorageError, match="does not exist"):
        RunStore.open(tmp_path / "nothing")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_place_is_told(tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(StorageError, match="not permitted"):
        RunStore.create(tmp_path / "closed" / "run", "x")


def test_two_processes_never_write_one_run(tmp_path: Path) -> None:
    program = (
        "import sys, pathlib\nfrom vulnus.storage import RunStore\n"
        "from vulnus.core.errors import StorageError\n"
        "try:\n    RunStore.open(pathlib.Path(sys.argv[1]))\n"
        "except StorageError as error:\n    print(error.problem)\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "run")]
    with RunStore.create(tmp_path / "run", "x"):
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert f"process {os.getpid()}" in done.stdout
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == ""


def test_parts_of_a_killed_session_are_removed(tmp_path: Path) -> None:
    RunStore.create(tmp_path / "run", "x").close()
    (tmp_path / "run" / "wound").mkdir()
    part = tmp_path / "run" / "wound" / ".part-wound_000003.vtkhdf"
    part.write_bytes(b"half")
    RunStore.create(tmp_path / "run", "x", resume=True).close()
    assert not part.exists()


def test_a_damaged_stage_is_computed_again(tmp_path: Path) -> None:
    with RunStore.create(tmp_path / "run", "x") as store:
        store.save_stage("imaging", (1,), {"wall": 1.0})
        path = tmp_path / "run" / "checkpoints" / "imaging.h5"
        path.write_bytes(path.read_bytes()[:-10])
        said: list[str] = []
        book = StageBook(store, said.append, None)
        assert book.stage("imaging", tuple, lambda _: (2,))() == (2,)
        assert any("truncated" in sentence for sentence in said)


def test_a_stage_of_another_version_is_refused_and_kept(tmp_path: Path) -> None:
    with RunStore.create(tmp_path / "run", "x") as store:
        store.save_stage("injury", (1, 2), {"wall": 1.0})
        file = store.path / "checkpoints" / "injury.h5"
        before = file.read_bytes()
        with pytest.raises(StorageError, match=r"another version.*tuple.*provenance\.json"):
            store.load_stage("injury", BleedLedger)
        assert file.read_bytes() == before


def test_a_stage_is_computed_once_in_the_life_of_a_run(tmp_path: Path) -> None:
    with RunStore.create(tmp_path / "run", "x") as store:
        first = StageBook(store, lambda _: None, None)
        assert first.stage("anatomy", tuple, lambda _: (1,))() == (1,)
        again = StageBook(store, lambda _: None, None)
        assert again.stage("anatomy", tuple, lambda _: pytest.fail("computed again"))() == (1,)
        assert again.cost["anatomy"]["wall"] == first.cost["anatomy"]["wall"]
        assert again.cost["anatomy"]["peak_memory"] > 1e6  # a Python process holds more than 1 MB


def test_until_ends_the_run_after_its_stage(tmp_path: Path) -> None:
    with RunStore.create(tmp_path / "run", "x") as store:
        book = StageBook(store, lambda _: None, "anatomy")
        book.stage("imaging", tuple, lambda _: (1,))
        with pytest.raises(StageReachedError):
            book.stage("anatomy", tuple, lambda _: (2,))
        assert store.load_stage("anatomy", tuple) == (2,)


def test_wall_time_of_a_killed_session_is_counted(tmp_path: Path) -> None:
    path, notices = tmp_path / "x.h5", []
    first = FileCheckpoint(path, 0.0, notices.append)
    assert first.load() is None
    assert first.due()
    first._started -= 100.0  # as if 100 s had passed
    first.save({"step": 3, "time": 0.1, "name": "a", "x": np.arange(3.0)})
    second = FileCheckpoint(path, 20.0, notices.append)
    data = second.load()
    assert data is not None
    assert (data["step"], data["time"], data["name"]) == (3, 0.1, "a")
    assert 100.0 <= second.wall < 160.0
    assert not second.due()
    path.write_bytes(path.read_bytes()[:700])
    assert FileCheckpoint(path, 20.0, notices.append).load() is None
    assert "starts anew" in notices[-1]
    assert not path.exists()


def test_sessions_are_written_down(tmp_path: Path) -> None:
    volume = tmp_path / "leg.nrrd"
    volume.write_bytes(b"x")
    with RunStore.create(tmp_path / "run", "x") as store:
        with (
            pytest.raises(KeyboardInterrupt),
            store.session(["vulnus", "run"], seed=7, threads=2, inputs=[volume]),
        ):
            raise KeyboardInterrupt
        assert store.provenance()["outcome"] == "interrupted"
        with store.session(["vulnus"], seed=7, threads=1, inputs=[volume]):
            pass
        record = json.loads((tmp_path / "run" / "provenance.json").read_text())
        assert [one["outcome"] for one in record["sessions"]] == ["interrupted", "finished"]
        assert record["seed"] == 7
        assert {"version", "commit", "host", "started", "finished", "python"} <= set(record)
        assert record["inputs"][0]["bytes"] == 1
        assert store.is_finished()
        volume.write_bytes(b"y")
        with (
            pytest.raises(StorageError, match="has changed"),
            store.session(["vulnus"], seed=7, threads=1, inputs=[volume]),
        ):
            pytest.fail("the run went on")


def test_tables_have_the_columns_of_the_handbook(tmp_path: Path) -> None:
    time = np.linspace(0.0, 1.0, 5)
    waves = BleedWaveforms(time, *(time * 133.322387415 * k for k in (1, 2, 3)), time / 6e7)
    ledger = BleedLedger(time, time * 1e-6, time * 0, time * 0, time * 0, time * 1e-6)
    with RunStore.create(tmp_path / "run", "x") as store:
        store.write_waveforms(waves)
        store.write_ledger(ledger)
        with (tmp_path / "run" / "waveforms.csv").open() as stream:
            rows = list(csv.DictReader(stream))
        assert list(rows[0]) == [
            "t_s",
            "pressure_aorta_mmHg",
            "pressure_artery_mmHg",
            "pressure_injury_mmHg",
            "flow_injury_ml_per_min",
        ]
        assert [float(x) for x in rows[-1].values()] == [1.0, 1.0, 2.0, 3.0, 1.0]
        header = (tmp_path / "run" / "ledger.csv").read_text().splitlines()[0]
        assert header == "t_s,injected_ml,in_limb_ml,out_of_limb_ml,removed_ml,pending_ml"
        assert np.allclose(store.read_ledger().injected, ledger.injected, rtol=1e-8)
        assert np.allclose(store.read_waveforms().flow_injury, waves.flow_injury, rtol=1e-8)
        store.write_waveforms(None)
        assert len(store.read_waveforms().time) == 0
