"""Bodies that begin under stress, damaged or moving, read back what they were given."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import ScenarioError
from vulnus.injury import Block, Experiment, PointSensor, elastic

CUBE = Block(size=(0.012, 0.012, 0.012), centre=(0.006, 0.006, 0.006))
STRESS = np.array([[3e4, 5e3, 0.0], [5e3, 1e4, -2e3], [0.0, -2e3, -2e4]])


def cube(material) -> Experiment:
    experiment = Experiment(grid_spacing=2e-3, precision="float64")
    experiment.add_body(CUBE, material=material, name="cube")
    return experiment


@pytest.mark.parametrize(
    "material",
    ["muscle", "fat", "skin", "gelatin_10", "cortical_bone", "cancellous_bone", "copper"],
)
def test_a_stress_is_read_back_from_every_law(material):
    experiment = cube(material)
    factor = 0.1 if material == "fat" else 1.0
    experiment.set_state("cube", stress=factor * STRESS)
    fields = experiment.fields()
    # 1e-9 of 14 GPa, the largest modulus; copper has more, and no more error.
    assert fields.stress == pytest.approx(np.broadcast_to(factor * STRESS, (1728, 3, 3)), abs=20.0)
    assert fields.damage.max() == 0.0
    assert (fields.volume * fields.volume_ratio).sum() == pytest.approx(CUBE.volume, rel=1e-9)


def test_values_may_be_arrays_or_functions_of_the_place():
    experiment = cube(elastic(1000.0, 1e6, 0.3))
    experiment.set_state(
        "cube",
        velocity=lambda x: x * 10.0,
        stress=lambda x: -1e4 * x[:, :1, None] / 0.012 * np.eye(3),
        damage=np.linspace(0.0, 1.0, 1728),
        plastic_strain=0.2,
    )
    fields = experiment.fields()
    assert fields.pressure == pytest.approx(1e4 * fields.position[:, 0] / 0.012, abs=0.01)
    assert fields.velocity == pytest.approx(10.0 * fields.position)
    assert fields.damage == pytest.approx(np.linspace(0.0, 1.0, 1728))
    assert fields.plastic_strain == pytest.approx(np.full(1728, 0.2))


def test_a_second_state_replaces_the_first():
    experiment = cube(elastic(1000.0, 1e6, 0.3))
    experiment.set_state("cube", stress=1e5 * np.eye(3), damage=0.5)
    experiment.set_state("cube", velocity=(1.0, 0.0, 0.0))
    fields = experiment.fields()
    assert np.abs(fields.stress).max() == 0.0
    assert fields.damage.max() == 0.0
    assert fields.mass.sum() == pytest.approx(1000.0 * CUBE.volume, rel=1e-12)


def test_pressure_between_walls_stays_and_without_walls_drives_the_body_apart():
    """Six slip walls keep a cube under pressure in equilibrium to round-off; free, it expands."""
    pressure = 2e4
    held, free = cube(elastic(1000.0, 1e6, 0.3)), cube(elastic(1000.0, 1e6, 0.3))
    for axis in np.eye(3):
        held.add_wall(point=(0.0, 0.0, 0.0), normal=axis)
        held.add_wall(point=0.012 * axis, normal=-axis)
    results = []
    for experiment in (held, free):
        experiment.set_state("cube", stress=-pressure * np.eye(3))
        experiment.add_sensor(PointSensor(position=(6e-3, 6e-3, 6e-3), name="middle"))
        results.append(experiment.run(until=3e-4))
    inside = results[0].sensor("middle")["pressure"]
    assert inside == pytest.approx(np.full(len(inside), pressure), rel=1e-3)
    energy = results[0].energies
    assert energy["kinetic"].max() < 1e-3 * energy["elastic"][0]
    expanded = results[1].energies
    assert expanded["kinetic"].max() > 0.3 * expanded["elastic"][0]


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"stress": np.diag([9e7, 0.0, 0.0])}, "beyond what the material bears"),
        ({"stress": np.array([[0, 1.0, 0], [0, 0, 0], [0, 0, 0]])}, "is not symmetric"),
        ({"stress": (1.0, 2.0)}, "has the shape"),
        ({"stress": lambda x: np.full((len(x), 3, 3), np.nan)}, "not finite"),
        ({"damage": 1.5}, "must be from 0 to 1"),
        ({"damage": np.zeros(3)}, "has the shape"),
        ({"plastic_strain": -0.1}, "must be >= 0"),
        ({"velocity": (1.0, 2.0)}, "does not fit"),
    ],
)
def test_what_cannot_be_is_refused(wrong, told):
    with pytest.raises(ScenarioError, match=told):
        cube("muscle").set_state("cube", **wrong)


def test_an_unknown_body_is_refused_with_the_nearest_name():
    with pytest.raises(ScenarioError, match="Did you mean 'cube'"):
        cube("muscle").set_state("cub", damage=1.0)
