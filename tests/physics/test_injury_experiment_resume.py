"""A script that was killed and started again ends with the same bits, or is refused with reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vulnus.core.errors import StorageError
from vulnus.injury import (
    Ball,
    Block,
    BodyPath,
    Cylinder,
    Experiment,
    ExperimentResult,
    FunctionSolid,
    PointSensor,
    RegionSensor,
    RigidBody,
    Sphere,
    elastic,
)
from vulnus.storage import FileCheckpoint

pytestmark = pytest.mark.physics

SOLID = elastic(1000.0, 1e6, 0.3)
CUBE = Block(size=(0.012, 0.012, 0.012))
BALL = RigidBody(
    shape=Sphere(5e-3), centre=(-0.0115, 0, 0), velocity=(20.0, 0, 0), mass=4e-3,
    motion="dynamic", name="ball",
)  # fmt: skip


class KilledError(Exception):
    """Stands for a signal that ends the process."""


class MemoryCheckpoint:
    """Keeps a checkpoint as often as asked, and dies after some of them."""

    def __init__(self, most: int = 1000) -> None:
        self.data = None
        self.left = most

    def load(self):
        return self.data

    def save(self, data) -> None:
        self.data = data
        self.left -= 1
        if self.left == 0:
            raise KilledError

    def due(self) -> bool:
        return True


def struck_cube(body: RigidBody = BALL, **options) -> Experiment:
    experiment = Experiment(**{"grid_spacing": 2e-3, **options})
    experiment.add_body(CUBE, material=SOLID, name="cube")
    experiment.add_rigid_body(body)
    experiment.add_sensor(PointSensor(position=(0.0, 0.0, 0.0), name="inside"))
    return experiment


def script(checkpoint=None) -> list[ExperimentResult]:
    """Until the ball is slower, then on with slower waves, then on in two steps."""
    experiment = struck_cube()
    how = {"sample_interval": 5e-5, "snapshot_interval": 1e-4, "checkpoint": checkpoint}
    results = [
        experiment.run(
            until=1e-3, stop_when=lambda e: e.rigid_body("ball").velocity[0] < 19.5, **how
        )
    ]
    experiment.slow_waves(20.0)
    results.append(experiment.run(until=experiment.time + 1e-4, **how))
    results.append(experiment.run(until=experiment.time + 2e-4, **how))
    return results


def assert_same(one: ExperimentResult, other: ExperimentResult) -> None:
    assert one.columns.keys() == other.columns.keys()
    for name, values in one.columns.items():
        assert np.array_equal(other.columns[name], values, equal_nan=True), name
    for name, values in one.final.arrays().items():
        assert np.array_equal(getattr(other.final, name), values, equal_nan=True), name
    assert [s.time for s in one.snapshots] == [s.time for s in other.snapshots]
    assert (one.steps, one.stopped_early) == (other.steps, other.stopped_early)


def test_a_script_killed_anywhere_ends_with_the_same_bits() -> None:
    """In each of its three runs, at the end of any epoch."""
    whole = script()
    counts = [len(result.time) for result in whole]
    assert whole[0].stopped_early
    assert counts[0] < counts[1] < counts[2]
    assert whole[0].time[-1] < 1e-3
    runs = set()
    for saves in range(1, 1000):
        kept = MemoryCheckpoint(most=saves)
        try:
            script(kept)
        except KilledError:
            runs.add(int(kept.data["run"]))
        else:
            break
        kept.left = 1000
        for mine, yours in zip(script(kept), whole, strict=True):
            assert_same(mine, yours)
    assert runs == {0, 1, 2}


def test_a_first_run_without_a_checkpoint_is_computed_again(tmp_path) -> None:
    def two_runs(checkpoint) -> ExperimentResult:
        experiment = struck_cube()
        experiment.run(until=5e-5, sample_interval=5e-5)
        return experiment.run(until=2e-4, sample_interval=5e-5, checkpoint=checkpoint)

    def on_file() -> FileCheckpoint:
        return FileCheckpoint(str(tmp_path / "state.h5"), interval=0.0, notice=pytest.fail)

    whole = two_runs(None)
    assert_same(two_runs(on_file()), whole)
    assert_same(two_runs(on_file()), whole)


def test_runs_that_do_not_fit_the_checkpoint_are_refused() -> None:
    kept = MemoryCheckpoint()
    script(kept)
    how = {"sample_interval": 5e-5, "snapshot_interval": 1e-4, "checkpoint": kept}
    with pytest.raises(StorageError, match=r"run 1 of it had until 0.001, has 0.002 now"):
        struck_cube().run(until=2e-3, **how)
    with pytest.raises(StorageError, match=r"run 1 of it had sample_interval 5e-05, has 0.0001"):
        struck_cube().run(until=1e-3, **how | {"sample_interval": 1e-4})
    experiment = struck_cube()
    experiment.run(until=1e-3, **how)
    with pytest.raises(StorageError, match="slow_waves was called otherwise"):
        experiment.run(until=experiment.time + 1e-4, **how)
    early = MemoryCheckpoint()
    struck_cube().run(until=1e-4, sample_interval=5e-5, checkpoint=early)
    with pytest.raises(StorageError, match=r"was at 0.0001 s, after until = 5e-05 s"):
        struck_cube().run(until=5e-5, checkpoint=early)


PATH = BodyPath(np.array([0.0, 1e-4]), np.array([[-0.0115, 0, 0], [-0.01, 0, 0]]))
GUIDED = RigidBody(shape=Sphere(5e-3), path=PATH, name="ball")
DIGEST = " differs"


def with_more(body: RigidBody = BALL, **calls) -> Experiment:
    experiment = struck_cube(body)
    for name, keywords in calls.items():
        getattr(experiment, name)(**keywords)
    return experiment


def sensed(solid) -> dict:
    return {"add_sensor": {"sensor": RegionSensor(solid=solid, name="part", fixed=True)}}


def lump(height: float) -> FunctionSolid:
    return FunctionSolid(
        function=lambda x: np.linalg.norm(x, axis=1) - 4e-3 - height,
        lower=(-0.01,) * 3,
        upper=(0.01,) * 3,
    )


WALL = {"point": (0.006, 0, 0), "normal": (-1, 0, 0)}


@pytest.mark.parametrize(
    ("first", "second", "named"),
    [
        (struck_cube, lambda: struck_cube(courant_number=0.3), "courant_number was 0.4, is 0.3"),
        (struck_cube, lambda: struck_cube(gravity=(0, 0, -9.81)), "gravity was"),
        (struck_cube, lambda: struck_cube(precision="float64"), "precision was 'float32'"),
        (struck_cube, lambda: struck_cube(grid_offset=(1e-3, 0, 0)), "grid_offset was"),
        (struck_cube, lambda: struck_cube(lower=(-1,) * 3, upper=(1,) * 3), "box was None"),
        (struck_cube, lambda: struck_cube(replace(BALL, friction=0.2)), "ball: friction was"),
        (struck_cube, lambda: struck_cube(replace(BALL, mass=5e-3)), "ball: mass was"),
        (struck_cube, lambda: struck_cube(replace(BALL, rail=(1, 0, 0))), "ball: rail was None"),
        (struck_cube, lambda: struck_cube(replace(BALL, name="b")), "names of the rigid bodies"),
        (
            struck_cube,
            lambda: struck_cube(replace(BALL, shape=Sphere(5e-3, expansion_speed=1.0))),
            "ball: shape: expansion_speed was 0.0, is 1.0",
        ),
        (
            lambda: struck_cube(replace(BALL, shape=Cylinder(5e-3, 0.01))),
            lambda: struck_cube(replace(BALL, shape=Cylinder(0.01 / 3, 0.01))),
            "ball: shape: radius was 0.005",
        ),
        (
            lambda: struck_cube(GUIDED),
            lambda: struck_cube(replace(GUIDED, path=BodyPath(PATH.times, PATH.positions * 1.01))),
            "ball: path: positions was",
        ),
        (
            lambda: struck_cube(GUIDED),
            lambda: struck_cube(replace(GUIDED, cutting=True)),
            "ball: cutting was False, is True",
        ),
        (struck_cube, lambda: with_more(add_wall=WALL), "boundary 1: kind was not there"),
        (
            lambda: with_more(add_wall=WALL),
            lambda: with_more(add_wall={**WALL, "kind": "fixed"}),
            "boundary 1: kind was 'slip', is 'fixed'",
        ),
        (
            lambda: with_more(**sensed(Ball(radius=5e-3))),
            struck_cube,
            "sensor part: kind is not there any more",
        ),
        (
            lambda: with_more(**sensed(lump(0.0))),
            lambda: with_more(**sensed(lump(1e-4))),
            "sensor part: solid differs",
        ),
        (
            lambda: with_more(add_body={"solid": CUBE.moved((0.1, 0, 0)), "material": "muscle"}),
            lambda: with_more(add_body={"solid": CUBE.moved((0.1, 0, 0)), "material": "fat"}),
            "body 1: material: density was 1060.0",
        ),
        (
            lambda: with_more(add_body={"solid": CUBE.moved((0.1, 0, 0)), "material": "fat"}),
            lambda: with_more(add_body={"solid": CUBE.moved((0.2, 0, 0)), "material": "fat"}),
            "body 1: position differs",
        ),
    ],
)
def test_a_checkpoint_of_another_experiment_is_refused(first, second, named: str) -> None:
    kept = MemoryCheckpoint()
    first().run(until=1e-6, sample_interval=5e-7, checkpoint=kept)
    assert kept.data is not None
    second_time = first().run(until=2e-6, sample_interval=5e-7, checkpoint=kept)
    assert len(second_time.time) == 5
    with pytest.raises(StorageError, match=named):
        second().run(until=3e-6, sample_interval=5e-7, checkpoint=kept)
