"""Pieces of bone are those that nothing whole connects to a main bone any more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb

from vulnus.core.handoff import Tissue
from vulnus.injury import AimParameters, InjuryParameters, ProjectileParameters, shoot
from vulnus.injury.wound.bone_fragments import bone_report, crushed_piece_mass

SPACING = 0.002
MASS = 1e-5
RATE = 4e4  # 1/s, of 9 mm at 350 m/s


def rod(length: float = 0.1, radius: float = 0.006):
    """Points of a rod along z on a jittered lattice."""
    across = np.arange(-radius, radius, SPACING) + SPACING / 2
    along = np.arange(0.0, length, SPACING)
    points = np.stack(np.meshgrid(across, across, along, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[np.hypot(points[:, 0], points[:, 1]) < radius]
    return points + np.random.default_rng(2).uniform(-0.1, 0.1, points.shape) * SPACING


def report(points, whole, position=None):
    where = points if position is None else position
    return bone_report(
        points, where, np.full(len(points), MASS), whole, spacing=0.8 * SPACING, strain_rate=RATE
    )


def test_a_whole_bone_has_no_fragments():
    points = rod()
    found = report(points, np.ones(len(points), bool))
    assert found.fragments == ()
    assert found.debris_mass == pytest.approx(0.0, abs=1e-12)
    assert found.mass == pytest.approx(MASS * len(points))


def test_a_bone_broken_in_two_keeps_two_main_pieces_and_the_gap_is_debris():
    points = rod()
    gap = np.abs(points[:, 2] - 0.05) < 0.003
    found = report(points, ~gap)
    assert found.fragments == ()
    assert found.debris_mass == pytest.approx(MASS * np.count_nonzero(gap))


def test_a_piece_between_two_breaks_is_a_fragment_with_its_mass():
    """A segment of 6 % of the bone between two destroyed layers."""
    points = rod()
    layers = (np.abs(points[:, 2] - 0.046) < 0.002) | (np.abs(points[:, 2] - 0.056) < 0.002)
    piece = (points[:, 2] > 0.048) & (points[:, 2] < 0.054)
    (fragment,) = report(points, ~layers).fragments
    assert fragment.points == np.count_nonzero(piece)
    assert fragment.mass == pytest.approx(MASS * fragment.points)
    assert fragment.position[2] == pytest.approx(points[piece, 2].mean(), abs=1e-9)


def test_a_piece_that_was_pulled_off_whole_is_a_fragment_too():
    points = rod()
    chip = (points[:, 0] > 0.004) & (np.abs(points[:, 2] - 0.05) < 0.005)
    away = points + np.where(chip, 0.02, 0.0)[:, None] * np.array([1.0, 0.0, 0.0])
    (fragment,) = report(points, np.ones(len(points), bool), away).fragments
    assert fragment.points == np.count_nonzero(chip)
    assert fragment.position[0] > 0.02


def test_dust_is_debris_and_no_fragment():
    """A few lone points in a destroyed stretch."""
    points = rod()
    gap = np.abs(points[:, 2] - 0.05) < 0.01
    inner = np.flatnonzero(np.abs(points[:, 2] - 0.05) < 0.005)
    lone = inner[:: len(inner) // 3][:3]
    whole = ~gap
    whole[lone] = True
    found = report(points, whole)
    assert found.fragments == ()
    assert found.debris_mass == pytest.approx(MASS * np.count_nonzero(gap))


def test_a_limb_without_bone_has_an_empty_report():
    found = report(np.zeros((0, 3)), np.zeros(0, bool))
    assert (found.mass, found.debris_mass, found.fragments) == (0.0, 0.0, ())


def test_mass_is_shared_out_completely():
    rng = np.random.default_rng(7)
    points = rod()
    whole = rng.random(len(points)) > 0.6
    found = report(points, whole)
    parts = sum(piece.mass for piece in found.fragments) + found.debris_mass
    assert found.debris_mass >= MASS * np.count_nonzero(~whole) - 1e-12
    assert parts <= found.mass + 1e-12


def test_crushed_bone_is_millimetres_in_size_and_finer_the_faster():
    """24 * 3 kJ/m² / (4e4 /s)² is 45 mg, a cube of 2.9 mm; a quarter at twice the rate."""
    assert crushed_piece_mass(RATE) == pytest.approx(45e-6, rel=1e-9)
    assert crushed_piece_mass(2 * RATE) == pytest.approx(45e-6 / 4, rel=1e-9)
    points = rod()
    gap = np.abs(points[:, 2] - 0.05) < 0.01
    found = report(points, ~gap)
    assert found.debris_piece_count == round(MASS * np.count_nonzero(gap) / 45e-6)
    assert report(points, np.ones(len(points), bool)).debris_piece_count == 0


def struck(bone_radius: float):
    """A ball of 8 g at 350 m/s against a shaft of bone with marrow in it."""
    limb = synthetic_limb(
        spacing=0.002, radius=0.022, length=0.06, skin=0.002, bone_radius=bone_radius,
        bone_at=(0.0, 0.0), artery_at=(-0.017, 0.0),
    )  # fmt: skip
    marrow = np.hypot(limb.position[:, 0], limb.position[:, 1]) < bone_radius - 0.006
    tissue = np.where(marrow, np.uint8(Tissue.MARROW), limb.tissue)
    parameters = InjuryParameters(
        projectile=ProjectileParameters(diameter=0.009, mass=0.008, motion="dynamic"),
        aim=AimParameters(target=(0.0, 0.0, 0.0)),
        grid_spacing=0.004, duration=5e-4, window_length=None, threads=1,
    )  # fmt: skip
    return shoot(replace(limb, tissue=tissue), parameters).report.bone


def test_a_shaft_that_a_bullet_hits_breaks_into_fragments():
    """A comminuted fracture: several pieces of some grams in all, among crushed bone."""
    bone = struck(0.0125)
    assert 3 <= len(bone.fragments) <= 100
    pieces = sum(piece.mass for piece in bone.fragments)
    assert 0.005 * bone.mass < pieces < 0.3 * bone.mass
    assert 0.05 * bone.mass < bone.debris_mass < 0.6 * bone.mass
    assert 50 <= bone.debris_piece_count <= 1000
