"""The arteries of a limb after a shot: where their walls are destroyed, and what that makes them.

Thresholds (`InjuryParameters`): an artery is lacerated where at least `laceration_threshold` of its
circumference is gone, transected from `damage_threshold` on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.handoff import (
    ArteryCentreline,
    InjuredArtery,
    Tissue,
    VesselInjury,
    VesselReport,
)

from ..parameters import InjuryParameters
from ..wound import artery_wall as wound
from .record import Snapshot
from .setup import ShotSetup

TUBES = ("sphere", "cylinder", "ogive")
"""Shapes that sweep a tube of their diameter as long as they fly straight."""


@dataclass(frozen=True, slots=True, eq=False)
class ArteryAfterShot:
    """One artery's stations (m,): where they are now, and what happened to the wall there."""

    artery: ArteryCentreline
    stations: wound.CentrelineStations
    deformed: FloatArray
    approach: FloatArray
    stretch: FloatArray
    destroyed_share: FloatArray

    def injuries(self, parameters: InjuryParameters) -> list[VesselInjury]:
        """Its transections and lacerations."""
        limit = wound.WallThresholds(
            lacerated=parameters.laceration_threshold, transected=parameters.damage_threshold
        )
        return wound.find_injuries(self.stations, self.deformed, self.destroyed_share, limit)


def injured_arteries(
    setup: ShotSetup, snapshot: Snapshot, paths: Sequence[FloatArray], damage: AnyArray
) -> tuple[tuple[InjuredArtery, ...], tuple[VesselInjury, ...]]:
    """The arteries as they lie in the snapshot, and their injuries, worst first.

    `paths` are those of the projectiles' middles, `damage` (n,) that of the limb's points.
    """
    after = list(_arteries_after(setup, snapshot, paths, damage))
    found = [injury for artery in after for injury in artery.injuries(setup.parameters)]
    injured = tuple(
        wound.injured_artery(each.artery, each.stations, each.deformed, each.destroyed_share)
        for each in after
    )
    return injured, wound.worst_first(found)


def artery_report(
    setup: ShotSetup, snapshot: Snapshot, paths: Sequence[FloatArray], damage: AnyArray
) -> list[VesselReport]:
    """Every artery of the limb, intact or not."""
    reports = []
    for each in _arteries_after(setup, snapshot, paths, damage):
        injuries = wound.worst_first(each.injuries(setup.parameters))
        reports.append(
            VesselReport(
                artery=each.stations.name,
                kind=injuries[0].kind if injuries else "intact",
                destroyed_share=float(each.destroyed_share.max(initial=0.0)),
                stretch=float(each.stretch.max(initial=1.0)),
                nearest_distance=float(np.min(each.approach - each.stations.radius)),
                hole_area=float(sum(injury.hole_area for injury in injuries)),
                injury_count=len(injuries),
            )
        )
    return reports


def _arteries_after(
    setup: ShotSetup, snapshot: Snapshot, paths: Sequence[FloatArray], damage: AnyArray
) -> Iterator[ArteryAfterShot]:
    limb, parameters = setup.limb, setup.parameters
    wall = np.flatnonzero(limb.tissue == Tissue.ARTERY)
    parts = zip(limb.arteries, setup.stations, setup.tracer_inside, setup.tracer_range, strict=True)
    for artery, stations, inside, tracers in parts:
        deformed = stations.points.copy()
        deformed[inside] = snapshot.tracers[tracers]
        approach = np.full(len(deformed), np.inf)
        approach[inside] = snapshot.approach[tracers]
        for projectile, path in zip(setup.projectiles, paths, strict=True):
            if projectile.shape in TUBES:
                swept = wound.swept_approach(stations, path, 0.5 * projectile.diameter)
                approach = np.minimum(approach, swept)
        stretch = _stretch_of(inside, snapshot.stretch, tracers)
        yield ArteryAfterShot(
            artery=artery,
            stations=stations,
            deformed=deformed,
            approach=approach,
            stretch=stretch,
            destroyed_share=wound.destroyed_wall_share(
                stations,
                stretch=stretch,
                approach=approach,
                wall_damage=wound.wall_point_damage(
                    stations, limb.position[wall], damage[wall], parameters.grid_spacing
                ),
                failure_stretch=parameters.artery_failure_stretch,
            ),
        )


def _stretch_of(inside: AnyArray, stretch: FloatArray, tracers: slice) -> FloatArray:
    """Largest stretch (m - 1,) of the pieces between an artery's stations; 1 outside the window."""
    pieces = np.ones(max(len(inside) - 1, 0))
    numbers = np.full(len(inside), -1)
    numbers[inside] = np.arange(tracers.start, tracers.stop)
    joined = (numbers[:-1] >= 0) & (numbers[1:] == numbers[:-1] + 1)
    pieces[joined] = stretch[numbers[:-1][joined]]
    return pieces
