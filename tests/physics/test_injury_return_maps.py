"""Return maps of a single material point against closed forms (PHYSICS.md M5)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.material_point import spectral, update
from scipy.spatial.transform import Rotation

from vulnus.injury.material_model import CRACK_BAND
from vulnus.injury.materials import COPPER, MARROW, Material, material_table, tissue_table

pytestmark = pytest.mark.physics

METAL = Material(density=8000.0, bulk_modulus=160e9, shear_modulus=80e9, yield_stress=300e6)
ROCK = Material(
    density=1900.0, bulk_modulus=14e9, shear_modulus=6.5e9, yield_stress=150e6, friction=0.6
)
GLASS = Material(density=2500.0, bulk_modulus=40e9, shear_modulus=30e9, tensile_strength=50e6)


def apply(material, hencky, **state):
    """Return map on Hencky strains (n, 3, 3): Hencky strain, alpha, opening, stress after."""
    point = update(material, hencky, **state)
    return point.hencky, point.alpha, point.opening, point.tau


def test_uniaxial_strain_returns_to_the_von_mises_cylinder():
    """q = 2 mu eps (1 - 0) before; after it q = Y and the pressure is K eps, closed form."""
    strain = np.diag([0.01, 0.0, 0.0])
    _, alpha, _, tau = apply(METAL, strain)
    q_trial = 2.0 * 80e9 * 0.01  # sqrt(3/2) |2 mu dev| = 2 mu eps for uniaxial strain
    pressure = 160e9 * 0.01
    assert alpha[0] == pytest.approx((q_trial - 300e6) / (3.0 * 80e9), rel=1e-8)
    expected = np.diag([200e6, -100e6, -100e6]) + pressure * np.eye(3)
    assert np.allclose(tau[0], expected, rtol=1e-8, atol=1.0)


def test_simple_shear_returns_along_the_shear():
    """Pure shear Hencky strain g/2: tau_xy = Y/sqrt(3), alpha = (sqrt(3) mu g - Y)/(3 mu)."""
    g = 0.02
    _, alpha, _, tau = apply(METAL, np.array([[0, g / 2, 0], [g / 2, 0, 0], [0, 0, 0]]))
    assert tau[0, 0, 1] == pytest.approx(300e6 / np.sqrt(3.0), rel=1e-8)
    assert alpha[0] == pytest.approx((np.sqrt(3.0) * 80e9 * g - 300e6) / (3.0 * 80e9), rel=1e-8)


def test_elastic_states_are_left_alone():
    strain = np.diag([1e-4, -2e-4, 5e-5])
    after, alpha, opening, tau = apply(METAL, strain)
    trace = np.trace(strain)
    expected = 2.0 * 80e9 * (strain - trace / 3.0 * np.eye(3)) + 160e9 * trace * np.eye(3)
    assert np.allclose(tau[0], expected, rtol=1e-8, atol=1e-2)
    assert np.allclose(after[0], strain, atol=1e-12)
    assert alpha[0] == 0.0
    assert opening[0] == 0.0


def test_drucker_prager_strength_grows_with_pressure_and_ends_at_the_tip():
    pressure_strain = np.array([-0.03, -0.003, 0.03])  # compression, light compression, tension
    strain = np.array([np.diag([0.02, -0.02, 0.0]) + e / 3.0 * np.eye(3) for e in pressure_strain])
    _, _, _, tau = apply(ROCK, strain)
    pressure = -14e9 * pressure_strain
    deviator = tau - np.trace(tau, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    q = np.sqrt(1.5 * np.einsum("nij,nij->n", deviator, deviator))
    expected = np.maximum(150e6 + 0.6 * pressure, 0.0)
    assert np.allclose(q, expected, rtol=1e-8, atol=10.0)  # the tip: q = 0, to 10 Pa of 2 mu
    assert expected[2] == 0.0


@pytest.mark.parametrize("strain", [(4e-3, 0, 0), (4e-3, 3.5e-3, -1e-3), (3e-3, 3e-3, 2.8e-3)])
def test_rankine_cuts_every_principal_stress_at_the_tensile_strength(strain):
    """One, two and three active principal stresses; the others follow elastically."""
    after, _, opening, tau = apply(GLASS, np.diag(strain))
    stress = np.linalg.eigvalsh(tau[0])
    assert stress[-1] == pytest.approx(50e6, rel=1e-8)
    lam, mu = 40e9 - 20e9, 30e9
    expected = lam * np.trace(after[0]) + 2.0 * mu * np.linalg.eigvalsh(after[0])
    assert np.allclose(stress, expected, rtol=1e-8)
    assert opening[0] == pytest.approx(sum(strain) - np.trace(after[0]), rel=1e-8)


def test_softening_spends_the_fracture_energy_on_any_cell():
    """Sum of stress d(strain) times the band of cells is G_f = 3 kJ/m2, whatever the cell."""
    for dx in (0.001, 0.002):
        bone = Material(
            density=1900.0, bulk_modulus=14.2e9, shear_modulus=6.54e9, tensile_strength=130e6,
            fracture_energy=3e3, softening_stress=130e6, opening_damage=1.0,
        )  # fmt: skip
        lam = bone.bulk_modulus - 2.0 * bone.shear_modulus / 3.0
        strain, alpha, opening, energy = np.zeros((3, 3)), 0.0, 0.0, 0.0
        lateral = -lam / (2.0 * (lam + bone.shear_modulus))
        increment = 1e-5
        for _ in range(20000):
            before = opening
            strain = strain + np.diag([increment, lateral * increment, lateral * increment])
            after, a, o, tau = apply(bone, strain, alpha=alpha, opening=opening, dx=dx)
            strain, alpha, opening = after[0], a[0], o[0]
            strain[1, 1] = strain[2, 2] = lateral * strain[0, 0]  # uniaxial stress
            energy += tau[0, 0, 0] * (opening - before) * dx
            if bone.damage_span(dx) <= alpha:
                break
        # The last step overshoots zero strength by half an increment of 1e-5 in 0.02.
        assert CRACK_BAND * energy == pytest.approx(3e3, rel=0.02)


def test_softening_at_high_rates_never_adds_strength():
    """On cells of 10 mm at 1e5-1e7 /s marrow's stress falls and its plastic strain grows."""
    row = material_table([MARROW], 0.01)
    start = MARROW.damage_start
    for rate in (1e5, 1e6, 1e7):
        full = MARROW.yield_stress * (1.0 + (rate / MARROW.rate_reference) ** MARROW.rate_exponent)
        shear = 1.05 * full / (3.0 * MARROW.shear_modulus)  # q = 3 mu shear, 5 % above yield
        strain = np.diag([shear, -0.5 * shear, -0.5 * shear])
        _, alpha, _, tau = apply(row, strain, alpha=start, rate=rate)
        principal = np.linalg.eigvalsh(tau[0])
        assert alpha[0] > start
        assert principal[-1] - principal[0] < full


