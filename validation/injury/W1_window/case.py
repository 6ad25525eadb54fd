"""W1: a window of the leg gives the tract of the whole leg."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vulnus.anatomy import AnatomyParameters, build_limb
from vulnus.core.handoff import InjuryOutcome, LimbModel
from vulnus.core.progress import Progress
from vulnus.imaging import ImagingParameters, load_labels
from vulnus.injury import AimParameters, InjuryParameters, ProjectileParameters, shoot
from vulnus.validation import CaseReport, Comparison, Curve, Panel

SOURCE = "the whole leg's run; issue 3, point 6"
SHOT = InjuryParameters(
    projectile=ProjectileParameters(diameter=0.011, speed=400.0, motion="dynamic", mass=0.012),
    aim=AimParameters(artery="anterior_tibial", fraction=0.45, azimuth=np.radians(15.0)),
    grid_spacing=0.005,
    frame_interval=1e-4,
)
WINDOW = 0.12  # the default
TOLERANCE, SKIN_TOLERANCE = 0.05, 0.15  # the issue's; a hole holds some dozen points of skin
DURATION, QUICK_DURATION = 2e-3, 5e-4


def run(quick: bool, progress: Progress) -> CaseReport:
    """Both runs; quick: to half a millisecond."""
    limb = build_limb(load_labels(ImagingParameters()), AnatomyParameters(particle_spacing=0.003))
    duration = QUICK_DURATION if quick else DURATION
    whole, part = (shot(limb, length, duration, progress) for length in (None, WINDOW))
    comparisons = [
        Comparison.within(
            name, found, reference=reference, unit=unit, source=SOURCE, relative=TOLERANCE
        )
        for (name, unit, reference), (_, _, found) in zip(
            measured(whole), measured(part), strict=True
        )
    ]
    comparisons += [
        Comparison.within(
            name, found, reference=reference, unit="mm²", source=SOURCE, relative=SKIN_TOLERANCE
        )
        for (name, reference), (_, found) in zip(skin(whole), skin(part), strict=True)
    ]
    return CaseReport(comparisons=tuple(comparisons), panels=(radii(whole, part),))


def shot(
    limb: LimbModel, window: float | None, duration: float, progress: Progress
) -> InjuryOutcome:
    """The injury with this much of the limb [m]."""
    return shoot(limb, replace(SHOT, window_length=window, duration=duration), progress=progress)


def measured(outcome: InjuryOutcome) -> list[tuple[str, str, float]]:
    """Name, unit and value of what is compared."""
    tract, limb = outcome.report.projectiles[0].tract, outcome.permanent
    destroyed = limb.volume[limb.damage >= SHOT.damage_threshold].sum()
    return [
        ("destroyed radius", "mm", 1e3 * float(np.mean(tract.destroyed_radius))),
        ("cavity's radius", "mm", 1e3 * float(np.mean(tract.temporary_radius))),
        ("destroyed volume", "ml", 1e6 * float(destroyed)),
    ]


def skin(outcome: InjuryOutcome) -> list[tuple[str, float]]:
    """Name and area [mm²] of the destroyed skin."""
    (ball,) = outcome.report.projectiles
    found = [("destroyed skin, entry", 1e6 * ball.entry.destroyed_area)]
    if ball.exit is not None:
        found.append(("destroyed skin, exit", 1e6 * ball.exit.destroyed_area))
    return found


def radii(whole: InjuryOutcome, part: InjuryOutcome) -> Panel:
    """The tract of both."""
    curves = []
    for outcome, label, kind in ((whole, "whole leg", "reference"), (part, "window", "result")):
        tract = outcome.report.projectiles[0].tract
        arc = 1e3 * tract.arc_length
        destroyed, cavity = 1e3 * tract.destroyed_radius, 1e3 * tract.temporary_radius
        curves.append(Curve(x=arc, y=destroyed, label=f"destroyed, {label}", kind=kind))
        curves.append(Curve(x=arc, y=cavity, label=f"cavity, {label}", kind=kind))
    return Panel(
        title="radius along the tract", x="path / mm", y="radius / mm", curves=tuple(curves)
    )
