"""Anything given in the place of any one value is taken, or refused as an error that says so."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import VulnusError
from vulnus.injury import (
    MATERIALS,
    PROJECTILES,
    Ball,
    BladeShape,
    Block,
    BodyPath,
    Box,
    Cylinder,
    Difference,
    Experiment,
    FunctionSolid,
    HalfSpace,
    Material,
    Ogive,
    PointSensor,
    Projectile,
    RegionSensor,
    RigidBody,
    Rod,
    SectionSensor,
    Shell,
    Sphere,
    Tube,
    Union,
    attitude,
    drucker_prager,
    elastic,
    liquid,
    material,
    neo_hookean,
    projectile,
    rotation_about,
    von_mises,
)

CUBE = Block(size=(0.012, 0.012, 0.012))
SOLID = elastic(1000.0, 1e6, 0.3)
POINTS = CUBE.moved((0.1, 0.0, 0.0)).lattice(1e-3).position


def with_cube(**options) -> Experiment:
    experiment = Experiment(**{"grid_spacing": 2e-3, **options})
    experiment.add_body(CUBE, material=SOLID, name="cube")
    return experiment


def adding(method: str):
    """A call of a method of an experiment, which is then started and read."""

    def call(**keywords) -> None:
        experiment = with_cube()
        getattr(experiment, method)(**keywords)
        experiment.fields()

    return call


def rigid(**keywords) -> None:
    experiment = with_cube()
    experiment.add_rigid_body(RigidBody(**keywords))
    experiment.fields()


def sensing(kind):
    def call(**keywords) -> None:
        experiment = with_cube()
        experiment.add_sensor(kind(**keywords))
        experiment.run(until=1e-8)

    return call


def fields_of(data) -> dict:
    return {name: getattr(data, name) for name in type(data).__dataclass_fields__}


ELASTIC = {"density": 1e3, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
AT = {"centre": (0, 0, 0), "rotation": np.eye(3)}
WAY = {"direction": (1, 0, 0), "yaw": 0, "pitch": 0, "roll": 0, "up": (0, 0, 1)}
CALLS = [
    (lambda **k: with_cube(**k).fields(), {
        "grid_spacing": 2e-3, "gravity": (0, 0, 0), "courant_number": 0.4, "threads": 1,
        "precision": "float32", "lower": (-1,) * 3, "upper": (1,) * 3, "grid_offset": (0, 0, 0),
    }),
    (adding("add_body"), {
        "solid": CUBE.moved((0.1, 0, 0)), "material": "fat", "velocity": (1, 0, 0),
        "particles_per_cell": 8, "arrangement": "lattice", "rotation": None, "name": "b",
    }),
    (adding("add_points"), {
        "position": POINTS, "volume": 1e-9, "material": "fat", "velocity": (0, 0, 0), "name": "p",
    }),
    (adding("add_labels"), {
        "labels": np.ones((6, 6, 6), int), "materials": {1: "fat"}, "spacing": 2e-3,
        "origin": (0.1, 0, 0), "names": {1: "f"}, "particles_per_cell": 8,
    }),
    (adding("set_state"), {
        "body": "cube", "velocity": (1, 0, 0), "stress": np.zeros((3, 3)), "damage": 0.1,
    }),
    (adding("add_rigid_body"), {"body": RigidBody(shape=Sphere(5e-3), centre=(-0.05, 0, 0))}),
    (adding("add_projectile"), {
        "projectile": "sphere_9mm_steel", "speed": 100, "direction": "x", "target": (0, 0, 0),
        "motion": "dynamic", "yaw_degrees": 0, "spin": 0, "friction": 0.1, "name": "s",
    }),
    (adding("add_wall"), {
        "point": (-6e-3, 0, 0), "normal": "x", "kind": "slip", "friction": 0,
        "velocity": (0, 0, 0),
    }),
    (adding("hold_ends"), {"axis": "x", "lower": -4e-3, "upper": 4e-3}),
    (adding("absorb_ends"), {"axis": "x", "thickness": 3e-3, "lower": -6e-3, "upper": 6e-3}),
    (adding("add_sensor"), {"sensor": PointSensor(position=(0, 0, 0))}),
    (adding("slow_waves"), {"sound_speed": 10.0}),
    (lambda **k: with_cube().run(**k), {
        "until": 1e-8, "sample_interval": 1e-8, "snapshot_interval": 1e-8, "progress": None,
        "checkpoint": None,
    }),
    (rigid, {
        "shape": Sphere(5e-3), "centre": (-0.05, 0, 0), "velocity": (9, 0, 0), "mass": 1e-3,
        "rotation": np.eye(3), "angular_velocity": (0, 0, 0), "motion": "dynamic", "path": None,
        "friction": 0.1, "cutting": False, "rail": None, "name": "b",
    }),
    (BodyPath, {"times": [0, 1], "positions": [[0, 0, 0], [1, 0, 0]]}),
    (Projectile, fields_of(PROJECTILES["9x19_fmj"])),
    (PROJECTILES["bb_4.5mm"].body, {"position": (0, 0, 0), **WAY, "speed": 9, "spin": 0}),
    (attitude, WAY),
    (rotation_about, {"axis": "x", "angle": 1.0}),
    (projectile, {"name": "22lr"}),
    (material, {"name": "skin"}),
    (Sphere, {"radius": 5e-3, "expansion_speed": 1.0}),
    (Cylinder, {"radius": 5e-3, "length": 0.01}),
    (Ogive, {"radius": 5e-3, "length": 0.01, "nose_length": 5e-3}),
    (Box, {"size": (0.01,) * 3}),
    (BladeShape, {"length": 0.03, "width": 0.01, "thickness": 4e-3, "tip_length": 0.01}),
    (Block, {"size": (0.01,) * 3, **AT}),
    (Ball, {"radius": 6e-3, **AT}),
    (Shell, {"inner_radius": 6e-3, "outer_radius": 0.012, **AT}),
    (Rod, {"radius": 6e-3, "length": 0.01, "axis": "z", **AT}),
    (Tube, {"inner_radius": 6e-3, "outer_radius": 0.012, "length": 0.01, "axis": "z"}),
    (HalfSpace, {"point": (0, 0, 0), "normal": "x"}),
    (Union, {"parts": (CUBE, CUBE)}),
    (Difference, {"whole": CUBE, "taken": CUBE}),
    (FunctionSolid, {"function": lambda x: x[:, 0], "lower": (-1,) * 3, "upper": (1,) * 3}),
    (CUBE.moved, {"by": (0, 0, 1)}),
    (CUBE.rotated, {"rotation": np.eye(3), "about": (0, 0, 0)}),
    (CUBE.contains, {"points": POINTS}),
    (CUBE.lattice, {"spacing": 1e-3}),
    (sensing(PointSensor), {
        "position": (0, 0, 0), "radius": 3e-3, "quantities": ("stress",), "fixed": False,
    }),
    (sensing(RegionSensor), {"solid": CUBE, "quantities": ("damage",), "name": "s"}),
    (sensing(SectionSensor), {"point": (0, 0, 0), "normal": "x", "body": "cube"}),
    (elastic, ELASTIC),
    (neo_hookean, {"density": 1e3, "shear_modulus": 1e6, "bulk_modulus": 1e7}),
    (von_mises, {**ELASTIC, "yield_stress": 1e5, "hardening": 0.0}),
    (drucker_prager, {**ELASTIC, "yield_stress": 1e5, "friction": 0.5}),
    (liquid, {"density": 1e3, "bulk_modulus": 1e8, "cavitation_pressure": 1e5}),
    (Material, fields_of(MATERIALS["muscle"])),
]  # fmt: skip
PLACES = [(call, base, key) for call, base in CALLS for key in base]
JUNK = [
    None, "x", "1", b"x", True, np.nan, np.inf, -1, -1.5, 0, 2, 1e300, 1e30, 1e10, 1e-300, 1e-12,
    10**400, 3 + 4j, [], (), (1, 2), (1, 2, 3, 4), (np.nan, 0, 0), (0, 0, 0), (1e300, 1e300, 0),
    ("a", "b", "c"), {}, {1: 2}, object(), [[1, 2], [3]], np.ones(3), np.zeros((3, 3)),
    np.zeros((0, 3)), np.array("x"), len, lambda x: x, lambda x: x[10**9], range(3), Block, CUBE,
    SOLID, Path("x.npz"), np.float32(1e-3), np.int64(3),
]  # fmt: skip
EXAMPLES = 400


def test_anything_in_the_place_of_any_value_is_taken_or_refused() -> None:
    refused = []

    @settings(deadline=None, derandomize=True, max_examples=EXAMPLES)
    @given(place=st.sampled_from(PLACES), junk=st.integers(0, len(JUNK) - 1))
    def attempt(place, junk: int) -> None:
        call, base, key = place
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                call(**base | {key: JUNK[junk]})
            except VulnusError as error:
                refused.append(error)

    attempt()
    assert len(refused) > 0.5 * EXAMPLES
    assert all(error.subject and error.problem and error.advice for error in refused)


def test_every_call_works_without_junk() -> None:
    for call, base in CALLS:
        call(**base)
