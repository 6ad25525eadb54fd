"""The volume that points enclose and do not fill, against hollows of known volume."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.injury.bodies.drawn_shapes import BladeShape
from vulnus.injury.bodies.shapes import Sphere
from vulnus.injury.shot.body_filling import body_filling
from vulnus.injury.wound.cavity import cavity_volume, deposit, directions_with_tissue, find_cavity

SPACING = 0.002


def lattice(half, *, spacing=SPACING, seed=0):
    """Points of a jittered lattice that fills a box with half sides `half`."""
    axes = [(np.arange(round(2 * h / spacing)) + 0.5) * spacing - h for h in half]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points + np.random.default_rng(seed).uniform(-0.25, 0.25, points.shape) * spacing


@pytest.fixture(scope="module")
def block():
    return lattice((0.024, 0.024, 0.024))


def test_a_whole_block_and_a_whole_limb_have_no_cavity(block):
    assert cavity_volume(block, SPACING) == 0.0
    limb = block[np.hypot(block[:, 0], block[:, 1]) < 0.022]
    assert cavity_volume(limb, SPACING) == 0.0
    assert cavity_volume(np.zeros((0, 3)), SPACING) == 0.0


@pytest.mark.parametrize("radius", [0.008, 0.011, 0.014])
def test_a_hollow_sphere_has_its_volume(block, radius):
    """5 %: the points of a lattice render the sphere's surface."""
    hollow = block[np.linalg.norm(block, axis=1) > radius]
    expected = 4.0 / 3.0 * np.pi * radius**3
    assert cavity_volume(hollow, SPACING) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("radius", [0.0075, 0.009, 0.012])
def test_a_tract_open_at_both_ends_has_the_volume_to_the_surface(block, radius):
    """5 %, as the sphere; its two mouths end flush with the surface."""
    open_tract = block[np.hypot(block[:, 0], block[:, 1]) > radius]
    expected = np.pi * radius**2 * 0.048
    assert cavity_volume(open_tract, SPACING) == pytest.approx(expected, rel=0.05)


def test_a_blind_tract_has_its_volume(block):
    blind = block[(np.hypot(block[:, 0], block[:, 1]) > 0.008) | (block[:, 2] > 0.006)]
    assert cavity_volume(blind, SPACING) == pytest.approx(np.pi * 0.008**2 * 0.03, rel=0.05)


def test_a_tract_through_a_round_limb():
    """8 %: where a round limb's surface would be over so wide a hole is a matter of taste."""
    limb = lattice((0.04, 0.04, 0.04))
    limb = limb[np.hypot(limb[:, 0], limb[:, 1]) < 0.036]
    inside = np.hypot(limb[:, 0], limb[:, 2]) < 0.01
    assert cavity_volume(limb[~inside], SPACING) == pytest.approx(
        np.count_nonzero(inside) * SPACING**3, rel=0.08
    )


def test_matter_that_has_flown_off_changes_nothing(block):
    hollow = block[np.linalg.norm(block, axis=1) > 0.009]
    far = np.random.default_rng(3).uniform(-0.5, 0.5, (100, 3)) + np.array([0.6, 0.0, 0.0])
    assert cavity_volume(np.concatenate([hollow, far]), SPACING) == pytest.approx(
        cavity_volume(hollow, SPACING), rel=0.02
    )


@settings(derandomize=True, max_examples=8, deadline=None)
@given(
    shift=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
    order=st.integers(0, 2**31),
)
def test_the_volume_does_not_depend_on_place_and_order(shift, order):
    """3 %: a voxel's fraction of a shift moves the rim's voxels; the order moves only round-off."""
    points = lattice((0.016, 0.016, 0.016))
    hollow = points[np.linalg.norm(points, axis=1) > 0.008]
    volume = cavity_volume(hollow, SPACING)
    shuffled = np.random.default_rng(order).permutation(hollow)
    assert cavity_volume(shuffled, SPACING) == pytest.approx(volume, rel=1e-6)
    assert cavity_volume(hollow + np.array(shift), SPACING) == pytest.approx(volume, rel=0.03)


def test_the_same_points_give_the_same_bits(block):
    hollow = block[np.linalg.norm(block, axis=1) > 0.009]
    first, second = find_cavity(hollow, SPACING), find_cavity(hollow, SPACING)
    assert np.array_equal(first.void, second.void)
    assert first.volume == second.volume > 0.0


def test_a_deposit_keeps_the_sum_and_the_middle():
    points = np.random.default_rng(1).uniform(0.2, 0.8, (50, 3))
    weight = np.linspace(1.0, 2.0, 50)
    grid = deposit(points, weight, origin=np.zeros(3), cell=0.1, shape=(11, 11, 11))
    assert grid.sum() == pytest.approx(weight.sum(), rel=1e-5)
    middle = np.einsum("ijk,i->", grid, 0.1 * np.arange(11)) / grid.sum()
    assert middle == pytest.approx(np.average(points[:, 0], weights=weight), rel=1e-5)


def test_rays_count_what_they_meet():
    solid = np.zeros((5, 5, 5), bool)
    solid[4] = True  # a wall at +x
    seen = directions_with_tissue(solid)
    assert seen[2, 2, 2] == 9  # the nine directions with +x
    assert seen[3, 0, 0] == 4  # in the corner only those that stay in the box
    assert seen[4, 2, 2] == 8  # in the wall: along it


def filled_with(shape, hollow, place=(0.0, 0.0, 0.0)):
    """The cavity of hollow points with a body in it."""
    body = body_filling(shape, np.concatenate([place, np.eye(3).ravel()]), SPACING)
    volume = np.concatenate([np.full(len(hollow), SPACING**3), body.volume])
    return cavity_volume(np.concatenate([hollow, body.position]), SPACING, volume=volume)


def test_the_room_of_a_body_is_no_cavity(block):
    """One that fills its hole leaves nothing, one of half the size the rest, within 5 %."""
    radius = 6 * SPACING
    hollow = block[np.linalg.norm(block, axis=1) > radius]
    ball = 4.0 / 3.0 * np.pi * radius**3
    assert filled_with(Sphere(radius), hollow) < 0.05 * ball
    assert filled_with(Sphere(0.5 * radius), hollow) == pytest.approx(0.875 * ball, rel=0.05)
    # Beside the tissue it changes nothing.
    apart = filled_with(Sphere(0.5 * radius), hollow, (0.06, 0.0, 0.0))
    assert apart == pytest.approx(cavity_volume(hollow, SPACING), rel=1e-6)


def test_a_body_is_filled_with_its_volume():
    blade = BladeShape(0.1, 0.02, 0.001, 0.02)
    filled = body_filling(blade, np.concatenate([[1.0, 2.0, 3.0], np.eye(3).ravel()]), SPACING)
    assert filled.volume.sum() == pytest.approx(blade.volume)
    assert np.all(filled.position > np.array([1.0, 2.0, 3.0]) + blade.lower)
    assert np.all(filled.position < np.array([1.0, 2.0, 3.0]) + blade.upper)
    dot = body_filling(Sphere(1e-5), np.concatenate([[0.0, 0.0, 1.0], np.eye(3).ravel()]), SPACING)
    assert dot.position.tolist() == [[0.0, 0.0, 1.0]]
