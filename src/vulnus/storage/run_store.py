"""The run directory: everything a run leaves behind, written whole or not at all.

* `RUN/scenario.toml`: the resolved scenario
* `RUN/provenance.json`: program, machine, inputs and times of every session
* `RUN/summary.json`: the numbers of the run
* `RUN/waveforms.csv`: pressures and flow of the injured artery
* `RUN/ledger.csv`: what became of the blood
* `RUN/wound/, RUN/bleed/`: frames (VTKHDF) with an index each; in `wound/` also the states by name,
  the field of damage and the report's tables
* `RUN/figures/, film.mp4`: pictures
* `RUN/checkpoints/`: what each stage handed on, and the newest state of the running one
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self, TypeVar

from vulnus import __version__
from vulnus.core.errors import StorageError
from vulnus.core.handoff import BleedLedger, BleedWaveforms, InjuryOutcome, ParticleFrame

from .checkpoint_file import FileCheckpoint
from .frame_series import FrameSeries
from .handoff_file import (
    DamagedFileError,
    OtherVersionError,
    read_handoff,
    read_note,
    write_handoff,
)
from .provenance import describe_input, describe_session, now
from .run_lock import RunLock
from .tables import LEDGER_COLUMNS, WAVEFORM_COLUMNS, as_csv, read_csv
from .whole_file import remove_parts, storage_error, write_whole
from .wound_files import write_wound_files


class StageReachedError(Exception):
    """The stage that the run was to stop after has ended; nothing is wrong."""


HandOff = TypeVar("HandOff")
Found = TypeVar("Found")


class RunStore:
    """One run directory, held by this process until `close`."""

    def __init__(self, path: Path, checkpoint_interval: float = 20.0) -> None:
        """Take hold of the directory at `path`, which must exist.

        `checkpoint_interval` [s] of wall time lies between two checkpoints of a long stage.
        """
        self.path = path
        self.checkpoint_interval = checkpoint_interval
        self.notices: list[str] = []
        """Sentences for the user about files that were damaged and passed over."""
        self.wound_frames = FrameSeries(path / "wound", "wound")
        self.bleed_frames = FrameSeries(path / "bleed", "bleed")
        self._lock = RunLock(path)
        remove_parts(path)

    @classmethod
    def create(
        cls, path: Path, scenario: str, *, resume: bool = False, checkpoint_interval: float = 20.0
    ) -> Self:
        """Begin a run of `scenario` (the resolved TOML) at `path`, or go on with it.

        A directory that holds something finished is only touched with `resume`.
        """
        _make_directory(path)
        _refuse_what_is_there(path, resume=resume)
        store = cls(path, checkpoint_interval)
        if not store.has_scenario():
            store.write_scenario(scenario)
        return store

    @classmethod
    def open(cls, path: Path) -> Self:
        """Take hold of the run that is already at `path`."""
        if not (path / "scenario.toml").is_file():
            raise StorageError(
                str(path),
                "there is no run here (no scenario.toml)" if path.exists() else "it does not exist",
                "Give the directory that `vulnus run ... -o DIRECTORY` wrote",
            )
        return cls(path)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the directory."""
        self._lock.release()

    # Scenario and provenance

    def has_scenario(self) -> bool:
        """Whether the run has begun."""
        return (self.path / "scenario.toml").is_file()

    def scenario_text(self) -> str:
        """The resolved scenario of the run."""
        path = self.path / "scenario.toml"
        try:
            return path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as trouble:
            raise StorageError(
                str(path), f"it cannot be read ({trouble})", "Restore the file, or start a new run"
            ) from trouble

    def write_scenario(self, text: str) -> None:
        """Keep the resolved scenario."""
        write_whole(self.path / "scenario.toml", text)

    def begin_session(
        self, argv: Iterable[str], *, seed: int, threads: int, inputs: Iterable[Path] = ()
    ) -> None:
        """Note in `provenance.json` that this process now writes the run."""
        session = describe_session(argv, threads)
        record = self.provenance()
        earlier = record.get("sessions", [])
        if earlier and earlier[-1]["version"] != __version__:
            self.notices.append(
                f"the run was begun with vulnus {earlier[-1]['version']}, this is {__version__}: "
                "what follows may differ from an uninterrupted run"
            )
        for former in earlier:
            if former["outcome"] == "running":  # its process had no time to say how it ended
                former["outcome"] = "killed"
        files = [describe_input(path) for path in inputs]
        if "inputs" in record and record["inputs"] != files:
            raise StorageError(
                str(self.path),
                "an input file has changed since the run was begun",
                "Restore the file, or start a new run with another -o",
            )
        begun = {"started": record.get("started", session["started"]), "seed": seed}
        # The newest session also stands at the top, where a reader looks first.
        self._write_provenance(session | begun | {"inputs": files, "sessions": [*earlier, session]})

    def end_session(self, outcome: str) -> None:
        """Note how this session ended: finished, stopped, interrupted or failed."""
        record = self.provenance()
        if not record:
            return
        ended = {"finished": now(), "outcome": outcome}
        record["sessions"][-1].update(ended)
        self._write_provenance(record | ended)

    @contextmanager
    def session(
        self, argv: Iterable[str], *, seed: int, threads: int, inputs: Iterable[Path] = ()
    ) -> Iterator[None]:
        """Note in the provenance that this process works on the run, and how that ended."""
        self.begin_session(argv, seed=seed, threads=threads, inputs=inputs)
        try:
            yield
        except BaseException as trouble:
            stopped = isinstance(trouble, StageReachedError)
            interrupted = isinstance(trouble, KeyboardInterrupt)
            with suppress(StorageError):
                self.end_session(
                    "stopped" if stopped else "interrupted" if interrupted else "failed"
                )
            raise
        self.end_session("finished")

    def provenance(self) -> dict[str, Any]:
        """The content of `provenance.json`, empty where there is none."""
        return self._read_json("provenance.json") or {}

    def is_finished(self) -> bool:
        """Whether every stage of the run has ended well."""
        return self.provenance().get("outcome") == "finished"

    # Stages

    def save_stage(self, stage: str, result: object, cost: Mapping[str, float]) -> None:
        """Keep what `stage` hands on, with its cost (name to number), and drop its checkpoint."""
        write_handoff(self._stage_path(stage), result, cost)
        self.checkpoint(stage).discard()

    def load_stage(self, stage: str, kind: type[HandOff]) -> HandOff | None:
        """What `stage` handed on; None where it has not finished or its file is damaged.

        Raises `StorageError` where another version of vulnus wrote it, and keeps the file.
        """

        def read(path: Path) -> HandOff:
            result, _ = read_handoff(path)
            if not isinstance(result, kind):
                raise OtherVersionError(f"{path} holds {type(result).__name__}")
            return result

        return self._read_stage(stage, read)

    def stage_cost(self, stage: str) -> dict[str, float] | None:
        """What `stage` cost; None where it has not finished or its file is damaged."""
        return self._read_stage(
            stage, lambda path: {name: float(text) for name, text in read_note(path).items()}
        )

    def _read_stage(self, stage: str, read: Callable[[Path], Found]) -> Found | None:
        path = self._stage_path(stage)
        try:
            return read(path)
        except FileNotFoundError:
            return None
        except OtherVersionError as trouble:
            raise StorageError(
                str(self.path),
                f"another version of vulnus wrote what its {stage} hands on ({trouble})",
                "Use that version (provenance.json names it), or run its scenario.toml anew into "
                "another directory with -o",
            ) from trouble
        except (DamagedFileError, ValueError) as trouble:
            self.notices.append(f"{trouble}; {stage} is computed again")
            path.unlink(missing_ok=True)
            return None
        except OSError as trouble:
            raise storage_error(path, trouble) from trouble

    def checkpoint(self, stage: str) -> FileCheckpoint:
        """The place for the newest state of a running `stage`."""
        path = self.path / "checkpoints" / f"{stage}.running.h5"
        return FileCheckpoint(path, self.checkpoint_interval, self.notices.append)

    def _stage_path(self, stage: str) -> Path:
        return self.path / "checkpoints" / f"{stage}.h5"

    # Results

    def save_injury(self, frame: ParticleFrame) -> None:
        """Keep a frame of the passage."""
        self.wound_frames.save(frame)

    def write_wound(self, outcome: InjuryOutcome) -> None:
        """Write the wound's states, field and tables into `wound/`."""
        write_wound_files(self.path / "wound", outcome)

    def save_bleed(self, frame: ParticleFrame) -> None:
        """Keep a frame of the bleeding."""
        self.bleed_frames.save(frame)

    def write_waveforms(self, waveforms: BleedWaveforms | None) -> None:
        """Write `waveforms.csv`; None leaves the header alone."""
        write_whole(self.path / "waveforms.csv", as_csv(waveforms, WAVEFORM_COLUMNS))

    def read_waveforms(self) -> BleedWaveforms:
        """The signals of `waveforms.csv`."""
        return BleedWaveforms(**read_csv(self.path / "waveforms.csv", WAVEFORM_COLUMNS))

    def write_ledger(self, ledger: BleedLedger | None) -> None:
        """Write `ledger.csv`; None leaves the header alone."""
        write_whole(self.path / "ledger.csv", as_csv(ledger, LEDGER_COLUMNS))

    def read_ledger(self) -> BleedLedger:
        """The volumes of `ledger.csv`."""
        return BleedLedger(**read_csv(self.path / "ledger.csv", LEDGER_COLUMNS))

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write `summary.json`."""
        write_whole(self.path / "summary.json", json.dumps(summary, indent=2) + "\n")

    def read_summary(self) -> dict[str, Any]:
        """The content of `summary.json`, empty where there is none."""
        return self._read_json("summary.json") or {}

    def _write_provenance(self, record: Mapping[str, Any]) -> None:
        write_whole(self.path / "provenance.json", json.dumps(record, indent=2) + "\n")

    def _read_json(self, name: str) -> dict[str, Any] | None:
        path = self.path / name
        try:
            content = json.loads(path.read_text())
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as trouble:
            raise StorageError(
                str(path), f"it cannot be read ({trouble})", "Delete it, then use --resume"
            ) from trouble
        return content if isinstance(content, dict) else None


def _make_directory(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError as trouble:
        raise StorageError(
            str(path), "it is a file, not a directory", "Choose another run directory with -o"
        ) from trouble
    except OSError as trouble:
        raise storage_error(path, trouble) from trouble


def _refuse_what_is_there(path: Path, *, resume: bool) -> None:
    """Raise unless `path` is empty, or holds a run to resume or with nothing finished yet."""
    try:
        names = {item.name for item in path.iterdir()}
    except OSError as trouble:
        raise storage_error(path, trouble) from trouble
    if "scenario.toml" not in names:
        if names - {".lock"}:
            raise StorageError(
                str(path),
                "the directory is not empty and is not a run",
                "Choose another run directory with -o",
            )
        return
    if resume:
        return
    if any((path / "checkpoints").glob("*.h5")) or "summary.json" in names:
        raise StorageError(
            str(path),
            "there is a run here already",
            "Add --resume to go on with it, or choose another run directory with -o",
        )
    (path / "scenario.toml").unlink()
    (path / "provenance.json").unlink(missing_ok=True)
