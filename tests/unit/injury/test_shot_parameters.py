"""Parameters and materials: defaults that hold together, and values that are refused by name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb

from vulnus.core.errors import AnatomyError, ScenarioError
from vulnus.core.handoff import Tissue
from vulnus.injury import AimParameters, InjuryParameters, MpmSolver
from vulnus.injury.materials import COLUMNS, MUSCLE, TISSUE_MATERIALS, material_table, tissue_table
from vulnus.injury.shot_setup import contact_radius, long_axis, prepare_shot

AIMED = InjuryParameters(aim=AimParameters(target=(0.0, 0.0, 0.0)), window_length=0.05)


@pytest.fixture(scope="module")
def limb():
    return synthetic_limb(spacing=0.004)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("grid_spacing", 0.0),
        ("grid_spacing", -0.003),
        ("duration", float("nan")),
        ("frame_interval", 0.0),
        ("courant_number", 1.5),
        ("bone_modulus_scale", 0.0),
        ("window_length", 0.01),
    ],
)
def test_impossible_values_are_refused_by_key(limb, key, value):
    with pytest.raises(ScenarioError) as error:
        prepare_shot(limb, replace(AIMED, **{key: value}))
    assert key in error.value.subject


def test_cells_finer_than_the_particles_are_refused(limb):
    with pytest.raises(ScenarioError, match="spacing"):
        prepare_shot(limb, replace(AIMED, grid_spacing=0.5 * limb.spacing))


def test_a_ball_that_could_slip_between_nodes_is_grown_and_said_so():
    assert contact_radius(0.009, 0.003) == 0.0045
    with pytest.warns(UserWarning, match=r"3\.0 mm on cells of 3\.0 mm acts as one of 5\.4 mm"):
        assert contact_radius(0.003, 0.003) == pytest.approx(0.0027)


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


def test_every_tissue_has_a_material_with_positive_constants():
    for tissue in Tissue:
        if tissue is not Tissue.AIR:
            material = TISSUE_MATERIALS[tissue]
            assert min(material.density, material.bulk_modulus, material.shear_modulus) > 0.0
    table = tissue_table(0.003)
    assert table.shape == (8, len(COLUMNS))
    assert np.all(np.isfinite(table))
    start, end = (table[:, COLUMNS.index(name)] for name in ("damage_start", "damage_end"))
    assert np.all(end > start)


def test_speeds_of_sound_are_those_of_the_tissues():
    """Muscle about 1.5 km/s, cortical bone 3.47 km/s (PHYSICS.md 1.5)."""
    assert TISSUE_MATERIALS[Tissue.MUSCLE].sound_speed == pytest.approx(1473.0, rel=0.005)
    assert TISSUE_MATERIALS[Tissue.BONE].sound_speed == pytest.approx(3470.0, rel=0.005)


def test_softening_is_regularised_by_the_cell():
    """Half the cell, twice the strain to failure: the energy per area stays."""
    bone = TISSUE_MATERIALS[Tissue.BONE]
    assert bone.damage_span(0.001) == pytest.approx(2.0 * bone.damage_span(0.002))
    # PHYSICS.md 1.4: 2 * 3e3 / (1.3e8 * 2e-3) = 0.023
    assert bone.damage_span(0.002) == pytest.approx(0.023, rel=0.01)
    # Skin on cells of 3 mm fails within the measured stretch of 1.54 +- 0.17.
    assert np.exp(TISSUE_MATERIALS[Tissue.SKIN].damage_span(0.003)) == pytest.approx(1.54, abs=0.17)


def test_softening_never_snaps_back_within_a_cell():
    """3 mu > slope of the yield stress, for every tissue and a scaled bone, on coarse cells."""
    for dx in (0.0005, 0.003, 0.02):
        table = tissue_table(dx, bone_modulus_scale=0.1)
        get = {name: table[:, i] for i, name in enumerate(COLUMNS)}
        slope = get["yield_stress"] / (get["damage_end"] - get["damage_start"])
        assert np.all(slope < 3.0 * get["shear_modulus"])


def test_bone_modulus_scale_touches_cortical_bone_only():
    soft, true = tissue_table(0.002, bone_modulus_scale=0.25), tissue_table(0.002)
    changed = np.any(soft != true, axis=1)
    assert list(np.flatnonzero(changed)) == [Tissue.BONE]
    assert soft[Tissue.BONE, 1] == pytest.approx(0.25 * true[Tissue.BONE, 1])


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
