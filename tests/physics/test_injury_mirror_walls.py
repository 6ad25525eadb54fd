"""Slip walls on a layer of nodes are planes of symmetry: a half moves as the half of the whole."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury import Block, Experiment
from vulnus.injury.boundaries import Wall
from vulnus.injury.materials import material_table, von_mises
from vulnus.injury.solver import MpmSolver

pytestmark = pytest.mark.physics

METAL = von_mises(8000.0, 100e9, 0.3, 200e6, 1e9)
SIZE = 8e-3


def pressed(planes, *, spacing, normal_side=1.0, threads=2):
    """A block that spreads and shears, whole or cut by the planes through its middle."""
    experiment = Experiment(grid_spacing=spacing, precision="float64", threads=threads)
    cut = [axis in planes for axis in "xyz"]
    size = np.where(cut, 0.5, 1.0) * SIZE
    centre = np.where(cut, 0.25, 0.0) * SIZE * normal_side

    def squeezed(x):
        bulge = np.cos(np.pi * x[:, 2:] / SIZE)
        return np.hstack([60e3 * x[:, :2] * bulge**2, -100e3 * x[:, 2:]])

    experiment.add_body(
        Block(size=tuple(size), centre=tuple(centre)),
        material=METAL,
        velocity=squeezed,
        name="block",
    )
    for axis, one in zip("xyz", cut, strict=True):
        normal = tuple(normal_side * (np.array(list("xyz")) == axis))
        if one:
            experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    return experiment.run(until=4e-6).final


# With 7 and 9 cells across, the nodes' places carry round-off.
@pytest.mark.parametrize("cells", [8, 7, 9])
@pytest.mark.parametrize("planes", ["x", "yz", "xyz"])
def test_a_cut_body_moves_as_its_part_of_the_whole(planes, cells):
    spacing = SIZE / cells
    whole, part = pressed("", spacing=spacing), pressed(planes, spacing=spacing)
    kept = np.all([whole.reference_position[:, "xyz".index(axis)] > 0.0 for axis in planes], axis=0)
    assert kept.sum() == len(part)
    order, other = (np.lexsort(np.round(x * 1e7).T) for x in (
        whole.reference_position[kept], part.reference_position
    ))  # fmt: skip
    moved = whole.position[kept][order] - part.position[other]
    assert np.max(whole.plastic_strain) > 0.1  # it did something
    assert np.max(np.abs(moved)) < 1e-9 * SIZE  # round-off, grown by some hundred steps
    stress = whole.stress[kept][order] - part.stress[other]
    assert np.max(np.abs(stress)) < 1e-6 * np.max(np.abs(whole.stress))


def test_the_wall_may_face_either_way():
    right = pressed("xz", spacing=1e-3)
    left = pressed("xz", spacing=1e-3, normal_side=-1.0)
    order = np.lexsort(np.round(right.reference_position * 1e7).T)
    other = np.lexsort(np.round(-left.reference_position * (1, -1, 1) * 1e7).T)
    moved = right.position[order] + left.position[other] * (1, -1, 1)
    assert np.max(np.abs(moved)) < 1e-9 * SIZE


def test_the_result_does_not_depend_on_the_threads():
    one, two = (pressed("xyz", spacing=1e-3, threads=n) for n in (1, 2))
    assert np.array_equal(one.position, two.position)


def test_nothing_passes_a_mirror():
    """Thrown against the wall, particles stay in front of it and their centre turns round."""
    experiment = Experiment(grid_spacing=1e-3, threads=2)
    experiment.add_body(
        Block(size=(8e-3, 4e-3, 4e-3), centre=(4.5e-3, 0.0, 0.0)),
        material=METAL,
        velocity=(-100.0, 0.0, 0.0),
        name="block",
    )
    experiment.add_wall(point=(0.0, 0.0, 0.0), normal="x", kind="slip")
    final = experiment.run(until=20e-6).final
    assert np.min(final.position[:, 0]) > 0.0


def test_a_tracer_beside_a_mirror_moves_as_in_the_whole():
    """Within the first cell the nodes behind the mirror count, by their images."""
    spacing = 1e-3
    edge = (np.arange(-8, 8) + 0.5) * spacing / 2.0
    x = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    tracers = np.array([[0.2e-3, 1e-3, 0.3e-3], [0.9e-3, -1e-3, 0.1e-3], [0.4e-3, 0.1e-3, 2e-3]])

    def moved(part, walls):
        solver = MpmSolver(
            materials=material_table([METAL], spacing), grid_spacing=spacing, lower=(-0.1,) * 3,
            upper=(0.1,) * 3, precision="float64", boundaries=walls,
        )  # fmt: skip
        velocity = part * (60e3, 30e3, -90e3)
        solver.set_particles(
            part, volume=np.full(len(part), (spacing / 2.0) ** 3), velocity=velocity,
            material=np.zeros(len(part), np.uint8),
        )  # fmt: skip
        solver.set_tracers(tracers)
        solver.advance(until=2e-6)
        return solver.tracers[0] - tracers

    whole = moved(x, [])
    walls = [Wall(point=(0.0,) * 3, normal=tuple(np.eye(3)[a]), kind="slip") for a in (0, 2)]
    part = moved(x[(x[:, 0] > 0.0) & (x[:, 2] > 0.0)], walls)
    assert np.min(np.abs(whole)) > 1e-6  # they all move
    assert np.allclose(part, whole, rtol=0.0, atol=1e-12)
