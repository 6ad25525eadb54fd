"""What the material points say: stress, volume, energy; and new constants under the same stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.material_point import update, voigt
from scipy.integrate import quad

from vulnus.core.errors import ScenarioError
from vulnus.injury.materials import (
    COLUMNS,
    MATERIALS,
    Material,
    elastic,
    material_table,
    neo_hookean,
    slowed,
    tissue_table,
)
from vulnus.injury.solver import NETWORK_STRAIN, OPENING, STRAIN, MpmSolver

pytestmark = pytest.mark.physics

SPACING = 0.004
VOLUME = 1e-8


def strained(table, deformation, *, material=None, precision="float64", opening=None):
    """A solver whose particles have the deformation gradients (n, 3, 3)."""
    deformation = np.asarray(deformation, np.float64).reshape(-1, 3, 3)
    n = len(deformation)
    solver = MpmSolver(
        materials=table, grid_spacing=SPACING, lower=(-1.0,) * 3, upper=(1.0,) * 3,
        precision=precision,
    )  # fmt: skip
    x = np.random.default_rng(0).uniform(-0.01, 0.01, (n, 3))
    code = np.zeros(n, np.uint8) if material is None else material
    solver.set_particles(x, volume=np.full(n, VOLUME), material=code)
    strain = voigt(deformation @ deformation.transpose(0, 2, 1) - np.eye(3))
    solver._native.set_values(NETWORK_STRAIN, strain)
    if opening is not None:
        solver._native.set_values(OPENING, opening[:, None])
        shrunk = deformation * np.exp(-opening / 3.0)[:, None, None]
        strain = voigt(shrunk @ shrunk.transpose(0, 2, 1) - np.eye(3))
    solver._native.set_values(STRAIN, strain)
    return solver


def stretch_to(volume):
    return np.exp(np.asarray(volume) / 3.0)[..., None, None] * np.eye(3)


def test_stress_pressure_and_volume_of_a_neo_hookean_solid():
    """sigma = mu J^(-5/3) dev(b) + (K/2)(J - 1/J) I (PHYSICS 1.4 over J)."""
    rng = np.random.default_rng(1)
    f = np.eye(3) + rng.uniform(-0.3, 0.3, (40, 3, 3))
    b, jacobian = f @ f.transpose(0, 2, 1), np.linalg.det(f)[:, None, None]
    deviator = b - np.trace(b, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    pressure_part = 0.5 * 2e6 * (jacobian - 1.0 / jacobian)
    expected = 0.3e6 * jacobian ** (-5.0 / 3.0) * deviator + pressure_part * np.eye(3)
    table = material_table([neo_hookean(1000.0, 0.3e6, 2e6)], SPACING)
    for precision, tolerance in (("float64", 1e-9), ("float32", 2e-5)):
        solver = strained(table, f, precision=precision)
        assert np.allclose(solver.stress, expected, rtol=0.0, atol=tolerance * 2e6)
        assert np.allclose(solver.pressure, -pressure_part.ravel(), atol=tolerance * 2e6)
        assert np.allclose(solver.volume_ratio, jacobian.ravel(), rtol=tolerance)


def test_the_volume_ratio_counts_open_voids():
    table = material_table([elastic(1000.0, 1e6, 0.3)], SPACING)
    solver = strained(table, stretch_to([0.2]), opening=np.array([0.15]))
    assert solver.volume_ratio[0] == pytest.approx(np.exp(0.2), rel=1e-12)
    assert solver.pressure[0] == pytest.approx(-1e6 / 1.2 * 0.05 / np.exp(0.2), rel=1e-9)


@pytest.mark.parametrize("law", ["logarithmic", "tait", "quadratic"])
def test_energy_of_the_volume_is_the_integral_of_the_pressure(law):
    options = {"tait": {"tait_exponent": 7.0}, "quadratic": {"quadratic_volume": True}}
    liquid = Material(density=1000.0, bulk_modulus=2e9, **options.get(law, {}))
    table = material_table([liquid], SPACING)

    def kirchhoff(t):
        return strained(table, stretch_to([t])).stress[0, 0, 0] * np.exp(t)

    for end in (-0.08, 0.05):
        integral = quad(kirchhoff, 0.0, end, epsrel=1e-10)[0]
        energy = strained(table, stretch_to([end])).energies()["elastic"]
        assert energy == pytest.approx(VOLUME * integral, rel=1e-9)


def test_energy_of_shear_is_the_work_of_the_stress():
    """Hencky part and network together, along isochoric stretch past the network's failure."""
    law = Material(
        density=1000.0, bulk_modulus=2e9, shear_modulus=1e6, network_modulus=2e6,
        network_stiffening=1.5, failure_stretch=1.4, fracture_energy=1e3,
    )  # fmt: skip
    table = material_table([law], SPACING)

    def rate(t):  # of energy with the Hencky strain t along x
        f = np.diag(np.exp([t, -0.5 * t, -0.5 * t]))
        stress = strained(table, f).stress[0]
        return stress[0, 0] - stress[1, 1]

    end = np.log(1.7)
    integral = quad(rate, 0.0, end, epsrel=1e-9, points=[np.log(1.4)])[0]
    f = np.diag(np.exp([end, -0.5 * end, -0.5 * end]))
    energy = strained(table, f).energies()["elastic"]
    assert energy == pytest.approx(VOLUME * integral, rel=1e-8)  # undamaged: damage not set


