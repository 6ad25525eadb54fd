"""A run stops within a second of Ctrl-C, wherever it is, and shows the time left before that."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time

import pytest

from vulnus.terminal import BarProgress, LineProgress, stopped_by_signals, summary_rows

PROGRAM = """
import sys, time, hashlib
from vulnus.terminal import stopped_by_signals
def busy_in_python():
    while True:
        time.sleep(0.01)
def busy_in_native_code():  # half a minute and more in one call that lets other threads run
    hashlib.pbkdf2_hmac("sha256", b"a", b"b", 100_000_000)
with stopped_by_signals(lambda number: sys.stderr.write(f"last words {number}")):
    print("ready", flush=True)
    WORK()
"""


def seconds_until_it_ends(work: str, number: signal.Signals) -> float:
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM.replace("WORK", work)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.2)
    begun = time.monotonic()
    process.send_signal(number)
    _, said = process.communicate(timeout=20)
    elapsed = time.monotonic() - begun
    assert f"last words {int(number)}" in said
    assert process.returncode != 0
    return elapsed


@pytest.mark.parametrize("work", ["busy_in_python", "busy_in_native_code"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_process_within_a_second(work: str, number: signal.Signals) -> None:
    # 0.5 s of grace and the start of an idle thread; the best of three on a busy machine
    assert any(seconds_until_it_ends(work, number) < 1.0 for _ in range(3))


def test_handlers_are_as_before_behind_the_block() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with stopped_by_signals(lambda _: None):
        assert signal.getsignal(signal.SIGTERM) != before[1]
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_a_signal_in_the_block_says_the_last_words() -> None:
    said: list[int] = []

    def wait_for_the_signal() -> None:
        with stopped_by_signals(said.append):
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(5)

    with pytest.raises(KeyboardInterrupt):
        wait_for_the_signal()
    assert said == [signal.SIGTERM]


def test_lines_come_every_few_seconds_with_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    lines: list[str] = []
    progress = LineProgress(lines.append)
    progress.begin("injury", 1.0, "ms")
    for tenth in range(1, 100):
        now[0] = tenth / 10
        progress.update(tenth / 200, "two")
    progress.end()
    assert lines[0] == "injury: 10 %, 18 s left (two)"
    assert len(lines) == 2  # at 2 s and at 7 s


def test_a_short_stage_leaves_no_line() -> None:
    lines: list[str] = []
    progress = LineProgress(lines.append)
    progress.begin("injury", 1.0, "ms")
    progress.update(0.5)
    progress.end()
    assert lines == []


def test_bars_show_stage_and_note() -> None:
    from rich.console import Console

    screen = io.StringIO()
    progress = BarProgress(Console(file=screen, force_terminal=True, width=120))
    progress.begin("bleeding", 3.0, "s")
    progress.update(1.5, "4.2 ml")
    progress._bars.refresh()
    progress.begin("film", 0, "")  # a total that is not known
    progress.update(1.0)
    progress.end()
    progress.end()
    shown = screen.getvalue()
    for word in ("bleeding", "50%", "left", "4.2 ml", "film"):
        assert word in shown


def test_a_summary_without_a_cut_says_so() -> None:
    rows = dict(
        summary_rows(
            {
                "wound": {"severed_segment": None, "entry_area_mm2": 60.0, "exit_area_mm2": None},
                "bleeding": {"duration_s": None},
                "cost": {"wall_s": {"injury": 61.4}, "peak_memory_mb": 700.0},
            }
        )
    )
    assert rows["cut artery"] == "none"
    assert rows["exit wound"] == "unknown"
    assert "blood lost" not in rows
    assert rows["time"] == "61 s (injury 61)"
    assert dict(summary_rows({})) == {}


def test_a_summary_tells_of_every_projectiles_holes() -> None:
    first = {"entry_area_mm2": 60.0, "exit_area_mm2": 80.0}
    others = [{"entry_area_mm2": 50.0, "exit_area_mm2": None}, first]
    rows = dict(summary_rows({"wound": {**first, "holes": [first, *others]}}))
    assert rows["exit wound"] == "80 mm²"
    assert rows["projectile 2"] == "entry 50 mm², no exit"
    assert rows["projectile 3"] == "entry 60 mm², exit 80 mm²"


def test_a_summary_tells_of_the_cavity_and_of_a_projectile_that_stays_inside() -> None:
    report = {
        "temporary_cavity_ml": 121.0,
        "temporary_time_ms": 1.5,
        "permanent_cavity_ml": 18.5,
        "energy_left_j": 341.0,
        "collapse_time_ms": None,
        "notes": ["coarse cells"],
    }
    wound = {"severed_segment": "fibular", "entry_area_mm2": 60.0, "exit_area_mm2": None}
    rows = dict(summary_rows({"wound": {**wound, "report": report}}))
    assert rows["exit wound"] == "none"
    assert rows["cavity"] == "121 ml at 1.5 ms, 18.5 ml at the end, not collapsed"
    assert rows["note"] == "coarse cells"
    report["collapse_time_ms"] = 8.0
    rows = dict(summary_rows({"wound": {**wound, "report": report}}))
    assert rows["cavity"].endswith("collapsed at 8 ms")
    report["temporary_cavity_ml"] = 0.0
    assert dict(summary_rows({"wound": {**wound, "report": report}}))["cavity"] == "none"
    assert rows["energy left"] == "341 J"
