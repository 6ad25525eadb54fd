"""How fast does a cut anterior tibial artery bleed, and what does the wound's pressure change?

Cuts the artery at several places of the default tree and lets it bleed into the open and against
the pressure of a filled wound.
"""

from __future__ import annotations

from vulnus.circulation import CirculationParameters, build_tree
from vulnus.core.units import MILLILITRE_PER_MINUTE, MILLIMETRE_OF_MERCURY


def main() -> dict[float, list[float]]:
    """Mean bleeding rate [ml/min] at 0, 30 and 60 mmHg around the wound, by place of the cut."""
    tree = build_tree(CirculationParameters(), side="left")
    rates = {}
    for fraction in (0.1, 0.5, 0.9):
        segment, x = tree.locate("anterior_tibial", arc_fraction=fraction)
        port = tree.injury_port(segment, x, lumen_radius=1.3e-3)
        beats = [port.bleed(mmhg * MILLIMETRE_OF_MERCURY) for mmhg in (0.0, 30.0, 60.0)]
        rates[fraction] = [beat.mean_flow / MILLILITRE_PER_MINUTE for beat in beats]
    return rates


if __name__ == "__main__":
    for place, flows in main().items():
        print(f"cut at {place:.0%}: " + ", ".join(f"{flow:.0f}" for flow in flows) + " ml/min")
        assert flows[0] > flows[1] > flows[2], "a fuller wound bleeds less"
