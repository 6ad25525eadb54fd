"""The wound of a run as files: its states and fields for ParaView, its tables, its numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from vulnus.core.handoff import InjuredLimb, InjuryOutcome, ParticleFrame
from vulnus.core.units import MILLILITRE, MILLIMETRE, MILLISECOND, SQUARE_MILLIMETRE
from vulnus.core.wound_report import (
    BoneReport,
    ProjectileReport,
    SkinHole,
    TissueField,
    VesselReport,
    WoundReport,
)

from .frame_series import frame_as_vtkhdf
from .tables import table_text
from .whole_file import write_whole

GRAM = 1e-3


def write_wound_files(directory: Path, outcome: InjuryOutcome) -> None:
    """Write each state by its name, the field of damage, and the report's tables."""
    for name, limb in outcome.states.items():
        write_whole(directory / f"{name}.vtkhdf", frame_as_vtkhdf(_state_frame(limb)))
    report = outcome.report
    write_whole(directory / "field.vtkhdf", field_as_vtkhdf(report.field))
    cavity = report.cavity
    write_whole(
        directory / "cavity.csv",
        table_text(
            {"t_ms": cavity.time / MILLISECOND, "cavity_volume_ml": cavity.volume / MILLILITRE}
        ),
    )
    for number, projectile in enumerate(report.projectiles):
        ending = "" if number == 0 else f"_{number + 1}"
        write_whole(directory / f"tract{ending}.csv", table_text(_tract_columns(projectile)))
        write_whole(directory / f"energy{ending}.csv", table_text(_energy_columns(projectile)))


def _state_frame(limb: InjuredLimb) -> ParticleFrame:
    return ParticleFrame(
        index=0,
        time=limb.time,
        position=limb.position,
        point_data={
            "displacement_m": limb.position - limb.reference_position,
            "damage": limb.damage,
            "tissue": limb.tissue,
        },
    )


def _tract_columns(projectile: ProjectileReport) -> dict[str, Any]:
    tract = projectile.tract
    return {
        "arc_length_mm": tract.arc_length / MILLIMETRE,
        "x_mm": tract.points[:, 0] / MILLIMETRE,
        "y_mm": tract.points[:, 1] / MILLIMETRE,
        "z_mm": tract.points[:, 2] / MILLIMETRE,
        "temporary_radius_mm": tract.temporary_radius / MILLIMETRE,
        "permanent_radius_mm": tract.permanent_radius / MILLIMETRE,
        "destroyed_radius_mm": tract.destroyed_radius / MILLIMETRE,
    }


def _energy_columns(projectile: ProjectileReport) -> dict[str, Any]:
    deposit = projectile.energy
    return {
        "path_from_mm": deposit.edges[:-1] / MILLIMETRE,
        "path_to_mm": deposit.edges[1:] / MILLIMETRE,
        "energy_j": deposit.energy,
    }


def field_as_vtkhdf(field: TissueField) -> bytes:
    """The bytes of a VTKHDF ImageData file with damage and void, which ParaView opens."""
    import h5py

    with h5py.File("field", "w", driver="core", backing_store=False) as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([1, 0], dtype=np.int64)
        root.attrs.create("Type", b"ImageData", dtype=h5py.string_dtype("ascii", len("ImageData")))
        last = np.array(field.damage.shape) - 1
        extent = np.column_stack([np.zeros(3, np.int64), last]).ravel()
        root.attrs["WholeExtent"] = extent.astype(np.int64)
        root.attrs["Origin"] = np.array(field.origin)
        root.attrs["Spacing"] = np.full(3, field.cell)
        root.attrs["Direction"] = np.eye(3).ravel()
        data = root.create_group("PointData")
        for name, values in (("damage", field.damage), ("void", field.void)):
            data[name] = np.ascontiguousarray(np.transpose(values))  # z, y, x in the file
        file.flush()
        return bytes(file.id.get_file_image())


def report_numbers(report: WoundReport) -> dict[str, Any]:
    """The report for `summary.json`."""
    volume = report.cavity.volume
    first = report.projectiles[0]
    return {
        "temporary_time_ms": report.temporary_time / MILLISECOND,
        "temporary_cavity_ml": float(volume.max(initial=0.0)) / MILLILITRE,
        "permanent_cavity_ml": (float(volume[-1]) if len(volume) else 0.0) / MILLILITRE,
        "cavity_collapsed": report.collapsed,
        "collapse_time_ms": (
            None if report.collapse_time is None else report.collapse_time / MILLISECOND
        ),
        "end_time_ms": (float(report.cavity.time[-1]) if len(volume) else 0.0) / MILLISECOND,
        "simulated_particles": report.particle_count,
        "steps": report.steps,
        "flight_steps": report.flight_steps,
        "energy_left_j": sum(projectile.energy.total for projectile in report.projectiles),
        "tract_length_mm": float(first.tract.arc_length[-1]) / MILLIMETRE,
        "projectiles": [_projectile(projectile) for projectile in report.projectiles],
        "arteries": [_vessel(vessel) for vessel in report.vessels],
        "bone": _bone(report.bone),
        "notes": list(report.notes),
    }


def _projectile(projectile: ProjectileReport) -> dict[str, Any]:
    return {
        "name": projectile.name,
        "fate": projectile.fate,
        "position_mm": [x / MILLIMETRE for x in projectile.position],
        "speed_before_m_per_s": projectile.speed_before,
        "speed_after_m_per_s": projectile.speed_after,
        "energy_before_j": projectile.energy_before,
        "energy_after_j": projectile.energy_after,
        "energy_left_j": projectile.energy.total,
        "tract_length_mm": float(projectile.tract.arc_length[-1]) / MILLIMETRE,
        "cells_across": projectile.cells_across if np.isfinite(projectile.cells_across) else None,
        "entry": _hole(projectile.entry),
        "exit": None if projectile.exit is None else _hole(projectile.exit),
    }


def _hole(hole: SkinHole) -> dict[str, Any]:
    return {
        "position_mm": [x / MILLIMETRE for x in hole.position],
        "open_area_mm2": hole.open_area / SQUARE_MILLIMETRE,
        "destroyed_area_mm2": hole.destroyed_area / SQUARE_MILLIMETRE,
    }


def _vessel(vessel: VesselReport) -> dict[str, Any]:
    near = vessel.nearest_distance
    return {
        "artery": vessel.artery,
        "kind": vessel.kind,
        "destroyed_share": vessel.destroyed_share,
        "stretch": vessel.stretch,
        "nearest_distance_mm": near / MILLIMETRE if np.isfinite(near) else None,
        "hole_area_mm2": vessel.hole_area / SQUARE_MILLIMETRE,
        "injuries": vessel.injury_count,
    }


def _bone(bone: BoneReport) -> dict[str, Any]:
    return {
        "mass_g": bone.mass / GRAM,
        "debris_g": bone.debris_mass / GRAM,
        "debris_pieces": bone.debris_piece_count,
        "debris_piece_mass_g": bone.debris_piece_mass / GRAM,
        "fragments": len(bone.fragments),
        "fragment_masses_g": [piece.mass / GRAM for piece in bone.fragments],
    }
