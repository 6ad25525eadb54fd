"""What the user of the command line sees of a run: bars or lines, and a stop within a second."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

LINE_INTERVAL = 5.0
"""Wall time [s] between two lines where no bar can be drawn; chosen: a log stays readable."""
SHORT_STAGE = 2.0
"""Stages shorter than this [s] leave no line behind."""
GRACE = 0.5
"""Wall time [s] that a native call may still take after Ctrl-C before the process just ends;
nothing is lost then, because every file is written whole or not at all."""


class BarProgress:
    """`core.progress.Progress` as bars with the time left, on a terminal."""

    def __init__(self, console: Console) -> None:
        from rich.progress import (
            BarColumn,
            Progress,
            TaskID,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        self._bars = Progress(
            TextColumn("{task.description:<24}"),
            BarColumn(bar_width=28),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            TextColumn("[dim]{task.fields[note]}"),
            console=console,
            refresh_per_second=5,
            transient=True,
        )
        self._task: TaskID | None = None

    def begin(self, stage: str, total: float, unit: str) -> None:
        """Start a bar."""
        self.end()
        self._bars.start()
        note = "" if unit in ("", "1") else f"of {total:g} {unit}"
        self._task = self._bars.add_task(stage, total=total if total > 0 else None, note=note)

    def update(self, completed: float, note: str = "") -> None:
        """Move the bar."""
        if self._task is not None:
            self._bars.update(self._task, completed=completed)
            if note:
                self._bars.update(self._task, note=note)

    def end(self) -> None:
        """Take the bar away; the line about the finished stage stands in its place."""
        if self._task is not None:
            self._bars.remove_task(self._task)
            self._task = None
        self._bars.stop()


class LineProgress:
    """`core.progress.Progress` as a line every few seconds, for a log file or a pipe."""

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write
        self._stage, self._total, self._unit = "", 0.0, ""
        self._began = self._written = time.monotonic()

    def begin(self, stage: str, total: float, unit: str) -> None:
        """Remember the stage."""
        self._stage, self._total, self._unit = stage, total, unit
        # The first line of a stage comes once it has shown that it is a long one.
        self._began = time.monotonic()
        self._written = self._began + SHORT_STAGE - LINE_INTERVAL

    def update(self, completed: float, note: str = "") -> None:
        """Write a line if the last one is long enough ago."""
        now = time.monotonic()
        if now - self._written < LINE_INTERVAL:
            return
        self._written = now
        part = completed / self._total if self._total > 0 else 0.0
        text = f"{self._stage}: {100 * part:.0f} %"
        if part > 0:
            text += f", {(now - self._began) * (1 - part) / part:.0f} s left"
        self._write(f"{text}{f' ({note})' if note else ''}")

    def end(self) -> None:
        """Forget the stage."""


@contextmanager
def notes_said(say: Callable[[str], None]) -> Iterator[None]:
    """Warnings and log records of the stages become sentences for the user."""
    import logging
    import warnings

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            say(f"note: {record.getMessage()}")

    def show(message: Warning | str, *_: object, **__: object) -> None:
        say(f"note: {message}")

    logger, handler = logging.getLogger("vulnus"), Handler(logging.INFO)
    before, logger.propagate = logger.propagate, False
    logger.addHandler(handler)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = show
            yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = before


class Terminated(KeyboardInterrupt):
    """The process was asked to end (SIGTERM)."""


@contextmanager
def stopped_by_signals(last_words: Callable[[int], None]) -> Iterator[None]:
    """Ctrl-C and SIGTERM end the block within a second, even inside a native call.

    Python sees a signal only between two of its own instructions. A native call that takes longer
    than `GRACE` is not waited for: `last_words(signal)` is said from another thread and the process
    ends.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    done = threading.Event()
    watch = threading.Thread(target=_watch, args=(reader, done, last_words), daemon=True)
    before = {
        signal.SIGINT: signal.signal(signal.SIGINT, signal.default_int_handler),
        signal.SIGTERM: signal.signal(signal.SIGTERM, _terminate),
    }
    wakeup = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    watch.start()
    try:
        yield
    except KeyboardInterrupt as stop:
        done.set()
        last_words(signal.SIGTERM if isinstance(stop, Terminated) else signal.SIGINT)
        raise
    finally:
        done.set()
        signal.set_wakeup_fd(wakeup)
        for number, handler in before.items():
            signal.signal(number, handler)
        os.close(writer)
        watch.join(timeout=1.0)
        os.close(reader)


def _terminate(_number: int, _frame: FrameType | None) -> None:
    raise Terminated


def _watch(reader: int, done: threading.Event, last_words: Callable[[int], None]) -> None:
    while data := os.read(reader, 1):
        number = data[0]
        if number not in (signal.SIGINT, signal.SIGTERM):
            continue
        if not done.wait(GRACE):
            sys.stderr.write("\x1b[?25h" if sys.stderr.isatty() else "")  # the cursor is back
            last_words(number)
            sys.stderr.flush()
            os._exit(128 + number)


def summary_rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What to show of `summary.json` at the end of a run: name and value with its unit."""
    wound, bleeding = summary.get("wound") or {}, summary.get("bleeding") or {}
    if wound:
        artery = wound.get("severed_segment")
        yield "cut artery", artery.replace("_", " ") if artery else "none"
        yield "entry wound", _shown(wound.get("entry_area_mm2"), "mm²")
        hole, report = wound.get("exit_area_mm2"), wound.get("report") or {}
        yield "exit wound", "none" if report and hole is None else _shown(hole, "mm²")
        for number, other in enumerate(wound.get("holes", [])[1:], start=2):
            inward, outward = other["entry_area_mm2"], other["exit_area_mm2"]
            out = "no exit" if outward is None else f"exit {_shown(outward, 'mm²')}"
            yield f"projectile {number}", f"entry {_shown(inward, 'mm²')}, {out}"
        yield from _report_rows(report)
    if bleeding.get("duration_s"):
        outside = _shown(bleeding["out_of_limb_ml"] + bleeding["removed_ml"], "ml")
        lost, duration = _shown(bleeding["injected_ml"], "ml"), _shown(bleeding["duration_s"], "s")
        yield "blood lost", f"{lost} in {duration}, {outside} of it out of the limb"
        first = _shown(bleeding["mean_flow_first_beat_ml_per_min"], "ml/min")
        last = _shown(bleeding["mean_flow_last_beat_ml_per_min"], "ml/min")
        yield "flow", f"{first} in the first beat, {last} in the last"
        error = bleeding["volume_error_fraction"]
        yield "volume error", _shown(None if error is None else 100 * error, "%")
    cost = summary.get("cost") or {}
    if cost:
        wall = cost.get("wall_s", {})
        stages = ", ".join(f"{stage} {seconds:.0f}" for stage, seconds in wall.items())
        yield "time", f"{sum(wall.values()):.0f} s ({stages})"
        yield "memory", _shown(cost.get("peak_memory_mb"), "MB")


def _report_rows(report: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    if not report:
        return
    largest, when = report["temporary_cavity_ml"], report["temporary_time_ms"]
    end = _shown(report["permanent_cavity_ml"], "ml")
    collapsed = report["collapse_time_ms"]
    how = "not collapsed" if collapsed is None else f"collapsed at {_shown(collapsed, 'ms')}"
    told = f"{_shown(largest, 'ml')} at {_shown(when, 'ms')}, {end} at the end, {how}"
    yield "cavity", told if largest else "none"
    yield "energy left", _shown(report["energy_left_j"], "J")
    for note in report.get("notes", ()):
        yield "note", note


def _shown(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value:.3g} {unit}"
