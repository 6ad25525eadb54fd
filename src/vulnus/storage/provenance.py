"""Where a run comes from: program, machine, times; nothing here changes a result."""

from __future__ import annotations

import hashlib
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from vulnus import __version__

_PACKAGES = ("numpy", "scipy", "SimpleITK", "h5py", "pydantic", "mitsuba", "pyoidn", "av")


def now() -> str:
    """The present time, UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def describe_session(argv: Iterable[str], threads: int) -> dict[str, Any]:
    """What `provenance.json` says about the process that writes a run now."""
    return {
        "version": __version__,
        "commit": git_commit(),
        "started": now(),
        "finished": None,
        "outcome": "running",
        "argv": list(argv),
        "host": socket.gethostname(),
        "process": os.getpid(),
        "platform": platform.platform(),
        "processor": _processor(),
        "cpu_count": os.cpu_count(),
        "threads": threads,
        "python": sys.version.split()[0],
        "packages": _package_versions(),
    }


def describe_input(path: Path) -> Mapping[str, str | int]:
    """Path, size and SHA-256 of a file that a run reads."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return {"path": str(path), "bytes": path.stat().st_size, "sha256": digest.hexdigest()}


def git_commit() -> str | None:
    """Commit of the checkout that this package lies in, with "+changes" where it has some."""
    here = Path(__file__).resolve().parent

    def git(*words: str) -> str:
        command = ["git", "-C", str(here), *words]
        done = subprocess.run(command, capture_output=True, text=True, timeout=5, check=True)
        return done.stdout.strip()

    try:
        tracked = git("ls-files", "--", str(Path(__file__).name))
        if not tracked:
            return None
        changed = git("status", "--porcelain", "--untracked-files=no")
        return git("rev-parse", "HEAD") + ("+changes" if changed else "")
    except (OSError, subprocess.SubprocessError):
        return None


def _package_versions() -> dict[str, str]:
    versions = {}
    for name in _PACKAGES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return versions


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
