"""The newest checkpoint of a long stage, as one checked file in the run directory."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from vulnus import __version__
from vulnus.core.checkpoint import CheckpointData
from vulnus.core.errors import StorageError

from .handoff_file import DamagedFileError, read_handoff, write_handoff


class FileCheckpoint:
    """A `core.checkpoint.Checkpoint` in a file; also counts the stage's wall time over sessions.

    `interval` [s] of wall time between two saves; `notice` receives a sentence where a damaged
    checkpoint is passed over.
    """

    def __init__(self, path: Path | str, interval: float, notice: Callable[[str], None]) -> None:
        if not isinstance(path, Path | str):
            raise StorageError("checkpoint path", f"is {path!r}", "Give the path of a file.")
        self.path = Path(path)
        self.interval = interval
        self._notice = notice
        self._started = self._saved = time.monotonic()
        self._earlier = 0.0

    @property
    def wall(self) -> float:
        """Wall time [s] spent on the stage, in the sessions that led to its present state."""
        return self._earlier + time.monotonic() - self._started

    def load(self) -> CheckpointData | None:
        """The newest checkpoint; None where there is none or it is damaged."""
        try:
            data, note = read_handoff(self.path)
            if note["version"] != __version__:
                raise DamagedFileError(f"{self.path} is of vulnus {note['version']}")
            self._earlier = float(note["wall"])
        except FileNotFoundError:
            return None
        except (DamagedFileError, KeyError, OSError) as trouble:
            self._notice(f"{trouble}; the stage starts anew")
            self.discard()
            return None
        self._saved = time.monotonic()
        return cast(dict[str, Any], data)

    def save(self, data: CheckpointData) -> None:
        """Replace the checkpoint, whole or not at all."""
        write_handoff(self.path, data, {"wall": self.wall, "version": __version__})
        self._saved = time.monotonic()

    def due(self) -> bool:
        """Whether `interval` has passed since the last save."""
        return time.monotonic() - self._saved >= self.interval

    def discard(self) -> None:
        """Forget the checkpoint: the stage is finished, or the file is of no use."""
        self.path.unlink(missing_ok=True)
