"""Where the arteries of the limb lie in the tree: chains of segments from proximal to distal."""

from __future__ import annotations

import math

import numpy as np

from vulnus.core.errors import CirculationError

from .segments import SegmentTable

LIMB_ARTERIES = {
    "popliteal": "popliteal",
    "anterior_tibial": "anterior tibial",
    "posterior_tibial": "posterior tibial",
    "fibular": "fibular",
}
"""Names of the limb's arteries and what their segments are called in the tree."""


def locate_in_chain(
    table: SegmentTable,
    side: str,
    artery: str,
    arc_fraction: float | None,
    arc_length: float | None,
) -> tuple[int, float]:
    """Segment id and position [m] of a place on an artery; see `ArterialTree.locate`."""
    rows = chain_rows(table, side, artery)
    ends = np.cumsum(table.length[rows])
    total = float(ends[-1])
    if arc_fraction is not None:
        place, name, limit = arc_fraction * total, "arc_fraction", 1.0
    elif arc_length is not None:
        place, name, limit = arc_length, "arc_length", total
    else:
        raise CirculationError(
            f"place on {artery}", "is not given", "Pass arc_fraction or arc_length"
        )
    if not (math.isfinite(place) and -1e-9 <= place <= total * (1.0 + 1e-9)):
        value = arc_fraction if arc_fraction is not None else arc_length
        raise CirculationError(
            f"{name} of {artery}",
            f"is {value:g}, must lie in [0, {limit:g}]",
            "Count from the artery's proximal end",
        )
    k = min(int(np.searchsorted(ends, place, side="left")), len(rows) - 1)
    start = float(ends[k]) - float(table.length[rows[k]])
    return int(table.ids[rows[k]]), min(max(place - start, 0.0), float(table.length[rows[k]]))


def chain_rows(table: SegmentTable, side: str, artery: str) -> list[int]:
    """Rows of an artery's segments, proximal first."""
    vessel = f"{side} {LIMB_ARTERIES.get(artery, artery)}"
    rows = [
        row
        for row, name in enumerate(table.names)
        if name == vessel or name.rstrip("0123456789").rstrip() == vessel
    ]
    if artery not in LIMB_ARTERIES or not rows:
        advice = (
            'Build the tree with severed="fibular", which adds that branch'
            if artery == "fibular"
            else f"Known arteries of the limb: {', '.join(LIMB_ARTERIES)}"
        )
        raise CirculationError(f'artery "{artery}"', f"is not in this tree on the {side}", advice)
    return rows
