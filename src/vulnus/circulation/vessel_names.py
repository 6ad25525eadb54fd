"""Readable, unique names of segments from the spellings of the published tables."""

from __future__ import annotations

from collections.abc import Sequence

_SPELLINGS = {
    "anteriortibial": "anterior tibial",
    "posteriortibial": "posterior tibial",
    "axilliary": "axillary",
    "interossea": "interosseous",
    "profundis": "profunda femoris",
    "leftsubclavian": "subclavian",
    "intercostal arteries": "intercostals",
    "peroneal": "fibular",
}
_SIDES = {"first": "left", "second": "right"}


def readable_names(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Unique names such as "left anterior tibial 2" for rows ordered from the root.

    Each row is its published name and the pair member ("first" is the left vessel). Segments of
    one vessel are numbered from proximal to distal; a vessel of a single segment has no number.
    """
    plain = [_vessel(name, pair) for name, pair in rows]
    count: dict[str, int] = {}
    numbered = []
    for vessel in plain:
        count[vessel] = count.get(vessel, 0) + 1
        numbered.append((vessel, count[vessel]))
    return [f"{vessel} {number}" if count[vessel] > 1 else vessel for vessel, number in numbered]


def _vessel(name: str, pair: str) -> str:
    """Name with side and without the word artery."""
    lowered = name.lower().strip()
    side = _SIDES.get(pair, "")
    for mark, marked_side in (("(l)", "left"), ("(r)", "right"), ("left", "left")):
        if mark in lowered and not side:
            side = marked_side
    lowered = lowered.replace("(l)", "").replace("(r)", "")
    for printed, correct in _SPELLINGS.items():
        lowered = lowered.replace(printed, correct)
    lowered = lowered.removesuffix(" artery").strip()
    return f"{side} {lowered}".strip()
