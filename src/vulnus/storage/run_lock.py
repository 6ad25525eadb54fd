"""A lock on a run directory, so that two processes never write one run."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

from vulnus.core.errors import StorageError

from .whole_file import storage_error


class RunLock:
    """Held by one process at a time; the system lets go of it when the process dies."""

    def __init__(self, directory: Path) -> None:
        self._path = directory / ".lock"
        try:
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as trouble:
            raise storage_error(self._path, trouble) from trouble
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as trouble:
            holder = os.pread(self._file, 32, 0).decode(errors="replace").strip()
            os.close(self._file)
            raise StorageError(
                str(directory),
                f"another vulnus (process {holder or 'unknown'}) is writing this run",
                "Wait until it ends, stop it, or choose another run directory with -o",
            ) from trouble
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, f"{os.getpid()}\n".encode(), 0)

    def release(self) -> None:
        """Let another process have the run; releasing twice changes nothing."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1