def test_tension_opens_voids_and_compression_closes_them_first():
    """Cavitation: the pressure stays at -p_cav while opening grows; closing costs no pressure."""
    water = Material(
        density=1000.0,
        bulk_modulus=2.2e9,
        shear_modulus=1e3,
        tait_exponent=7.0,
        pressure_cutoff=1e5,
    )
    _, _, opening, tau = apply(water, 0.1 / 3.0 * np.eye(3))
    cut = 1e5 / 2.2e9
    cut += 2.5 * cut**2  # Tait's law bends: (K/7)(exp t - exp -6t) = K (t - 5/2 t²) and so on
    assert opening[0] == pytest.approx(0.1 - cut, rel=1e-8)
    assert np.trace(tau[0]) / 3.0 == pytest.approx(1e5, rel=1e-8)
    _, _, opening, tau = apply(water, -0.04 / 3.0 * np.eye(3), opening=0.1)
    assert opening[0] == pytest.approx(0.06, rel=1e-8)
    assert abs(np.trace(tau[0])) < 1e-3
    _, _, opening, tau = apply(water, -0.12 / 3.0 * np.eye(3), opening=0.1)
    jacobian = np.exp(-0.02)
    assert opening[0] == pytest.approx(0.0, abs=1e-15)
    expected = -jacobian * 2.2e9 / 7.0 * (jacobian**-7 - 1.0)
    assert np.trace(tau[0]) / 3.0 == pytest.approx(expected, rel=1e-8)


def test_the_rate_law_multiplies_the_yield_stress():
    """Y = Y0 [1 + (rate / 300)^0.36]: 1.03 MPa at 4e4 /s, from 0.15 MPa (PHYSICS.md 1.2)."""
    gel = Material(
        density=1030.0, bulk_modulus=2.4e9, shear_modulus=3.5e6, yield_stress=0.15e6,
        rate_reference=300.0, rate_exponent=0.36,
    )  # fmt: skip
    _, _, _, tau = apply(gel, np.diag([0.3, -0.3, 0.0]), rate=4e4)
    deviator = tau[0] - np.trace(tau[0]) / 3.0 * np.eye(3)
    q = np.sqrt(1.5 * np.sum(deviator**2))
    assert q == pytest.approx(0.15e6 * (1.0 + (4e4 / 300.0) ** 0.36), rel=1e-8)


