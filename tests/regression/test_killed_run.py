"""A run killed in the middle of every stage, one after the other, ends like one that never was.

The coarsest scenario goes through all real stages in child processes that kill themselves.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vulnus.storage.handoff_file import read_handoff, read_note

pytestmark = [pytest.mark.regression, pytest.mark.slow]

TINY = Path(__file__).with_name("tiny.toml")

KILLED = """
import os, signal, sys
from vulnus import pipeline
from vulnus.cli import main
from vulnus.terminal import LineProgress

stage, directory, scenario = sys.argv[1:]
kill = lambda: os.kill(os.getpid(), signal.SIGKILL)

class Progress(LineProgress):  # kills the process when more than a third of a stage is done
    def update(self, completed, note=""):
        prepared = stage != "hemorrhage" or self._stage == "bleeding"
        if current == stage and prepared and completed > self._total / 3:
            kill()

current = ""
import vulnus.storage.stage_book as book
run_stage = book.StageBook._run
def run_and_note(self, name, compute):
    global current
    current = name
    if name == stage and name in ("imaging", "circulation"):  # too short to tell their progress
        def compute(kept, compute=compute):
            compute(kept)
            kill()
    return run_stage(self, name, compute)
book.StageBook._run = run_and_note
import vulnus.terminal
vulnus.terminal.LineProgress = Progress
sys.exit(main(["run", scenario, "-o", directory, "--resume"]))
"""


def start(program: list[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *program], capture_output=True, text=True, check=False, timeout=300
    )


def results(directory: Path) -> dict[str, Any]:
    """Every file of a run that must be the same to the bit, and the summary without its cost."""
    kept = {
        str(path.relative_to(directory)): path.read_bytes()
        for folder in ("wound", "bleed")
        for path in sorted((directory / folder).iterdir())
    }
    for name in ("waveforms.csv", "ledger.csv", "scenario.toml"):
        kept[name] = (directory / name).read_bytes()
    summary = json.loads((directory / "summary.json").read_text())
    del summary["cost"]
    return kept | {"summary": summary}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("runs") / "whole"
    done = start(["-m", "vulnus", "run", str(TINY), "-o", str(directory)])
    assert done.returncode == 0, done.stderr
    return directory


def test_a_run_killed_in_every_stage_ends_the_same(tmp_path: Path, uninterrupted: Path) -> None:
    directory = tmp_path / "killed"
    finished: dict[Path, int] = {}
    stages = ("imaging", "anatomy", "injury", "circulation", "hemorrhage")
    for stage in stages:
        done = start(["-c", KILLED, stage, str(directory), str(TINY)])
        assert done.returncode == -signal.SIGKILL, f"{stage}: {done.stderr}"
        ends = directory / "checkpoints"
        now = {
            path: path.stat().st_mtime_ns
            for path in ends.glob("*.h5")
            if ".running" not in path.name
        }
        assert {path.stem for path in now} == set(stages[: stages.index(stage)])
        assert finished.items() <= now.items()  # nothing finished was lost or made again
        finished = now
        if stage in ("injury", "hemorrhage"):
            assert (ends / f"{stage}.running.h5").exists()
    done = start(["-m", "vulnus", "run", str(TINY), "-o", str(directory), "--resume"])
    assert done.returncode == 0, done.stderr
    before, after = results(uninterrupted), results(directory)
    assert before.keys() == after.keys()
    assert [name for name in before if before[name] != after[name]] == []
    sessions = json.loads((directory / "provenance.json").read_text())["sessions"]
    assert len(sessions) == len(stages) + 1
    wall = json.loads((directory / "summary.json").read_text())["cost"]["wall_s"]
    assert set(wall) >= set(stages)
    assert all(float(read_note(path)["wall"]) > 0 for path in finished)


def test_one_thread_gives_the_same_bits(tmp_path: Path, uninterrupted: Path) -> None:
    scenario = tmp_path / "one.toml"
    scenario.write_text(TINY.read_text().replace("[run]", "[run]\nthreads = 1"))
    directory = tmp_path / "one"
    done = start(["-m", "vulnus", "run", str(scenario), "-o", str(directory)])
    assert done.returncode == 0, done.stderr
    before, after = results(uninterrupted), results(directory)
    assert [name for name in before if before[name] != after[name]] == ["scenario.toml"]


def test_another_seed_gives_another_limb(tmp_path: Path, uninterrupted: Path) -> None:
    """The comparisons above can fail."""
    scenario = tmp_path / "other.toml"
    scenario.write_text(TINY.read_text().replace("[run]", "[run]\nseed = 2"))
    directory = tmp_path / "other"
    command = ["run", str(scenario), "-o", str(directory), "--until", "anatomy"]
    assert start(["-m", "vulnus", *command]).returncode == 0
    mine, other = (
        read_handoff(path / "checkpoints" / "anatomy.h5")[0].position
        for path in (uninterrupted, directory)
    )
    assert not np.array_equal(mine, other)
