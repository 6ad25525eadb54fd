"""Solids: distances, volumes, and the points that fill them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import ScenarioError
from vulnus.injury import (
    Ball,
    Block,
    FunctionSolid,
    HalfSpace,
    Rod,
    Shell,
    Solid,
    Tube,
    rotation_about,
)

CENTRE = (0.01, -0.02, 0.03)
SOLIDS = {
    "block": Block(size=(0.1, 0.05, 0.04), centre=CENTRE),
    "ball": Ball(radius=0.03, centre=CENTRE),
    "shell": Shell(inner_radius=0.02, outer_radius=0.03, centre=CENTRE),
    "rod": Rod(radius=0.02, length=0.07, axis="x", centre=CENTRE),
    "oblique rod": Rod(radius=0.02, length=0.07, axis=(1.0, 2.0, -0.5), centre=CENTRE),
    "tube": Tube(inner_radius=0.01, outer_radius=0.02, length=0.05, axis="y", centre=CENTRE),
}
VOLUMES = {
    "block": 0.1 * 0.05 * 0.04,
    "ball": 4 / 3 * np.pi * 0.03**3,
    "shell": 4 / 3 * np.pi * (0.03**3 - 0.02**3),
    "rod": np.pi * 0.02**2 * 0.07,
    "oblique rod": np.pi * 0.02**2 * 0.07,
    "tube": np.pi * (0.02**2 - 0.01**2) * 0.05,
}


@pytest.mark.parametrize("name", SOLIDS)
def test_volumes_are_exact_and_the_points_share_them(name: str) -> None:
    solid = SOLIDS[name]
    assert solid.volume == pytest.approx(VOLUMES[name], rel=1e-12)
    filled = solid.lattice(2e-3)
    assert filled.volume.sum() == pytest.approx(VOLUMES[name], rel=1e-12)
    assert solid.contains(filled.position).all()
    # A uniform filling has the solid's own middle, here to a tenth of the spacing.
    assert filled.position.mean(axis=0) == pytest.approx(CENTRE, abs=2e-4)


@pytest.mark.parametrize("name", SOLIDS)
def test_the_measured_volume_is_the_closed_form(name: str) -> None:
    # First-order parts of cut cells cancel: 0.3 % is stated, 0.1 % is found.
    assert SOLIDS[name]._measured_volume() == pytest.approx(VOLUMES[name], rel=3e-3)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_distance_never_exceeds_the_way_to_any_inside_point(name: str) -> None:
    solid = SOLIDS[name]
    inside = solid.lattice(4e-3).position
    rng = np.random.default_rng(1)
    outside = rng.uniform(-0.2, 0.2, (200, 3))
    outside = outside[~solid.contains(outside)]
    distance = solid.signed_distance(outside)
    nearest = np.min(np.linalg.norm(outside[:, None] - inside, axis=2), axis=1)
    assert (distance <= nearest + 1e-12).all()
    # The lattice's outer points lie within a cell's diagonal of the surface.
    assert (distance >= nearest - 4e-3 * np.sqrt(3.0)).all()


@settings(deadline=None, derandomize=True, max_examples=25)
@given(
    name=st.sampled_from(sorted(SOLIDS)),
    axis=st.tuples(*[st.floats(-1, 1) for _ in range(3)]).filter(lambda a: np.hypot(*a[:2]) > 0.1),
    angle=st.floats(-3.0, 3.0),
    shift=st.tuples(*[st.floats(-0.5, 0.5) for _ in range(3)]),
)
def test_a_moved_and_turned_solid_is_the_same_solid(name, axis, angle, shift) -> None:
    solid = SOLIDS[name]
    rotation = rotation_about(axis, angle)
    moved = solid.rotated(rotation, about=(0.1, 0.0, 0.0)).moved(shift)
    points = np.random.default_rng(2).uniform(-0.1, 0.1, (50, 3))
    images = (points - (0.1, 0, 0)) @ rotation.T + (0.1, 0, 0) + shift
    assert moved.signed_distance(images) == pytest.approx(solid.signed_distance(points), abs=1e-12)
    assert moved.volume == pytest.approx(solid.volume, rel=1e-12)
    before, after = solid.lattice(4e-3), moved.lattice(4e-3)
    assert after.position == pytest.approx(
        (before.position - (0.1, 0, 0)) @ rotation.T + (0.1, 0, 0) + shift, abs=1e-12
    )
    lower, upper = moved.bounds
    assert ((after.position > lower - 1e-12) & (after.position < upper + 1e-12)).all()


def test_what_solids_make_together() -> None:
    block, rod = Block(size=(0.04, 0.04, 0.04)), Rod(radius=0.01, length=0.1)
    bored = block - rod
    drilled = np.pi * 0.01**2 * 0.04
    assert bored.volume == pytest.approx(block.volume - drilled, rel=3e-3)
    assert (block & rod).volume == pytest.approx(drilled, rel=1e-2)
    assert (block | rod).volume == pytest.approx(block.volume + 1.5 * drilled, rel=1e-2)
    half = Ball(radius=0.02) & HalfSpace(point=(0, 0, 0), normal=(0, 0, 1))
    assert half.volume == pytest.approx(0.5 * Ball(radius=0.02).volume, rel=3e-3)
    # The lattice of a cut solid begins at the cut.
    assert half.lattice(1e-3).position[:, 2].min() == pytest.approx(0.5e-3, rel=1e-9)


def test_a_function_is_a_solid() -> None:
    wavy = FunctionSolid(
        function=lambda x: np.linalg.norm(x, axis=1) - 0.02, lower=(-0.03,) * 3, upper=(0.03,) * 3
    )
    assert wavy.volume == pytest.approx(Ball(radius=0.02).volume, rel=3e-3)
    with pytest.raises(ScenarioError, match="gave shape"):
        FunctionSolid(function=lambda x: x, lower=(0, 0, 0), upper=(1, 1, 1))


def test_poisson_points_fill_as_densely_as_asked() -> None:
    block = Block(size=(0.04, 0.03, 0.02))
    filled = block.poisson_disk(8.0 / 2e-3**3, seed=3)
    # The expected density of the sampler is a measured mean: 10 %.
    assert len(filled.position) == pytest.approx(8.0 * block.volume / 2e-3**3, rel=0.1)
    assert filled.volume.sum() == pytest.approx(block.volume, rel=1e-12)
    assert (filled.position == block.poisson_disk(8.0 / 2e-3**3, seed=3).position).all()
    assert (filled.position[:20] != block.poisson_disk(8.0 / 2e-3**3, 4).position[:20]).any()


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Block(size=(1, 0, 1)), "size along y: is 0, must be > 0"),
        (lambda: Block(size=(1, 1)), "three finite numbers"),
        (lambda: Ball(radius=float("nan")), "finite number"),
        (lambda: Ball(radius=-1.0), "radius: is -1"),
        (lambda: Ball(radius=1.0, centre=(0, 0, np.inf)), "centre"),
        (lambda: Rod(radius=1.0, length=1.0, axis="w"), "'w' is not known"),
        (lambda: Rod(radius=1.0, length=1.0, axis=(0, 0, 0)), "no direction"),
        (lambda: Shell(inner_radius=2.0, outer_radius=1.0), "must be > inner_radius"),
        (lambda: Ball(radius=1.0, rotation=2 * np.eye(3)), "not a rotation"),
        (lambda: HalfSpace(point=(0, 0, 0), normal=(0, 0, 1)).lattice(1.0), "no bounds"),
        (lambda: (Ball(radius=1.0) & Ball(radius=1.0, centre=(5, 0, 0))).volume, "nothing is left"),
    ],
)
def test_solids_that_are_none_are_refused(make, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        make()


def test_every_solid_is_a_solid() -> None:
    assert all(isinstance(solid, Solid) for solid in SOLIDS.values())
