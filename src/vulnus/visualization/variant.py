"""Which Mitsuba variant runs here, found without risking this process.

The llvm variants load a shared LLVM at run time. An LLVM that lacks an instruction aborts the
whole process with no Python exception (Debian's 14 and 15 do), so a child process tries first.
"""

from __future__ import annotations

import functools
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from ..core.errors import RenderError
from .parameters import Renderer

ADVICE = "Install the renderer with: pip install 'vulnus[render]'"
_PROBE_SECONDS = 60.0  # chosen: twenty times what the probe takes on an idle core
_PROBE = """
import mitsuba as mi
mi.set_variant("llvm_ad_rgb")
import drjit as dr
film = {"type": "hdrfilm", "width": 4, "height": 4}
scene = mi.load_dict({"type": "scene", "integrator": {"type": "direct"},
    "light": {"type": "constant"}, "ball": {"type": "sphere", "center": [0, 0, 5]},
    "sensor": {"type": "perspective", "film": film}})
assert float(dr.sum(mi.render(scene, spp=1).array)[0]) > 0.0
"""


def find_llvm() -> Path | None:
    """The LLVM library that the package karellen-llvm-core keeps under `<prefix>/lib`, or None."""
    for prefix in dict.fromkeys([sys.prefix, sys.base_prefix, sys.exec_prefix]):
        found = sorted(Path(prefix, "lib").glob("libLLVM*.so*"))
        if found:
            return found[0]
    return None


def _environment() -> dict[str, str]:
    environment = dict(os.environ)
    library = find_llvm()
    if library is not None:
        environment.setdefault("DRJIT_LIBLLVM_PATH", str(library))
    return environment


@functools.cache
def llvm_works() -> bool:
    """Whether a child process can render a 4 by 4 picture with `llvm_ad_rgb`."""
    command = [sys.executable, "-c", _PROBE]
    try:
        probe = subprocess.run(
            command, env=_environment(), capture_output=True, timeout=_PROBE_SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return probe.returncode == 0


def choose_variant(renderer: Renderer) -> str:
    """The Mitsuba variant for the parameter `renderer`.

    Raises `RenderError` where Mitsuba is not installed, or where `llvm` is asked for and fails.
    """
    if importlib.util.find_spec("mitsuba") is None:
        raise RenderError("mitsuba", "the ray tracer is not installed", ADVICE)
    if renderer == "scalar":
        return "scalar_rgb"
    if llvm_works():
        return "llvm_ad_rgb"
    if renderer == "llvm":
        problem = "no usable LLVM library was found (DRJIT_LIBLLVM_PATH, libLLVM*.so)"
        raise RenderError("visualization.renderer = 'llvm'", problem, ADVICE + " or use 'auto'")
    return "scalar_rgb"


def load_mitsuba(renderer: Renderer) -> Any:
    """The module `mitsuba` with its variant set, quiet on the console.

    Where somebody imported Mitsuba before, it has taken whatever LLVM the system has, which may
    abort the process: then the scalar variant draws.
    """
    variant = choose_variant(renderer)
    environment = _environment()
    chosen = environment.get("DRJIT_LIBLLVM_PATH") == os.environ.get("DRJIT_LIBLLVM_PATH")
    if "drjit" in sys.modules and not chosen:
        variant = "scalar_rgb"
    else:
        os.environ.update(environment)
    try:
        import mitsuba
    except ImportError as error:
        raise RenderError("mitsuba", f"the ray tracer does not load ({error})", ADVICE) from error
    mitsuba.set_variant(variant)
    _use_threads()
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


def _use_threads() -> None:
    """Give the tracer as many threads as the native loops have; pictures do not depend on it."""
    count = os.environ.get("OMP_NUM_THREADS", "0")
    if count.isdecimal() and int(count) > 0:
        import drjit

        drjit.set_thread_count(int(count))