def test_energies_are_sums_over_particles_that_do_not_depend_on_their_order():
    rng = np.random.default_rng(5)
    laws = [elastic(1000.0, 1e6, 0.3), neo_hookean(1100.0, 2e5, 2e6)]
    table = material_table(laws, SPACING)
    n = 3000
    material = rng.integers(0, 2, n).astype(np.uint8)
    f = np.eye(3) + rng.uniform(-1e-3, 1e-3, (n, 3, 3))
    solver = strained(table, f, material=material)
    before = solver.energies()
    assert before["kinetic"] == 0.0
    solver.advance(until=1e-12)  # sorts
    assert solver.energies()["elastic"] == pytest.approx(before["elastic"], rel=1e-6)


@pytest.mark.parametrize("name", sorted(MATERIALS))
def test_new_moduli_leave_the_stress(name):
    """Kirchhoff stress before and after `slowed`, for pressures up to 10 MPa."""
    law = replace(MATERIALS[name])
    rng = np.random.default_rng(7)
    volume = -rng.uniform(-1e5, 1e7, 30) / law.bulk_modulus
    f = stretch_to(volume) @ (np.eye(3) + rng.uniform(-2e-3, 2e-3, (30, 3, 3)))
    table = material_table([law], SPACING)
    solver = strained(table, f)
    tau = solver.stress * solver.volume_ratio[:, None, None]
    solver.change_materials(slowed(table, 200.0))
    after = solver.stress * solver.volume_ratio[:, None, None]
    assert np.allclose(after, tau, rtol=0.0, atol=1e-9 * np.max(np.abs(tau)))
    assert np.max(np.abs(solver.volume_ratio - np.linalg.det(f))) > 1e-4


def test_lower_moduli_take_larger_steps():
    table = tissue_table(SPACING)
    n = 64
    solver = strained(table, np.tile(np.eye(3), (n, 1, 1)), material=np.full(n, 3, np.uint8))
    solver.advance(until=1e-5)
    solver.change_materials(slowed(table, 200.0))
    solver.advance(until=1.0, max_steps=1)
    assert solver.step_size == pytest.approx(0.4 * SPACING / 200.0, rel=1e-3)


def test_constants_that_would_change_the_mass_or_the_network_are_refused():
    table = tissue_table(SPACING)
    solver = strained(table, np.eye(3))
    for column in ("density", "network_modulus"):
        other = table.copy()
        other[1, COLUMNS.index(column)] *= 2.0
        with pytest.raises(ScenarioError, match="materials"):
            solver.change_materials(other)
    with pytest.raises(ScenarioError, match="shape"):
        solver.change_materials(table[:3])
    solver.advance(until=1.0, max_steps=1)
    with pytest.raises(ScenarioError, match="epoch"):
        solver.change_materials(table)


def test_a_run_resumed_after_the_change_takes_the_same_steps():
    rng = np.random.default_rng(9)
    n = 200
    material = rng.integers(1, 8, n).astype(np.uint8)
    x = rng.uniform(-0.008, 0.008, (n, 3))

    def fresh():
        solver = MpmSolver(
            materials=tissue_table(SPACING), grid_spacing=SPACING, lower=(-1.0,) * 3,
            upper=(1.0,) * 3,
        )  # fmt: skip
        solver.set_particles(x, volume=np.full(n, VOLUME), material=material, velocity=-3e3 * x)
        return solver

    whole = fresh()
    whole.advance(until=2e-6)
    whole.change_materials(slowed(tissue_table(SPACING), 300.0))
    saved = whole.state()
    whole.advance(until=2e-5)
    resumed = fresh()
    resumed.restore(saved)
    resumed.advance(until=2e-5)
    assert np.array_equal(whole.position, resumed.position)
    assert np.array_equal(whole.stress, resumed.stress)


