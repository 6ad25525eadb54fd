"""The driver of single material points against closed forms and against its own refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import ScenarioError
from vulnus.injury.material_model import CRACK_BAND
from vulnus.injury.material_point import (
    material_point,
    pure_shear,
    simple_shear,
    tensile_test,
    uniaxial_strain,
    volumetric_strain,
)
from vulnus.injury.materials import MATERIALS, UNLIMITED, elastic, neo_hookean, von_mises

pytestmark = pytest.mark.physics

RUBBER = neo_hookean(1000.0, 50e3, 50e6)


def test_hencky_elasticity_under_finite_simple_shear():
    """tau_xy = 2 mu asinh(g/2)/sqrt(1 + g²/4), whatever the number of steps."""
    gamma = np.linspace(0.0, 2.0, 33)
    solid = elastic(1000.0, 1e6, 0.3)
    point = material_point(solid, simple_shear(gamma), duration=1.0)
    expected = 2.0 * solid.shear_modulus * np.arcsinh(gamma / 2) / np.sqrt(1.0 + gamma**2 / 4)
    assert np.allclose(point.kirchhoff[:, 0, 1], expected, rtol=1e-9)
    assert np.allclose(point.volume_ratio, 1.0)
    coarse = material_point(solid, simple_shear(gamma[[0, -1]]), duration=1.0)
    assert np.allclose(coarse.stress[-1], point.stress[-1], rtol=1e-9)


def test_tension_has_free_sides_and_the_hencky_solid_keeps_youngs_modulus():
    """Uniaxial stress: tau = E ln s and lateral stretch s^-nu, exact for the Hencky solid."""
    stretch = np.linspace(1.0, 1.3, 16)
    point = tensile_test(elastic(1000.0, 1e6, 0.3), stretch, rate=1.0)
    assert np.allclose(point.kirchhoff[:, 0, 0], 1e6 * np.log(stretch), rtol=1e-9, atol=1e-6)
    assert np.allclose(point.deformation[:, 1, 1], stretch**-0.3, rtol=1e-9)
    assert np.max(np.abs(point.stress[:, 1:, 1:])) < 1e-6  # of 1 MPa
    assert point.time[-1] == pytest.approx(0.3)


def test_the_neo_hookean_tensile_test_nears_the_incompressible_one():
    """Nominal stress mu (s - 1/s²) of an incompressible solid; K/mu = 1000 leaves 0.1 %."""
    stretch = np.linspace(1.0, 2.0, 21)
    point = tensile_test(RUBBER, stretch, rate=1.0)
    assert np.allclose(point.nominal_stress, 50e3 * (stretch - stretch**-2), rtol=2e-3)


def test_compression_mirrors_tension_for_von_mises():
    steel = von_mises(7800.0, 200e9, 0.3, 300e6, 1e9)
    strain = np.linspace(0.0, 0.05, 26)
    pulled = tensile_test(steel, np.exp(strain), rate=1.0)
    pushed = tensile_test(steel, np.exp(-strain), rate=1.0)
    assert np.allclose(pushed.kirchhoff, -pulled.kirchhoff, rtol=1e-9, atol=1e-3)
    assert np.allclose(pushed.plastic_strain, pulled.plastic_strain, rtol=1e-9)
    expected = 300e6 + 1e9 * pulled.plastic_strain[-1]
    assert pulled.kirchhoff[-1, 0, 0] == pytest.approx(expected, rel=1e-9)


def test_plastic_work_of_a_perfectly_plastic_metal_is_its_yield_stress_times_the_strain():
    steel = von_mises(7800.0, 200e9, 0.3, 300e6)
    point = material_point(steel, pure_shear(np.linspace(0.0, 0.1, 51)), duration=1.0)
    assert np.allclose(point.plastic_work, 300e6 * point.plastic_strain, rtol=1e-9)


def test_unloading_is_elastic_and_gives_the_stored_energy_back():
    """Up and down to the same shape: stress falls by 2 mu times the strain that is taken back."""
    steel = von_mises(7800.0, 200e9, 0.3, 300e6)
    path = pure_shear([0.0, 0.01, 0.009])
    point = material_point(steel, path, duration=1.0)
    fall = point.kirchhoff[1, 0, 0] - point.kirchhoff[2, 0, 0]
    assert fall == pytest.approx(2.0 * steel.shear_modulus * 0.001, rel=1e-9)
    assert point.plastic_strain[2] == point.plastic_strain[1]


def test_the_rate_law_sees_the_rate_of_the_path():
    """Ten times faster: muscle yields at Y0 [1 + (rate/ref)^m] of the equivalent rate."""
    muscle = MATERIALS["muscle"]
    plain = replace(
        muscle, network_modulus=0.0, failure_stretch=UNLIMITED, fracture_energy=UNLIMITED
    )
    for duration in (1e-2, 1e-3):
        strain = np.linspace(0.0, 0.4, 101)
        point = material_point(plain, pure_shear(strain), duration=duration)
        # A step's gradient is (F_k F_k-1^-1 - 1)/dt: along x and y it differs from the
        # logarithmic rate by half a strain increment of 0.004.
        rate = 2.0 / np.sqrt(3.0) * 0.4 / duration
        limit = plain.yield_stress * (1.0 + (rate / plain.rate_reference) ** plain.rate_exponent)
        assert point.von_mises_stress[-1] == pytest.approx(limit, rel=2e-3)


def test_skin_tears_at_its_measured_stretch_and_strength():
    """21.6 MPa at a stretch of 1.54 (Ni Annaidh 2012); nothing is left in the end."""
    stretch = np.linspace(1.0, 2.2, 601)
    point = tensile_test("skin", stretch, rate=1.0, grid_spacing=2e-3)
    peak = int(np.argmax(point.nominal_stress))
    assert stretch[peak] == pytest.approx(1.54, abs=0.01)
    assert point.nominal_stress[peak] == pytest.approx(21.6e6, rel=0.02)
    assert point.damage[-1] == 1.0
    assert abs(point.stress[-1, 0, 0]) < 1.0


@pytest.mark.parametrize("cell", [1e-3, 2e-3])
def test_a_broken_bone_has_spent_its_fracture_energy(cell):
    """Crack band: what flow and cracks take out of two cells is G_f per area, whatever the cell.

    The stress of a step is that at its end, some 1/500 of the fall too low.
    """
    bone = MATERIALS["cortical_bone"]
    stretch = np.exp(np.linspace(0.0, 1.5 * bone.damage_span(cell), 750))
    test = tensile_test(bone, stretch, rate=1.0, grid_spacing=cell)
    assert test.damage[-1] == 1.0
    spent = CRACK_BAND * cell * test.plastic_work[-1]
    assert spent == pytest.approx(bone.fracture_energy, rel=0.01)


@settings(derandomize=True, max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), name=st.sampled_from(sorted(MATERIALS)))
def test_random_paths_give_finite_stress_and_no_negative_plastic_work(seed, name):
    rng = np.random.default_rng(seed)
    path = [np.tile(np.eye(3), (4, 1, 1))]
    for _ in range(6):
        path.append((np.eye(3) + rng.normal(0.0, 0.06, (4, 3, 3))) @ path[-1])
    point = material_point(name, np.array(path), duration=1e-4)
    assert np.isfinite(point.kirchhoff).all()
    assert np.all((point.damage >= 0.0) & (point.damage <= 1.0))
    assert np.all(np.diff(point.damage, axis=0) >= 0.0)
    scale = max(float(point.plastic_work.max()), 1.0)
    assert np.min(np.diff(point.plastic_work, axis=0)) >= -1e-9 * scale


def test_many_points_go_as_each_alone():
    path = np.stack([uniaxial_strain([1.0, 1.02, 1.01]), volumetric_strain([1.0, 0.97, 1.0])], 1)
    both = material_point("copper", path, duration=1.0)
    for k in (0, 1):
        alone = material_point("copper", path[:, k], duration=1.0)
        assert np.array_equal(both.kirchhoff[:, k], alone.kirchhoff)
        assert np.array_equal(both.plastic_work[:, k], alone.plastic_work)


@pytest.mark.parametrize(
    ("path", "problem"),
    [
        (np.eye(3), "shape"),
        (np.array([np.eye(3), np.diag([-1.0, 1.0, 1.0])]), "entry 1 turns the point inside out"),
        (np.array([np.eye(3), np.full((3, 3), np.nan)]), "not finite"),
        (np.array([2.0 * np.eye(3), np.eye(3)]), "does not begin at the identity"),
    ],
)
def test_paths_that_are_none_are_refused(path, problem):
    with pytest.raises(ScenarioError, match=problem):
        material_point("copper", path, duration=1.0)


def test_refusals_of_materials_and_tensile_tests():
    with pytest.raises(ScenarioError, match="copper"):
        material_point("coper", uniaxial_strain([1.0, 1.1]), duration=1.0)
    with pytest.raises(ScenarioError, match="begin at 1"):
        tensile_test("copper", [1.1, 1.2], rate=1.0)
    with pytest.raises(ScenarioError, match="rate"):
        tensile_test("copper", [1.0, 1.2], rate=0.0)
