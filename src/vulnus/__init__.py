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

# Waiting threads sleep instead of spinning: on a shared machine a spinning thread takes the time
# of the one it waits for (11.6 against 7 million particle-steps/s of the injury solver with both
# cores busy). OpenMP reads this once, when the first native module is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")


def __getattr__(name: str) -> Any:
    """Import a public name from the room that owns it, so that `import vulnus` is quick."""
    if name not in _HOMES:
        raise AttributeError(f"module 'vulnus' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
