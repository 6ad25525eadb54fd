"""The numbers of a run, in the units that a reader expects, for `summary.json`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from vulnus.core.handoff import (
    BleedOutcome,
    InjuredLimb,
    InjuryOutcome,
    ProjectileHoles,
    VesselInjury,
)
from vulnus.core.units import (
    MILLILITRE,
    MILLILITRE_PER_MINUTE,
    MILLIMETRE,
    MILLIMETRE_OF_MERCURY,
    MILLISECOND,
    SQUARE_MILLIMETRE,
)

from .wound_files import report_numbers

MEGABYTE = 1e6


def summarise(
    injury: InjuryOutcome,
    bleeding: BleedOutcome | None,
    cost: Mapping[str, Mapping[str, float]],
) -> dict[str, Any]:
    """`wound`, `bleeding` and `cost`; null where a value is not known (yet).

    Of the wound's states, the one that bleeds stands at the top of `wound`, each in `states`.
    Where nothing was cut, `severed_segment` is null and nothing bled: volumes and flows are 0.

    `cost` maps a stage to its `wall` [s] and `peak_memory` [byte].
    """
    wound = injury.wound
    return {
        "wound": {
            **_wound(wound),
            "state": injury.bleeds_from if injury.bleeds_from in injury.states else "permanent",
            "states": {name: _state(limb) for name, limb in injury.states.items()},
            "report": report_numbers(injury.report),
        },
        "bleeding": _bleeding(bleeding, bled=bool(wound.injuries)),
        "cost": {
            "wall_s": {stage: round(item["wall"], 3) for stage, item in cost.items()},
            "peak_memory_mb": round(
                max((item["peak_memory"] for item in cost.values()), default=0.0) / MEGABYTE, 1
            ),
            "injury_particle_steps_per_s": _finite(wound.particle_steps_per_second),
            "hemorrhage_particle_steps_per_s": (
                None if bleeding is None else _finite(bleeding.particle_steps_per_second)
            ),
        },
    }


def _wound(wound: InjuredLimb) -> dict[str, Any]:
    return {
        "severed_segment": wound.severed_segment,
        "entry_area_mm2": _finite(wound.entry_area / SQUARE_MILLIMETRE),
        "exit_area_mm2": _area(wound.exit_area),
        "holes": [_holes(made) for made in wound.holes],
        "injuries": [_injury(injury) for injury in wound.injuries],
        "entry_point_mm": [x / MILLIMETRE for x in wound.shot.entry_point],
        "exit_point_mm": [x / MILLIMETRE for x in wound.shot.exit_point],
        "projectile_diameter_mm": wound.shot.diameter / MILLIMETRE,
        "projectile_speed_m_per_s": wound.shot.speed,
        "side": wound.side,
        "particles": len(wound.position),
        "steps": wound.steps,
    }


def _state(limb: InjuredLimb) -> dict[str, Any]:
    return {
        "time_ms": limb.time / MILLISECOND,
        "steps": limb.steps,
        "entry_area_mm2": _area(limb.entry_area),
        "exit_area_mm2": _area(limb.exit_area),
    }


def _holes(made: ProjectileHoles) -> dict[str, Any]:
    out = made.exit_point
    return {
        "entry_point_mm": [x / MILLIMETRE for x in made.entry_point],
        "entry_area_mm2": _area(made.entry_area),
        "exit_point_mm": None if out is None else [x / MILLIMETRE for x in out],
        "exit_area_mm2": _area(made.exit_area),
    }


def _area(area: float | None) -> float | None:
    return None if area is None else _finite(area / SQUARE_MILLIMETRE)


def _injury(injury: VesselInjury) -> dict[str, Any]:
    return {
        "artery": injury.artery,
        "kind": injury.kind,
        "hole_area_mm2": injury.hole_area / SQUARE_MILLIMETRE,
        "arc_length_mm": injury.arc_length / MILLIMETRE,
        "arc_fraction": injury.arc_fraction,
        "gap_mm": injury.gap / MILLIMETRE,
        "lumen_radius_mm": injury.lumen_radius / MILLIMETRE,
        "position_mm": [x / MILLIMETRE for x in injury.position],
        "stumps_mm": [
            [x / MILLIMETRE for x in stump]
            for stump in (injury.position_proximal, injury.position_distal)
        ],
        "stump_axes": [list(injury.axis_proximal), list(injury.axis_distal)],
    }


def _bleeding(outcome: BleedOutcome | None, *, bled: bool) -> dict[str, Any]:
    keys = (
        "duration_s",
        "injected_ml",
        "in_limb_ml",
        "out_of_limb_ml",
        "removed_ml",
        "pending_ml",
        "mean_flow_first_beat_ml_per_min",
        "mean_flow_last_beat_ml_per_min",
        "mean_pressure_artery_mmhg",
        "mean_pressure_injury_mmhg",
        "beat_period_s",
        "volume_error_fraction",
        "barrier_crossings",
        "skin_open_area_mm2",
        "skin_sparse_area_mm2",
        "particles",
        "steps",
    )
    if outcome is None:
        unknown = keys if bled else ("mean_pressure_artery_mmhg", "mean_pressure_injury_mmhg")
        return {key: None if key in unknown else 0 for key in keys}
    ledger, waves, beats = outcome.ledger, outcome.waveforms, outcome.mean_flow_per_beat
    volumes = (ledger.injected, ledger.in_limb, ledger.out_of_limb, ledger.removed, ledger.pending)
    values = (
        float(ledger.time[-1]) if len(ledger.time) else 0.0,
        *(float(volume[-1]) / MILLILITRE if len(volume) else 0.0 for volume in volumes),
        float(beats[0]) / MILLILITRE_PER_MINUTE if len(beats) else None,
        float(beats[-1]) / MILLILITRE_PER_MINUTE if len(beats) else None,
        _mean(waves.pressure_artery),
        _mean(waves.pressure_injury),
        outcome.period,
        outcome.ledger.volume_error_fraction,
        outcome.barrier_crossings,
        outcome.skin_open_area / SQUARE_MILLIMETRE,
        outcome.skin_sparse_area / SQUARE_MILLIMETRE,
        outcome.particle_count,
        outcome.steps,
    )
    return {
        key: _finite(value) if isinstance(value, float) else value
        for key, value in zip(keys, values, strict=True)
    }


def _mean(pressure: Any) -> float | None:
    return float(pressure.mean()) / MILLIMETRE_OF_MERCURY if len(pressure) else None


def _finite(value: float) -> float | None:
    """`value`, or None where JSON has no number for it."""
    return float(value) if math.isfinite(value) else None
