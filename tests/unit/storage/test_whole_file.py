"""A file is the old one or the new one, never a part, whatever the disk does."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from vulnus.core.errors import StorageError
from vulnus.storage import replaced_whole, write_whole


def test_content_arrives_and_nothing_else_is_left(tmp_path: Path) -> None:
    write_whole(tmp_path / "new" / "a.txt", "höhe")
    assert (tmp_path / "new" / "a.txt").read_text(encoding="utf-8") == "höhe"
    assert [item.name for item in (tmp_path / "new").iterdir()] == ["a.txt"]


@pytest.mark.parametrize("call", ["replace", "fsync"])
@pytest.mark.parametrize(
    ("number", "words"),
    [(errno.ENOSPC, "disk is full"), (errno.EACCES, "not permitted"), (errno.EIO, "input/output")],
)
def test_trouble_keeps_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, number: int, words: str
) -> None:
    path = tmp_path / "a.txt"
    write_whole(path, b"old")

    def fail(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, call, fail)
    with pytest.raises(StorageError, match=words) as caught:
        write_whole(path, b"new")
    monkeypatch.undo()
    assert str(path) in caught.value.subject
    assert "--resume" in caught.value.advice
    assert path.read_bytes() == b"old"
    assert [item.name for item in tmp_path.iterdir()] == ["a.txt"]


def test_an_interrupt_keeps_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    write_whole(path, b"old")
    parts: list[Path] = []

    def stop() -> None:
        with replaced_whole(path) as part:
            part.write_bytes(b"half of the new")
            parts.append(part)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stop()
    assert path.read_bytes() == b"old"
    assert parts[0].suffix == ".mp4"
    assert not parts[0].exists()


def test_a_limit_on_the_file_size_is_told(tmp_path: Path) -> None:
    """The system itself refuses: RLIMIT_FSIZE stands for a full disk."""
    program = (
        "import resource, pathlib, sys\n"
        "from vulnus.storage import write_whole\n"
        "from vulnus.core.errors import StorageError\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n    write_whole(pathlib.Path(sys.argv[1]), bytes(5000))\n"
        "except StorageError as error:\n    print(error.problem)\n"
    )
    path = tmp_path / "big"
    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "file size" in done.stdout
    assert list(tmp_path.iterdir()) == []
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 1000  # of this process, untouched
    assert signal.getsignal(signal.SIGXFSZ) == signal.SIG_IGN  # why Python sees an error at all