def test_linear_hardening_is_the_radial_return_in_closed_form():
    """delta alpha = (q - Y(alpha)) / (3 mu + H) (PHYSICS 1.4), and q lands on Y (M5)."""
    shear, alpha = COPPER.shear_modulus, 0.3
    q_trial = 2.0 * shear * 0.05  # uniaxial strain 0.05
    flow = (q_trial - 400e6 - 100e6 * alpha) / (3.0 * shear + 100e6)
    after = update(COPPER, np.diag([0.05, 0.0, 0.0]), alpha=alpha)
    assert after.alpha[0] == pytest.approx(alpha + flow, rel=1e-8)
    stress = np.diag(after.tau[0])
    assert stress[0] - stress[1] == pytest.approx(400e6 + 100e6 * (alpha + flow), rel=1e-8)


def test_damage_of_the_network_weakens_what_flows_and_what_opens():
    """At D = 0.4 the yield stress and the cavitation pressure are 0.6 of theirs."""
    gel = Material(
        density=1000.0, bulk_modulus=2e9, shear_modulus=3e6, yield_stress=1e5,
        pressure_cutoff=3e5,
    )  # fmt: skip
    after = update(gel, np.diag([0.2, -0.2, 0.01]), damage=0.4)
    stress = np.linalg.eigvalsh(after.tau[0])
    mean = np.mean(stress)
    assert np.sqrt(1.5 * np.sum((stress - mean) ** 2)) == pytest.approx(0.6e5, rel=1e-8)
    assert mean == pytest.approx(0.6 * 3e5, rel=1e-8)
    assert after.damage[0] == 0.4


@settings(derandomize=True, max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), tissue=st.integers(1, 7))
def test_frame_indifference_consistency_and_dissipation(seed, tissue):
    """Rotated strain gives rotated stress; a second return changes nothing; plastic work >= 0."""
    rng = np.random.default_rng(seed)
    table = tissue_table(0.002)[tissue : tissue + 1]
    strain = rng.normal(0.0, 0.05, (8, 3, 3))
    strain = 0.5 * (strain + strain.transpose(0, 2, 1))
    q = Rotation.random(random_state=seed).as_matrix()
    after, alpha, opening, tau = apply(table, strain, rate=100.0)
    _, _, _, turned = apply(table, q @ strain @ q.T, rate=100.0)
    size = np.max(np.abs(tau)) + 1e5
    assert np.allclose(turned, q @ tau @ q.T, rtol=0.0, atol=1e-8 * size)
    assert np.all(alpha >= 0.0)
    assert np.all(opening >= 0.0)
    work = np.einsum("nij,nij->n", tau, strain - after)
    assert np.all(work >= -1e-8 * size)


def test_consistency_of_the_yield_condition():
    """y <= 1e-10 of the modulus after the return (M5), for strains up to 50 %."""
    rng = np.random.default_rng(3)
    strain = rng.normal(0.0, 0.2, (64, 3, 3))
    strain = 0.5 * (strain + strain.transpose(0, 2, 1))
    _, _, _, tau = apply(METAL, strain)
    deviator = tau - np.trace(tau, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    excess = np.sqrt(1.5 * np.einsum("nij,nij->n", deviator, deviator)) - 300e6
    assert np.max(excess) <= 1e-10 * 3.0 * 80e9


def test_single_precision_follows_double():
    """float32 lanes (own log, exp and Jacobi) agree to 1e-5 of the stress scale."""
    rng = np.random.default_rng(4)
    strain = rng.normal(0.0, 0.02, (200, 3, 3))
    strain = 0.5 * (strain + strain.transpose(0, 2, 1))
    for tissue in range(1, 8):
        table = tissue_table(0.002)[tissue : tissue + 1]
        _, alpha32, _, tau32 = apply(table, strain, rate=50.0, precision="32")
        _, alpha64, _, tau64 = apply(table, strain, rate=50.0)
        assert np.allclose(tau32, tau64, rtol=0.0, atol=1e-5 * np.max(np.abs(tau64)))
        assert np.allclose(alpha32, alpha64, rtol=0.0, atol=1e-5)


@settings(derandomize=True, max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6), tissue=st.integers(0, 7), precision=st.sampled_from(["32", "64"])
)
def test_no_strain_of_finite_size_gives_a_number_that_is_not_finite(seed, tissue, precision):
    """Strains up to a stretch of 20 with any history, at any rate: finite, damage within 0 to 1."""
    rng = np.random.default_rng(seed)
    table = tissue_table(0.002)[tissue : tissue + 1]
    size = 10.0 ** rng.uniform(-6.0, 0.5)
    strain = rng.uniform(-size, size, (16, 3, 3))
    strain = 0.5 * (strain + strain.transpose(0, 2, 1))
    network = spectral(strain * rng.uniform(0.0, 1.0), lambda e: np.exp(2.0 * e))
    after = update(
        table, strain, network=network, alpha=rng.uniform(0.0, 10.0), precision=precision,
        opening=rng.uniform(0.0, 3.0), damage=rng.uniform(0.0, 1.0), rate=10 ** rng.uniform(-3, 7),
    )  # fmt: skip
    for values in (after.hencky, after.alpha, after.opening, after.tau, after.wave_speed):
        assert np.all(np.isfinite(values))
    assert np.all((after.damage >= 0.0) & (after.damage <= 1.0))


