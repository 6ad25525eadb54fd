"""Parameters and materials: defaults that hold together, and values that are refused by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb

from vulnus.core.errors import AnatomyError, ScenarioError
from vulnus.injury import AimParameters, InjuryParameters, MpmSolver
from vulnus.injury.materials import MUSCLE, material_table
from vulnus.injury.parameters import ProjectileParameters
from vulnus.injury.shot.setup import long_axis, prepare_shot

AIMED = InjuryParameters(
    aim=AimParameters(target=(0.0, 0.0, 0.0)), window_length=0.05, absorbing_length=0.006
)


@pytest.fixture(scope="module")
def limb():
    return synthetic_limb(spacing=0.004)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("grid_spacing", 0.0),
        ("grid_spacing", -0.003),
        ("duration", float("nan")),
        ("relaxation_frame_interval", 0.0),
        ("phase_one", -1e-3),
        ("relaxation_sound_speed", -1.0),
        ("mode", "papers"),
        ("bleeds_from", "end"),
        ("frame_interval", 0.0),
        ("courant_number", 1.5),
        ("bone_modulus_scale", 0.0),
        ("window_length", 0.01),
        ("laceration_threshold", 0.95),
    ],
)
def test_impossible_values_are_refused_by_key(limb, key, value):
    with pytest.raises(ScenarioError) as error:
        prepare_shot(limb, replace(AIMED, **{key: value}))
    assert key in error.value.subject


def test_cells_finer_than_the_particles_are_refused(limb):
    with pytest.raises(ScenarioError, match="spacing"):
        prepare_shot(limb, replace(AIMED, grid_spacing=0.5 * limb.spacing))


def test_a_ball_that_could_slip_between_nodes_is_said_to_be_grown(limb):
    small = ProjectileParameters(diameter=0.003)
    with pytest.warns(UserWarning, match=r"3\.0 mm on cells of 5\.0 mm acts as one of 9\.0 mm"):
        prepare_shot(limb, replace(AIMED, projectile=small, grid_spacing=0.005))


def test_a_limb_without_particles_is_refused(limb):
    empty = replace(
        limb,
        position=np.zeros((0, 3), np.float32),
        tissue=np.zeros(0, np.uint8),
        volume=np.zeros(0, np.float32),
    )
    with pytest.raises(AnatomyError):
        prepare_shot(empty, AIMED)


def test_the_window_lies_around_the_track(limb):
    setup = prepare_shot(limb, replace(AIMED, aim=AimParameters(target=(0.0, 0.0, 0.01))))
    height = limb.position[setup.simulated, 2]
    assert height.min() == pytest.approx(0.01 - 0.025, abs=0.004)
    assert height.max() == pytest.approx(0.01 + 0.025, abs=0.004)
    whole = prepare_shot(limb, replace(AIMED, window_length=None))
    assert len(whole.simulated) == len(limb.position)


def test_the_long_axis_of_a_cylinder_is_its_axis(limb):
    axis = long_axis(np.asarray(limb.position, np.float64))
    assert axis[2] > 0.999


def test_a_particle_without_a_material_row_is_refused():
    solver = MpmSolver(
        materials=material_table([MUSCLE], 0.002), grid_spacing=0.002, lower=(-1.0,) * 3,
        upper=(1.0,) * 3,
    )  # fmt: skip
    with pytest.raises(ScenarioError, match="row 3"):
        solver.set_particles(np.zeros((1, 3)), volume=np.ones(1), material=np.array([3], np.uint8))


@pytest.mark.parametrize("key", ["grid_spacing", "courant_number"])
def test_the_solver_refuses_what_is_not_positive(key):
    good = {"grid_spacing": 0.002, "courant_number": 0.4}
    with pytest.raises(ScenarioError) as error:
        MpmSolver(
            materials=material_table([MUSCLE], 0.002), lower=(-1.0,) * 3, upper=(1.0,) * 3,
            **{**good, key: 0.0},
        )  # fmt: skip
    assert error.value.subject == key


def test_a_state_in_the_middle_of_an_epoch_is_refused():
    solver = MpmSolver(
        materials=material_table([MUSCLE], 0.002), grid_spacing=0.002, lower=(-1.0,) * 3,
        upper=(1.0,) * 3,
    )  # fmt: skip
    solver.set_particles(np.zeros((1, 3)), volume=np.full(1, 1e-9), material=np.zeros(1, np.uint8))
    solver.advance(until=1.0, max_steps=3)
    assert not solver.synchronized
    with pytest.raises(Exception, match="epoch"):
        solver.state()
