"""Misuse of an experiment is refused with what is wrong and what helps."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import ProjectileError, ScenarioError, VulnusError
from vulnus.injury import (
    Ball,
    Block,
    Experiment,
    PointSensor,
    RegionSensor,
    RigidBody,
    SectionSensor,
    Sphere,
    elastic,
)

SOLID = elastic(1000.0, 1e6, 0.3)
CUBE = Block(size=(0.02, 0.02, 0.02))


def with_cube(**options) -> Experiment:
    experiment = Experiment(grid_spacing=2e-3, **options)
    experiment.add_body(CUBE, material=SOLID, name="cube")
    return experiment


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"grid_spacing": 0.0}, "grid_spacing: is 0, must be > 0"),
        ({"grid_spacing": float("nan")}, "grid_spacing: is nan, must be a finite number"),
        ({"grid_spacing": "fine"}, "grid_spacing: is 'fine'"),
        ({"grid_spacing": 1e-3, "courant_number": 1.5}, "courant_number: is 1.5, must be <= 1"),
        ({"grid_spacing": 1e-3, "gravity": 9.81}, "gravity: is 9.81, must be three"),
        ({"grid_spacing": 1e-3, "precision": "double"}, "precision: 'double' is not known"),
        ({"grid_spacing": 1e-3, "lower": (0, 0, 0)}, "box: has one corner only"),
        ({"grid_spacing": 1e-3, "lower": (1, 0, 0), "upper": (0, 1, 1)}, "must be above lower"),
        ({"grid_spacing": 1e-3, "threads": -1}, "threads: is -1, must be >= 0"),
    ],
)
def test_an_experiment_that_is_none(options, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        Experiment(**options)


@pytest.mark.parametrize(
    ("add", "said"),
    [
        (lambda e: e.add_body(CUBE, material="gelatine_10"), "Did you mean 'gelatin_10'"),
        (lambda e: e.add_body(CUBE, material=None), "body 1: material: is None"),
        (lambda e: e.add_body("cube", material=SOLID), "solid: is 'cube'"),
        (lambda e: e.add_body(CUBE, material=SOLID, arrangement="grid"), "arrangement: 'grid'"),
        (lambda e: e.add_body(CUBE, material=SOLID, particles_per_cell=0), "must be > 0"),
        (lambda e: e.add_body(CUBE, material=SOLID, velocity=(1, 2)), "velocity: does not fit"),
        (lambda e: e.add_body(CUBE, material=SOLID, velocity=(1, 2, np.nan)), "not finite"),
        (lambda e: e.add_body(CUBE, material=SOLID, name="cube"), "'cube' is taken"),
        (lambda e: e.add_body(CUBE, material=SOLID, name="a/b"), "without '/'"),
        (lambda e: e.add_points([[0, 0]], volume=1.0, material=SOLID), r"shape \(1, 2\)"),
        (lambda e: e.add_points([[0, 0, np.inf]], volume=1.0, material=SOLID), "row 0"),
        (lambda e: e.add_points(np.zeros((0, 3)), volume=1.0, material=SOLID), "no particles"),
        (lambda e: e.add_points([[0, 0, 0]], volume=0.0, material=SOLID), "particle 0 is 0 m³"),
        (lambda e: e.add_points([[0, 0, 0]], volume=[1, 2], material=SOLID), "does not fit 1"),
        (lambda e: e.add_labels(np.zeros((2, 2)), materials={0: SOLID}, spacing=1.0), "three of"),
        (lambda e: e.add_labels(np.zeros((2, 2, 2), int), materials={0: SOLID}), "is missing"),
        (
            lambda e: e.add_labels(np.zeros((2, 2, 2), int), materials={7: SOLID}, spacing=1e-2),
            "label 7: no voxel has it. Labels there are: 0",
        ),
        (lambda e: e.add_wall(point=(0, 0, 0), normal=(0, 0, 0)), "no direction"),
        (lambda e: e.add_wall(point=(0, 0, 0), normal="z", kind="sticky"), "'sticky' is not known"),
        (lambda e: e.hold_ends(axis="z", lower=1.0, upper=0.0), "must be above lower"),
        (lambda e: e.absorb_ends(axis="z", thickness=0.0, lower=0.0), "thickness: is 0"),
        (lambda e: e.add_rigid_body(Sphere(1.0)), "rigid body: is Sphere"),
        (lambda e: e.add_sensor("tip"), "sensor: is 'tip'"),
        (lambda e: e.add_sensor(PointSensor(position=(0, 0, 0), quantities=("heat",))), "'heat'"),
        (lambda e: e.add_sensor(PointSensor(position=(0, 0, 0), quantities="stress")), "a tuple"),
        (lambda e: e.add_sensor(SectionSensor(point=(0, 0, 0), normal=(0, 0, 0))), "no direction"),
    ],
)
def test_a_piece_that_does_not_fit(add, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        add(with_cube())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"until": 0.0}, "until: is 0 s, must be after the present 0 s"),
        ({"until": float("inf")}, "until: is inf"),
        ({"until": 1e-3, "sample_interval": 0.0}, "sample_interval: is 0, must be > 0"),
        ({"until": 1e-3, "sample_interval": -1e-4}, "sample_interval: is -0.0001"),
        (
            {"until": 1e-3, "sample_interval": 2e-4, "snapshot_interval": 3e-4},
            "snapshot_interval: is 1.5 sample intervals",
        ),
    ],
)
def test_a_run_that_cannot_be(options, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        with_cube().run(**options)


def test_nothing_in_it() -> None:
    with pytest.raises(ScenarioError, match="has no bodies"):
        Experiment(grid_spacing=1e-3).run(until=1e-3)


def test_a_body_thinner_than_two_cells_unless_between_walls() -> None:
    plate = Block(size=(0.02, 0.02, 2e-3))
    experiment = Experiment(grid_spacing=2e-3)
    experiment.add_body(plate, material=SOLID, name="plate")
    with pytest.raises(ScenarioError, match=r"plate: is 0.002 m thin, 1 cells of 0.002 m"):
        experiment.run(until=1e-6)
    slice_ = Experiment(grid_spacing=2e-3, grid_offset=(0, 0, 1e-3))
    slice_.add_body(plate, material=SOLID)
    slice_.add_wall(point=(0, 0, -1e-3), normal="z")
    slice_.add_wall(point=(0, 0, 1e-3), normal=(0, 0, -1))
    slice_.run(until=1e-6)


@pytest.mark.parametrize("arrangement", ["lattice", "poisson"])
def test_bodies_that_reach_into_each_other(arrangement) -> None:
    experiment = with_cube()
    ball = Ball(radius=0.01, centre=(0.015, 0.0, 0.0))
    experiment.add_body(ball, material=SOLID, name="ball", arrangement=arrangement)
    with pytest.raises(ScenarioError, match=r"overlaps (cube|ball): \d+ of its particles"):
        experiment.run(until=1e-6)


def test_bodies_that_touch_are_no_overlap() -> None:
    experiment = with_cube()
    experiment.add_body(CUBE.moved((0.02, 0.0, 0.0)), material=SOLID)
    experiment.run(until=1e-6)


def test_points_that_lie_on_each_other() -> None:
    experiment = Experiment(grid_spacing=2e-3)
    points = CUBE.lattice(1e-3).position
    for _ in range(2):
        experiment.add_points(points, volume=1e-9, material=SOLID)
    with pytest.raises(ScenarioError, match="overlaps points 2: 8000 particles lie on each other"):
        experiment.run(until=1e-6)


def test_particles_outside_of_the_box() -> None:
    experiment = with_cube(lower=(-1, -1, -1), upper=(0.005, 1, 1))
    with pytest.raises(ScenarioError, match=r"box: particle \d+ at .* lies outside"):
        experiment.run(until=1e-6)


def test_a_rigid_body_that_begins_inside() -> None:
    experiment = with_cube()
    experiment.add_rigid_body(RigidBody(shape=Sphere(5e-3), centre=(0.01, 0.0, 0.0), name="ball"))
    with pytest.raises(ProjectileError, match="ball: begins inside tissue"):
        experiment.run(until=1e-6)


def test_a_coarse_grid_for_a_projectile_is_told() -> None:
    experiment = with_cube()
    experiment.add_rigid_body(RigidBody(shape=Sphere(4e-3), centre=(0.03, 0, 0), name="ball"))
    with pytest.warns(UserWarning, match="ball is 4.0 cells across"):
        experiment.run(until=1e-6)


def test_a_sensor_with_nothing_inside() -> None:
    experiment = with_cube()
    experiment.add_sensor(RegionSensor(solid=CUBE.moved((1.0, 0.0, 0.0)), name="far"))
    with pytest.raises(ScenarioError, match="sensor far: there is no particle inside"):
        experiment.run(until=1e-6)


def test_nothing_is_added_once_it_runs() -> None:
    experiment = with_cube()
    experiment.run(until=1e-6)
    with pytest.raises(ScenarioError, match="add_body: the experiment has begun"):
        experiment.add_body(CUBE, material=SOLID)
    with pytest.raises(ScenarioError, match="must be after the present 1e-06 s"):
        experiment.run(until=1e-6)


def test_names_that_a_result_does_not_have() -> None:
    result = with_cube().run(until=1e-6)
    with pytest.raises(ScenarioError, match=r"body: 'cub' is not known. Did you mean 'cube'"):
        result.body("cub")
    with pytest.raises(ScenarioError, match="sensor: 'tip' is not known"):
        result.sensor("tip")
    with pytest.raises(ScenarioError, match="snapshots: none were taken"):
        result.snapshot(0.0)
    with pytest.raises(ScenarioError, match=r"does not end in .npz"):
        result.save("curves.csv")


def test_more_materials_than_the_solver_knows() -> None:
    experiment = Experiment(grid_spacing=2e-3)
    for index in range(16):
        experiment.add_body(CUBE, material=elastic(1000.0 + index, 1e6, 0.3))
    with pytest.raises(VulnusError, match="would be number 17 of at most 16"):
        experiment.add_body(CUBE, material=elastic(2000.0, 1e6, 0.3))
