"""Stretched but unbroken skin holds a field of test particles back; torn skin does not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from reference.sph_limb import RADIUS

from vulnus.core.handoff import Tissue
from vulnus.hemorrhage import HemorrhageParameters
from vulnus.hemorrhage.barriers import build_barriers
from vulnus.hemorrhage.openings import skin_openings, sparse_skin_area

PARAMETERS = HemorrhageParameters(particle_spacing=2e-3)
POLE = np.array([0.0, -RADIUS, 0.0])


@pytest.fixture(scope="module")
def whole(closed_wound):
    """A limb whose skin is closed, with a cavity of 12 mm under the skin around the pole."""
    wound = closed_wound
    away = np.linalg.norm(wound.reference_position - POLE, axis=1)
    pushed = (away < 0.012) & (wound.tissue != Tissue.SKIN)
    position = wound.position.copy()
    position[pushed] += np.array([0.0, 0.014, 0.0], np.float32)
    damage = np.where(wound.tissue == Tissue.SKIN, 0.0, wound.damage).astype(np.float32)
    return dataclasses.replace(wound, position=position, damage=damage)


def openings(wound, **changes):
    parameters = dataclasses.replace(PARAMETERS, **changes)
    return skin_openings(build_barriers(wound, parameters), parameters.particle_spacing)


def patch(wound, radius):
    away = np.linalg.norm(wound.reference_position - POLE, axis=1)
    return (away < radius) & (wound.tissue == Tissue.SKIN)


def blown_up(wound, height):
    """The skin around the pole as a dome: stretched most at its top."""
    offset = wound.reference_position - POLE
    away = np.hypot(offset[:, 0], offset[:, 2])
    lift = height * np.cos(0.5 * np.pi * np.minimum(away / 0.012, 1.0)) ** 2
    position = wound.position.copy()
    moved = patch(wound, 0.013)
    position[moved, 1] -= lift[moved].astype(np.float32)
    return dataclasses.replace(wound, position=position)


@pytest.mark.parametrize("model", ["damage", "presence"])
def test_whole_skin_lets_nothing_through(whole, model):
    found = openings(whole, barrier_model=model)
    assert not found.leaks
    assert found.area == 0.0


def test_stretched_but_unbroken_skin_lets_nothing_through(whole):
    """A dome of 7 mm on 24 mm: its flanks are stretched by 36 %, less than the 54 % skin bears."""
    assert not openings(blown_up(whole, 0.007)).leaks


@pytest.mark.parametrize("radius", [0.005, 0.008])
def test_failed_skin_leaks_through_a_hole_of_its_size(whole, radius):
    """To three quarters of the points' spacing of 2 mm: skin reaches 0.6 beyond its points."""
    damage = whole.damage.copy()
    damage[patch(whole, radius)] = 1.0
    found = openings(dataclasses.replace(whole, damage=damage))
    assert found.leaks
    assert np.sqrt(found.area / np.pi) == pytest.approx(radius, abs=1.5e-3)


def test_skin_torn_without_loss_leaks_where_it_gapes(whole):
    """No point is damaged, but two halves of the patch are pulled 8 mm apart."""
    position = whole.position.copy()
    moved = patch(whole, 0.012)
    side = np.sign(whole.reference_position[moved, 0])
    reach = np.cos(0.5 * np.pi * np.abs(whole.reference_position[moved, 2]) / 0.012)
    position[moved, 0] += (0.004 * side * reach).astype(np.float32)
    found = openings(dataclasses.replace(whole, position=position))
    assert found.leaks
    assert 2e-5 < found.area < 1.5e-4


def test_presence_holds_damaged_skin_and_opens_where_it_is_gone(whole):
    damaged = dataclasses.replace(whole, damage=np.where(patch(whole, 0.006), 1.0, whole.damage))
    assert not openings(damaged, barrier_model="presence").leaks
    position = whole.position.copy()
    position[patch(whole, 0.006)] += np.array([0.0, -0.05, 0.0], np.float32)
    gone = dataclasses.replace(whole, position=position)
    assert openings(gone, barrier_model="presence").leaks


def test_a_smaller_particle_gets_through_where_a_larger_one_does_not(whole):
    """A hole of some mm stops particles of 9 mm."""
    damage = whole.damage.copy()
    damage[patch(whole, 0.004)] = 1.0
    narrow = dataclasses.replace(whole, damage=damage)
    barriers = build_barriers(narrow, PARAMETERS)
    assert skin_openings(barriers, 1e-3).leaks
    assert not skin_openings(barriers, 9e-3).leaks


def test_the_area_of_sparse_skin_is_that_of_skin_blown_away(whole):
    """30 %: the density is a mean over four spacings, 6 mm."""
    barriers = build_barriers(whole, PARAMETERS)
    assert sparse_skin_area(whole, barriers) == 0.0
    position = whole.position.copy()
    position[patch(whole, 0.009)] += np.array([0.0, -0.05, 0.0], np.float32)
    gone = dataclasses.replace(whole, position=position)
    found = sparse_skin_area(gone, barriers)
    assert found == pytest.approx(np.pi * 0.009**2, rel=0.3)
