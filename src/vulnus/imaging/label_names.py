"""Which tissue a segment's name, terminology code or label value stands for."""

from __future__ import annotations

import re

from vulnus.core.handoff import Tissue

FIVE_LABELS = {
    0: Tissue.AIR,
    1: Tissue.SKIN,
    2: Tissue.MUSCLE,
    3: Tissue.BONE,
    4: Tissue.ARTERY,
}
"""The five-label convention of volumes without names: air, skin, soft tissue, bone, artery."""

PRIORITY = (
    Tissue.FAT,
    Tissue.MUSCLE,
    Tissue.SKIN,
    Tissue.BONE,
    Tissue.CANCELLOUS,
    Tissue.MARROW,
    Tissue.ARTERY,
)
"""Where segments overlap, the later one stays (IMAGING: artery > bone > skin > soft)."""

_SNOMED = {
    "39937001": Tissue.SKIN,
    "272673000": Tissue.BONE,
    "12611008": Tissue.BONE,
    "87342007": Tissue.BONE,
    "67453005": Tissue.BONE,
    "80144004": Tissue.BONE,
    "87784001": Tissue.MUSCLE,
    "71616004": Tissue.MUSCLE,
    "55603005": Tissue.FAT,
    "51114001": Tissue.ARTERY,
    "43899006": Tissue.ARTERY,
    "68053000": Tissue.ARTERY,
    "13363002": Tissue.ARTERY,
    "8821006": Tissue.ARTERY,
}


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_WORDS: tuple[tuple[Tissue, frozenset[str]], ...] = (
    (Tissue.AIR, _words("air background exterior outside none")),
    (
        Tissue.MUSCLE,
        _words(
            "muscle muscles cartilage ligament ligaments tendon tendons nerve nerves vein veins "
            "meniscus fascia membrane"
        ),
    ),
    (Tissue.ARTERY, _words("artery arteries arterial vessel lumen")),
    (Tissue.SKIN, _words("skin dermis cutis epidermis")),
    (Tissue.MARROW, _words("marrow medullary")),
    (Tissue.CANCELLOUS, _words("cancellous trabecular spongiosa spongy")),
    (
        Tissue.BONE,
        _words(
            "bone bones cortical cortex osseous tibia fibula femur patella talus calcaneus "
            "calcaneous navicular cuboid cuneiform tarsal tarsals metatarsal metatarsals phalanx "
            "phalanges"
        ),
    ),
    (Tissue.FAT, _words("fat adipose subcutaneous subcutis")),
    (
        Tissue.MUSCLE,
        _words(
            "soft tissue musculature gastrocnemius soleus tibialis fibularis peroneus popliteus "
            "plantaris extensor flexor"
        ),
    ),
)
"""Words of a name in the order in which they decide; the first hit counts."""


def tissue_of_name(name: str) -> Tissue | None:
    """The tissue that a name speaks of, or None; "muscle_TibialisAnterior" is muscle."""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    words = set(re.split(r"[^a-z]+", parted.lower()))
    for tissue, known in _WORDS:
        if words & known:
            return tissue
    return None


def tissue_of_tags(tags: str) -> Tissue | None:
    """The tissue of a Slicer terminology entry's SNOMED CT codes, type before category."""
    match = re.search(r"TerminologyEntry:([^|]*)", tags)
    if match is None:
        return None
    fields = match.group(1).split("~")
    for part in (fields[2:3], fields[1:2]):
        for text in part:
            code = text.split("^")
            if len(code) > 1 and code[0] in ("SCT", "SRT") and code[1] in _SNOMED:
                return _SNOMED[code[1]]
    return None