def test_the_reading_is_the_stress_of_the_steps():
    """After steps of a random body: the reading equals the return map's own stress over J."""
    rng = np.random.default_rng(11)
    table = material_table([MATERIALS["muscle"]], SPACING)
    x = rng.uniform(-0.008, 0.008, (100, 3))
    solver = MpmSolver(
        materials=table, grid_spacing=SPACING, lower=(-1.0,) * 3, upper=(1.0,) * 3,
        precision="float64",
    )  # fmt: skip
    velocity = -2e3 * x + rng.normal(0.0, 20.0, x.shape)
    solver.set_particles(
        x, volume=np.full(100, VOLUME), material=np.zeros(100, np.uint8), velocity=velocity
    )
    solver.advance(until=5e-6)
    s = solver._native.values(STRAIN, 6)
    b = s[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3) + np.eye(3)
    value, vector = np.linalg.eigh(b)
    hencky = np.einsum("nia,na,nja->nij", vector, 0.5 * np.log(value), vector)
    w = solver._native.values(NETWORK_STRAIN, 6)
    network = w[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3) + np.eye(3)
    # At an infinite rate nothing flows, so that the map returns the stress of the state itself.
    again = update(
        table, hencky, network=network, alpha=solver.plastic_strain, opening=solver.opening,
        damage=solver.damage, rate=1e30, dx=SPACING,
    )  # fmt: skip
    still = solver.opening == 0.0
    kirchhoff = solver.stress * solver.volume_ratio[:, None, None]
    size = np.max(np.abs(kirchhoff))
    assert np.count_nonzero(still) > 20
    assert np.allclose(again.tau[still], kirchhoff[still], rtol=0.0, atol=1e-9 * size)


def test_the_energy_that_softer_constants_make_is_told():
    """Equal stress in bone of a hundredth of the stiffness stores a hundred times as much."""
    table = material_table([elastic(1900.0, 18e9, 0.3)], SPACING)
    rng = np.random.default_rng(13)
    solver = strained(table, np.eye(3) + rng.uniform(-5e-3, 5e-3, (50, 3, 3)))
    before = solver.energies()["elastic"]
    softer = table.copy()
    for name in ("bulk_modulus", "shear_modulus"):
        softer[:, COLUMNS.index(name)] *= 0.01
    solver.change_materials(softer)
    assert solver.energies()["elastic"] == pytest.approx(100.0 * before, rel=1e-9)
    assert solver.energy_of_changes == pytest.approx(99.0 * before, rel=1e-9)
    other = strained(table, np.tile(np.eye(3), (50, 1, 1)))
    other.restore(solver.state())
    assert other.energy_of_changes == solver.energy_of_changes
    solver.change_materials(table)
    assert solver.energy_of_changes == pytest.approx(0.0, abs=1e-9 * before)


@pytest.mark.parametrize(("precision", "tolerance"), [("float64", 1e-9), ("float32", 1e-2)])
def test_the_stress_stays_also_where_strains_become_large(precision, tolerance):
    """Bone under 100 MPa whose waves are slowed to 230 m/s: strains of 1 to 2, the same stress.

    Slower still, no strain that can be kept gives that stress, and the change is refused.
    """
    table = material_table([MATERIALS["cortical_bone"]], SPACING)
    rng = np.random.default_rng(17)
    f = np.eye(3) + rng.uniform(-4e-3, 4e-3, (30, 3, 3))
    solver = strained(table, f, precision=precision)
    tau = solver.stress * solver.volume_ratio[:, None, None]
    with pytest.raises(ScenarioError, match="strains them") as error:
        solver.change_materials(slowed(table, 50.0))
    assert "sound_speed" in error.value.advice
    assert np.array_equal(solver.materials, table)
    solver.change_materials(slowed(table, 230.0))
    after = solver.stress * solver.volume_ratio[:, None, None]
    assert np.max(np.abs(solver._native.values(STRAIN, 6))) > 1.0
    assert np.allclose(after, tau, rtol=0.0, atol=tolerance * np.max(np.abs(tau)))


def test_slowed_bone_does_not_snap_back():
    """Its plastic strain to ruin grows with what it yields by: 10 % above it, as at full moduli."""
    law = MATERIALS["cortical_bone"]
    table = material_table([law], SPACING)
    slope, shear = (COLUMNS.index(name) for name in ("damage_slope", "shear_modulus"))
    strength = max(law.yield_stress, law.tensile_strength)
    new = slowed(table, 100.0)
    assert new[0, slope] < table[0, slope]
    assert 1.0 / new[0, slope] == pytest.approx(1.1 * strength / (3.0 * new[0, shear]))
