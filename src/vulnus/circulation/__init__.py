"""The systemic arterial tree and the branch where it bleeds (paper section 2.3)."""

from __future__ import annotations

from .cycle_summary import CycleSummary, summarise_cycle
from .injury_branch import BeatSignals, InjuryPort
from .parameters import CirculationParameters
from .tree import ArterialTree, build_tree, open_injury_port

__all__ = [
    "ArterialTree",
    "BeatSignals",
    "CirculationParameters",
    "CycleSummary",
    "InjuryPort",
    "build_tree",
    "open_injury_port",
    "summarise_cycle",
]
