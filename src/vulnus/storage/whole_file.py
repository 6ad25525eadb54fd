"""Files that are written whole or not at all: a temporary neighbour, fsync, then a rename.

A reader, or a run that goes on after a power cut, sees the old file or the new one, never a part.
"""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

from vulnus.core.errors import StorageError

PART_PREFIX = ".part-"
"""Begins the name of a file that is not finished; a later session removes such files."""

_PROBLEMS = {
    errno.ENOSPC: ("the disk is full", "Free space on it"),
    errno.EDQUOT: ("the disk quota is used up", "Free space in your quota"),
    errno.EFBIG: ("the file would pass the allowed file size", "Raise the limit (ulimit -f)"),
    errno.EACCES: ("writing is not permitted", "Change its permissions or choose another place"),
    errno.EPERM: ("writing is not permitted", "Change its permissions or choose another place"),
    errno.EROFS: ("the file system is read-only", "Choose another place"),
    errno.ENOTDIR: ("a part of the path is a file, not a directory", "Choose another place"),
    errno.EISDIR: ("it is a directory", "Remove it or choose another place"),
    errno.EIO: ("the disk reports an input/output error", "Check the disk or choose another place"),
}


def storage_error(path: Path, trouble: OSError) -> StorageError:
    """The error to raise for `trouble` at `path`, with what the user can do about it."""
    problem, advice = _PROBLEMS.get(
        trouble.errno or 0,
        (f"it cannot be used ({trouble.strerror or trouble})", "Check the path and the disk"),
    )
    return StorageError(
        str(path),
        problem,
        f"{advice}; what was finished is kept, and the same command with --resume goes on from it",
    )


@contextlib.contextmanager
def replaced_whole(path: Path) -> Iterator[Path]:
    """A temporary path to write to, with the same suffix, which becomes `path` at the end.

    Where the block raises, `path` stays as it was and the temporary file is removed.
    """
    part = path.with_name(PART_PREFIX + path.name)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        _flush_to_disk(part)
        os.replace(part, path)
        _flush_to_disk(path.parent)
    except OSError as trouble:
        raise storage_error(path, trouble) from trouble
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)


def write_whole(path: Path, content: bytes | str) -> None:
    """Make `path` hold `content`, atomically; text is written as UTF-8."""
    data = content.encode() if isinstance(content, str) else content
    with replaced_whole(path) as part, part.open("wb") as stream:
        stream.write(data)


def remove_parts(directory: Path) -> None:
    """Remove what a killed session left unfinished below `directory`."""
    for part in directory.rglob(PART_PREFIX + "*"):
        with contextlib.suppress(OSError):
            part.unlink()


def _flush_to_disk(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
