"""Pieces of bone are those that nothing whole connects to a main bone any more."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury.bone_fragments import bone_report

SPACING = 0.002
MASS = 1e-5


def rod(length: float = 0.1, radius: float = 0.006):
    """Points of a rod along z on a jittered lattice."""
    across = np.arange(-radius, radius, SPACING) + SPACING / 2
    along = np.arange(0.0, length, SPACING)
    points = np.stack(np.meshgrid(across, across, along, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[np.hypot(points[:, 0], points[:, 1]) < radius]
    return points + np.random.default_rng(2).uniform(-0.1, 0.1, points.shape) * SPACING


def report(points, whole, position=None):
    where = points if position is None else position
    return bone_report(points, where, np.full(len(points), MASS), whole, spacing=0.8 * SPACING)


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
