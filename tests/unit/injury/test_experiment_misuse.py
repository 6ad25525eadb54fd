"""What would run as nonsense is refused or warned of; values of a wrong kind never get inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vulnus.core.errors import InputFileError, ScenarioError, StorageError
from vulnus.injury import (
    PROJECTILES,
    Ball,
    Block,
    BodyPath,
    Box,
    Cylinder,
    Experiment,
    HalfSpace,
    Material,
    MeshShape,
    PointSensor,
    RegionSensor,
    RigidBody,
    Shell,
    Sphere,
    attitude,
    elastic,
    neo_hookean,
)
from vulnus.storage import FileCheckpoint

SOLID = elastic(1000.0, 1e6, 0.3)
CUBE = Block(size=(0.012, 0.012, 0.012))
POINTS = CUBE.lattice(1e-3).position
STEEL = {"mass": 4e-3, "motion": "dynamic"}


def with_cube(**options) -> Experiment:
    experiment = Experiment(**{"grid_spacing": 2e-3, **options})
    experiment.add_body(CUBE, material=SOLID, name="cube")
    return experiment


def ball_at(x: float, y: float = 0.0, **options) -> RigidBody:
    return RigidBody(**{"shape": Sphere(5e-3), "centre": (x, y, 0.0), "name": "ball", **options})


def points_apart(position, volume: float) -> None:
    Experiment(grid_spacing=2e-3).add_points(position, volume=volume, material=SOLID)


@pytest.mark.parametrize(
    ("position", "volume", "said"),
    [
        (POINTS, 1.0, r"volume: of particle 0 is 1 m³, a cube of 500 cells, must be at most 2"),
        (POINTS, 5e-8, "is that of cubes of 0.00368403 m, but the points are 0.001 m apart"),
        (POINTS, 1e-13, "Each should stand for about 1e-09 m³"),
        (np.concatenate([POINTS, POINTS]), 1e-9, "3456 points lie on others, the first"),
        (300.0 * POINTS, 1e-9, "points 0.3 m apart, 150 cells of 0.002 m, must be at most 1.5"),
    ],
)
def test_points_that_make_no_body(position, volume: float, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        points_apart(position, volume)


def test_points_that_fall_to_pieces_are_warned_of_and_scattered_ones_are_fine() -> None:
    with pytest.warns(UserWarning, match="it falls to pieces"):
        points_apart(2.4 * POINTS, 1.4e-8)
    generator = np.random.default_rng(1)
    points_apart(generator.uniform(0.0, 0.02, (8000, 3)), 1e-9)
    points_apart([[0.0, 0.0, 0.0]], 1e-9)


def test_refused_points_are_not_kept() -> None:
    experiment = with_cube()
    with pytest.raises(ScenarioError, match="lie on others"):
        experiment.add_points(np.zeros((2, 3)), volume=1e-9, material=SOLID)
    assert experiment.body_names == ("cube",)


@pytest.mark.parametrize("thickness", [1e-3, 3e-3])
def test_a_combined_solid_is_as_thin_as_it_is(thickness: float) -> None:
    shell = Ball(radius=0.02) - Ball(radius=0.02 - thickness)
    for solid in (shell, shell & Ball(radius=0.03)):
        experiment = Experiment(grid_spacing=2e-3)
        experiment.add_body(solid, material=SOLID)
        with pytest.raises(ScenarioError, match="thin at its thickest"):
            experiment.run(until=1e-7)


def test_a_combined_shell_of_two_cells_runs() -> None:
    experiment = Experiment(grid_spacing=2e-3)
    experiment.add_body(Ball(radius=0.014) - Ball(radius=0.0099), material=SOLID)
    experiment.run(until=1e-7)


@pytest.mark.parametrize(
    ("add", "said"),
    [
        (lambda e: e.add_wall(point=(0, 0, 0), normal="x"), "has tissue 0.0055 m behind it"),
        (lambda e: e.add_wall(point=(0.01, 0, 0), normal="x"), "has all tissue behind it"),
        (lambda e: e.hold_ends(axis="x"), "lower: is missing, and so is upper"),
        (lambda e: e.hold_ends(axis="x", lower=0.5), "holds all tissue: tissue spans"),
        (lambda e: e.hold_ends(axis="x", lower=-0.1, upper=0.1), "holds nothing"),
        (
            lambda e: e.absorb_ends(axis="x", lower=-6e-3, upper=6e-3, thickness=0.02),
            "has a thickness of 0.02 m, must be less than half",
        ),
    ],
)
def test_boundaries_that_miss_the_body(add, said: str) -> None:
    experiment = with_cube()

    def attempt() -> None:
        add(experiment)
        experiment.run(until=1e-7)

    with pytest.raises(ScenarioError, match=said):
        attempt()


def test_a_wall_between_nodes_is_warned_of() -> None:
    experiment = with_cube()
    experiment.add_wall(point=(-5.5e-3, 0, 0), normal="x")
    with pytest.warns(UserWarning, match=r"0.25 cells from the nearest layer of nodes at -0.006 m"):
        experiment.run(until=1e-7)


@pytest.mark.parametrize(
    ("bodies", "said"),
    [
        ([ball_at(-0.02, **STEEL)] * 2, "are in one another"),
        (
            [ball_at(-0.02, **STEEL), ball_at(-0.022, shape=Cylinder(4e-3, 0.01))],
            "are in one another",
        ),
        ([ball_at(-3.0, shape=Sphere(2.25))], r"is 4.5 m across, must be at most 1 m"),
        ([ball_at(1e12)], "must be within"),
    ],
)
def test_rigid_bodies_that_do_not_fit(bodies, said: str) -> None:
    experiment = with_cube()
    for number, body in enumerate(bodies):
        experiment.add_rigid_body(replace(body, name=f"body {number}"))
    with pytest.raises(ScenarioError, match=said):
        experiment.run(until=1e-7)


def test_kinematic_bodies_may_make_one_tool() -> None:
    experiment = with_cube()
    experiment.add_rigid_body(ball_at(-0.02))
    experiment.add_rigid_body(ball_at(-0.024, name="handle"))
    experiment.run(until=1e-7)


def test_half_a_free_body_at_a_plane_of_symmetry_is_refused_unless_on_a_rail() -> None:
    def half(body: RigidBody) -> Experiment:
        experiment = Experiment(grid_spacing=2e-3)
        upper = Block(size=(0.012, 0.006, 0.012), centre=(0, 3e-3, 0))
        experiment.add_body(upper, material=SOLID)
        experiment.add_wall(point=(0, 0, 0), normal="y")
        experiment.add_rigid_body(body)
        return experiment

    free = ball_at(-0.02, velocity=(10, 0, 0), **STEEL)
    with pytest.raises(ScenarioError, match=r"reaches 0.005 m behind a slip wall"):
        half(free).run(until=1e-7)
    half(replace(free, rail=(1, 0, 0))).run(until=1e-7)
    half(replace(free, motion="kinematic")).run(until=1e-7)


def test_a_piston_between_two_slip_walls_is_no_half_body() -> None:
    experiment = with_cube()
    for side in (-1.0, 1.0):
        experiment.add_wall(point=(0, side * 6e-3, 0), normal=(0, -side, 0))
    experiment.add_rigid_body(ball_at(-0.015, shape=Box((0.01, 0.016, 0.012)), **STEEL))
    experiment.run(until=1e-7)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ball_at(0, velocity="fast"), "ball velocity: is 'fast', must be three"),
        (lambda: ball_at(0, velocity=(1, 2)), r"ball velocity: is \(1, 2\)"),
        (lambda: ball_at(0, velocity=(1e6, 0, 0)), "ball speed: is 1e[+]06 m/s, must be at most"),
        (lambda: RigidBody(shape=Sphere(1e-3), centre=(1, 2)), "projectile centre"),
        (lambda: ball_at(0, shape="sphere"), "ball shape: is 'sphere'"),
        (lambda: ball_at(0, shape=Ball(radius=5e-3)), r"ball shape: is Ball\("),
        (lambda: ball_at(0, friction="a"), "ball friction: is 'a'"),
        (lambda: ball_at(0, rotation=np.ones((3, 3))), "ball rotation: is not a rotation"),
        (lambda: ball_at(0, mass=-1.0), "ball mass: is -1.0, must be > 0"),
        (lambda: ball_at(0, mass=float("nan")), "ball mass: is nan, must be > 0"),
        (lambda: ball_at(0, path="in and out"), "ball path: is 'in and out'"),
        (lambda: BodyPath("now", "here"), "path times"),
        (lambda: Sphere(5e-3, expansion_speed=float("nan")), "expansion_speed: is nan"),
        (lambda: Sphere(5e-3, expansion_speed=-1.0), "expansion_speed: is -1, must be >= 0"),
        (lambda: Sphere("5 mm"), "sphere radius: is '5 mm'"),
        (lambda: Box(5), "box size: is 5"),
        (lambda: Cylinder(1e5, 0.01).volume, "too slender to be sampled"),
        (lambda: RegionSensor(solid=5), "sensor solid: is 5"),
        (lambda: PointSensor(position=(0, 0, 0), quantities=()), "quantities: are none"),
        (lambda: Material(density="1000", bulk_modulus=1e9), "density: is '1000'"),
        (lambda: Material(density=True, bulk_modulus=1e9), "density: is True"),
        (lambda: neo_hookean("a", 1.0, 1.0), "density: is 'a'"),
        (lambda: elastic(1000.0, "1e6", 0.3), "youngs_modulus: is '1e6'"),
        (lambda: replace(PROJECTILES["bb_4.5mm"], shape="banana"), "shape: 'banana' is not known"),
        (lambda: replace(PROJECTILES["bb_4.5mm"], shape="stl"), "MeshShape.from_stl"),
        (lambda: replace(PROJECTILES["bb_4.5mm"], mass=0.0), "mass: is 0, must be > 0"),
        (lambda: CUBE - 5, "parts: are"),
        (lambda: Block(size=(20.0, 1e-12, 1.0)), "size along y: is 1e-12 m, must be 1e-09 to"),
        (lambda: Experiment(grid_spacing=2e-3, threads=1.5), "must be a whole number"),
        (lambda: with_cube().run(until="1e-3"), "until: is '1e-3'"),
        (lambda: with_cube().run(until=1.0, sample_interval=1e-9), "sample_interval: is 1e-09"),
        (lambda: with_cube().run(until=1e-7, checkpoint="state.h5"), "checkpoint: is 'state.h5'"),
        (lambda: with_cube().run(until=1e-7, on_sample=3), "on_sample: is 3"),
        (lambda: with_cube(grid_spacing=1e-5 / 3), r"takes 4.7e\+10 points|at most 2e\+08"),
    ],
)
def test_values_of_a_wrong_kind(make, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        make()


def test_what_is_meant_well_is_taken() -> None:
    turn = Rotation.from_euler("z", 30, degrees=True)
    body = ball_at(-0.05, rotation=turn, velocity=np.array([1.0, 0, 0]))
    assert np.array_equal(body.turn, turn.as_matrix())
    path = BodyPath([0, 1e-3], [[-0.02, 0, 0], [0, 0, 0]])
    assert RigidBody(shape=Sphere(5e-3), path=path).place == (-0.02, 0.0, 0.0)
    assert attitude("-x")[:, 0] == pytest.approx([-1.0, 0.0, 0.0])
    half = CUBE & HalfSpace(point=(0, 0, 0), normal="-z")
    assert half.volume == pytest.approx(0.5 * CUBE.volume, rel=0.01)
    assert Shell(inner_radius=1, outer_radius=2).volume > 0.0


def test_large_cells_are_warned_of() -> None:
    with pytest.warns(UserWarning, match="lengths are metres: 2e-3 is 2 mm"):
        Experiment(grid_spacing=2)


def test_a_run_within_a_run_is_refused() -> None:
    with pytest.raises(ScenarioError, match="is called from within run"):
        with_cube().run(until=1e-7, on_sample=lambda e: e.run(until=1e-6))


def test_functions_that_fail_say_so() -> None:
    with pytest.raises(ScenarioError, match="the function failed with IndexError"):
        Experiment(grid_spacing=2e-3).add_body(CUBE, material=SOLID, velocity=lambda x: x[10**9])


def test_a_shot_that_passes_by_is_warned_of() -> None:
    experiment = with_cube()
    experiment.add_rigid_body(ball_at(-0.02, 0.1, velocity=(10, 0, 0)))
    with pytest.warns(UserWarning, match="meets no tissue on its line of flight"):
        experiment.run(until=1e-7)


def test_what_is_read_of_no_particles(tmp_path) -> None:
    result = with_cube().run(until=1e-7)
    nothing = result.final.where(result.final.damage > 2.0)
    assert nothing.cavity_volume() == 0.0
    with pytest.raises(ScenarioError, match="extent: there are no particles"):
        _ = nothing.extent
    with pytest.raises(ScenarioError, match="chosen: has the shape"):
        result.final.where([True])
    with pytest.raises(StorageError, match=r"the folder .* does not exist"):
        result.save(tmp_path / "missing" / "curves.npz")
    with pytest.raises(ScenarioError, match="path: is 5"):
        result.save(5)
    checkpoint = FileCheckpoint(str(tmp_path / "state.h5"), interval=0.0, notice=print)
    with_cube().run(until=1e-7, checkpoint=checkpoint)
    assert (tmp_path / "state.h5").is_file()


@pytest.mark.parametrize("content", [b"hello", b"", b"\0" * 200, b"solid nothing\nendsolid"])
def test_a_file_that_is_no_stl_is_refused_in_silence(content, tmp_path, capfd, caplog) -> None:
    path = tmp_path / "shape.stl"
    path.write_bytes(content)
    with pytest.raises(InputFileError, match="is no STL file"):
        MeshShape.from_stl(path)
    assert capfd.readouterr() == ("", "")
    assert not caplog.records