def tait_part(bulk, t):
    """(K/7)(J - J^-6) of ln J = t (PHYSICS 1.4)."""
    return bulk / 7.0 * (np.exp(t) - np.exp(-6.0 * t))


BENT = {"density": 1000.0, "bulk_modulus": 1e7, "shear_modulus": 2e6, "tait_exponent": 7.0}


@pytest.mark.parametrize("cutoff", [1e4, 1e6, 5e6])
def test_the_cutoff_of_the_pressure_holds_under_the_law_of_tait(cutoff):
    """The stress stops at the cut-off itself, also where that is half of the bulk modulus."""
    law = Material(**BENT, pressure_cutoff=cutoff)
    strain = np.array([np.eye(3) * e for e in (0.5, 0.7, 1.0)])
    _, _, opening, tau = apply(law, strain)
    assert np.allclose(np.trace(tau, axis1=1, axis2=2) / 3.0, cutoff, rtol=1e-5)
    assert np.all(opening > 0.0)


def test_the_friction_of_a_cone_counts_the_pressure_of_tait():
    """q = Y + M p with p of the same law as the stress, 3.3 times the linear one here."""
    law = Material(**BENT, yield_stress=1e4, friction=0.1)
    strain = np.diag([0.3, -0.3, 0.0]) - 0.1 * np.eye(3)
    after, _, _, tau = apply(law, strain)
    pressure = -tait_part(1e7, np.trace(after[0]))
    assert pressure > 1.5 * 1e7 * 0.3
    deviator = tau[0] + pressure * np.eye(3)
    assert np.sqrt(1.5 * np.sum(deviator**2)) == pytest.approx(1e4 + 0.1 * pressure, rel=1e-6)


@pytest.mark.parametrize("strain", [(0.2, 0, 0), (0.2, 0.15, -0.05), (0.2, 0.2, 0.2)])
def test_rankine_holds_under_the_law_of_tait(strain):
    """To 0.5 %: four iterations, each of which leaves some tenth of strains as large as these."""
    law = Material(**BENT, tensile_strength=1e6)
    after, _, opening, tau = apply(law, np.diag(strain))
    assert np.linalg.eigvalsh(tau[0])[-1] == pytest.approx(1e6, rel=5e-3)
    trace = np.trace(after[0])
    expected = 4e6 * (after[0] - trace / 3.0 * np.eye(3)) + tait_part(1e7, trace) * np.eye(3)
    assert np.allclose(tau[0], expected, rtol=1e-8, atol=1.0)
    assert opening[0] > 0.0


def test_strengths_without_limit_do_not_jump_when_the_damage_is_complete():
    """The last millionth of the damage takes a millionth of the moduli, not all that is left."""
    law = Material(density=1000.0, bulk_modulus=1e9, shear_modulus=1e8)
    strain = np.diag([0.02, -0.01, 0.005])
    damage = np.array([0.0, 1.0 - 1e-6, 1.0])
    _, _, _, tau = apply(law, np.tile(strain, (3, 1, 1)), damage=damage)
    intact, nearly, gone = tau
    assert np.max(np.abs(intact)) > 1e6
    assert np.all(np.linalg.eigvalsh(gone) <= 1.0)
    assert np.max(np.abs(nearly - gone)) < 1e-5 * 1e9
