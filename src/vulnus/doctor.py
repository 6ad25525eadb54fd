"""What `vulnus doctor` looks at: what is installed, what is missing and how to get it."""

from __future__ import annotations

import ctypes
import importlib
import importlib.util
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

CORE_PACKAGES = {
    "numpy": "numpy",
    "scipy": "scipy",
    "SimpleITK": "SimpleITK",
    "pydicom": "pydicom",
    "pynrrd": "nrrd",
    "nibabel": "nibabel",
    "h5py": "h5py",
    "matplotlib": "matplotlib",
    "pydantic": "pydantic",
    "edt": "edt",
    "connected-components-3d": "cc3d",
}
NATIVE_ROOMS = ("geometry", "injury", "hemorrhage")
REINSTALL = "Install vulnus again: make demo, or pip install ."
RENDER = "pip install 'vulnus[render]'"
NEEDED_MEMORY_GB = 4.0
NEEDED_DISK_GB = 1.0


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing looked at; `good` is None where it is optional and missing."""

    name: str
    good: bool | None
    found: str
    advice: str = ""


def examine() -> Iterator[Finding]:
    """Look at everything, one after the other."""
    yield _python()
    for room in NATIVE_ROOMS:
        yield _native(room)
    yield _threads()
    for package, module in CORE_PACKAGES.items():
        yield _package(package, module, needed=True)
    yield _package("mitsuba", "mitsuba", needed=False)
    yield _llvm()
    yield _package("pyoidn", "pyoidn", needed=False)
    yield _film()
    yield _memory()
    yield _disk()


def _python() -> Finding:
    version = sys.version.split()[0]
    good = sys.version_info >= (3, 11)
    return Finding("Python", good, version, "" if good else "Install Python 3.11 or newer")


def _native(room: str) -> Finding:
    name = f"native code: {room}"
    try:
        module = importlib.import_module(f"vulnus.{room}._native")
    except ImportError as trouble:
        return Finding(name, good=False, found=str(trouble), advice=REINSTALL)
    return Finding(name, good=True, found=Path(str(module.__file__)).name)


def _threads() -> Finding:
    processors = len(os.sched_getaffinity(0))
    try:
        threads = ctypes.CDLL("libgomp.so.1").omp_get_max_threads()
    except OSError:
        return Finding("OpenMP", good=None, found="no libgomp found", advice="Install libgomp1")
    advice = "Unset OMP_NUM_THREADS to use all processors" if threads < processors else ""
    return Finding("OpenMP", good=True, found=f"{threads} of {processors} threads", advice=advice)


def _package(package: str, module: str, *, needed: bool) -> Finding:
    advice = REINSTALL if needed else f"{RENDER} brings it"
    missing = False if needed else None
    if importlib.util.find_spec(module) is None:
        return Finding(package, missing, "not installed", advice)
    try:
        return Finding(package, good=True, found=metadata.version(package))
    except metadata.PackageNotFoundError:
        return Finding(package, good=True, found="installed")


def _llvm() -> Finding:
    name = "LLVM for the ray tracer"
    if importlib.util.find_spec("mitsuba") is None:
        return Finding(name, good=None, found="not tried without mitsuba", advice=f"{RENDER}")
    return _try(
        name,
        _find_llvm,
        f"{RENDER} brings karellen-llvm-core; without it pictures take the slow scalar way",
    )


def _find_llvm() -> str:
    from vulnus.visualization import variant

    if not variant.llvm_works():
        raise ImportError("a 4 x 4 test picture failed")
    return str(variant.find_llvm() or "the system's own")


def _film() -> Finding:
    if importlib.util.find_spec("av") is None:
        return Finding("PyAV (film)", None, "not installed", f"{RENDER} brings it")
    return _try("PyAV (film)", _find_encoder, f"{RENDER} brings a PyAV with H.264")


def _find_encoder() -> str:
    import av

    known = [name for name in ("libx264", "h264", "mpeg4") if name in av.codecs_available]
    if not known:
        raise ImportError("no H.264 or MPEG-4 encoder")
    return f"{metadata.version('av')}, {known[0]}"


def _try(name: str, look: Callable[[], str], advice: str) -> Finding:
    try:
        return Finding(name, good=True, found=look())
    except (ImportError, OSError) as trouble:
        return Finding(name, good=None, found=str(trouble), advice=advice)


def _memory() -> Finding:
    try:
        lines = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        free = float(lines["MemAvailable"].split()[0]) * 1024 / 1e9
    except (OSError, KeyError, ValueError):
        return Finding("memory", good=None, found="unknown")
    good = True if free >= NEEDED_MEMORY_GB else None
    advice = "" if good else f"The demo is happy with {NEEDED_MEMORY_GB:g} GB; close other programs"
    return Finding("memory", good, f"{free:.1f} GB free", advice)


def _disk() -> Finding:
    here = Path.cwd()
    free = shutil.disk_usage(here).free / 1e9
    if not os.access(here, os.W_OK):
        return Finding("disk", None, f"{here} cannot be written", "Give a run directory with -o")
    good = True if free >= NEEDED_DISK_GB else None
    advice = "" if good else f"A run takes up to {NEEDED_DISK_GB:g} GB; free some or use -o"
    return Finding("disk", good, f"{free:.1f} GB free at {here}", advice)
