"""Say in one line what is missing before `make` starts: Python's version, headers, a compiler."""

from __future__ import annotations

import importlib.util
import pathlib
import shutil
import sys
import sysconfig


def missing_pieces() -> list[str]:
    """What stands in the way of a build, each with the way to get it; empty if nothing."""
    missing = []
    if sys.version_info < (3, 11):  # noqa: UP036 - this file must run on an old Python to say so
        version = ".".join(map(str, sys.version_info[:3]))
        missing.append(f"Python is {version}, 3.11 or newer is needed: make PYTHON=python3.12")
    if importlib.util.find_spec("ensurepip") is None:
        missing.append("this Python cannot make environments: on Debian, apt install python3-venv")
    header = pathlib.Path(sysconfig.get_paths()["include"], "Python.h")
    if not header.exists():
        missing.append(f"no {header}: on Debian, apt install python3-dev")
    if not any(shutil.which(name) for name in ("c++", "g++", "clang++")):
        missing.append("no C++ compiler: on Debian, apt install g++")
    return missing


if __name__ == "__main__":
    for line in (pieces := missing_pieces()):
        print(f"make: {line}", file=sys.stderr)
    sys.exit(bool(pieces))
