"""vulnus: what a penetrating injury does to a limb, from the CT scan to the blood on the floor.

The names below are the public face of the whole chain; each room has its own behind them, such as
`vulnus.circulation.build_tree`. They are loaded when they are first used.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "BleedLedger": "vulnus.core.handoff",
    "BleedOutcome": "vulnus.core.handoff",
    "Experiment": "vulnus.injury",
    "InjuredLimb": "vulnus.core.handoff",
    "LabelVolume": "vulnus.core.handoff",
    "LimbModel": "vulnus.core.handoff",
    "RunStore": "vulnus.storage",
    "Scenario": "vulnus.scenario",
    "VulnusError": "vulnus.core.errors",
    "load_scenario": "vulnus.scenario",
    "run_scenario": "vulnus.pipeline",
}

__all__ = ["__version__", *_HOMES]  # noqa: PLE0604 - the names are strings

# Waiting threads spin for some ten microseconds and then sleep: longer, and on a busy machine
# they take the time of the thread they wait for (12.5 against 3.6 s for the demo's injury with both
# cores busy); shorter, and every small loop pays for waking them. OpenMP reads this once, when the
# first native module is loaded.
if "OMP_WAIT_POLICY" not in os.environ:
    os.environ.setdefault("GOMP_SPINCOUNT", "10000")


def __getattr__(name: str) -> Any:
    """Import a public name from the room that owns it, so that `import vulnus` is quick."""
    if name not in _HOMES:
        raise AttributeError(f"module 'vulnus' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
