"""Forces of blood on blood cancel, keep the energy, and are those of the slow twin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import sph_twin

from vulnus.hemorrhage import FluidParameters, FluidScene, _native
from vulnus.hemorrhage.scene import box_lattice

DX = 1e-3


def cloud(seed: int, side: int = 6) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    points = box_lattice((0, 0, 0), (side * DX, side * DX, side * DX), 0.97 * DX)
    points = points + rng.uniform(-0.2, 0.2, points.shape) * DX
    return points, rng.normal(0.0, 0.2, points.shape)


def built(points, velocity, *, double=True, **fields):
    parameters = FluidParameters(particle_spacing=DX, **fields)
    scene = FluidScene(parameters, threads=1)
    scene.add_fluid(points, velocity)
    return scene.build(double=double), parameters


def twin_of(parameters: FluidParameters) -> sph_twin.TwinFluid:
    s = parameters.native()
    return sph_twin.TwinFluid(
        sph_twin.Kernels(parameters.kernels, s.smoothing),
        s.density * DX**3,
        s.density,
        s.viscosity,
        s.sound_speed,
        s.dissipation,
        s.density_scale,
        s.gradient_scale,
        s.laplacian_scale,
        s.clamped,
    )


@pytest.mark.parametrize("kernels", ["wendland_c2", "mueller2003"])
@pytest.mark.parametrize("clamped", [True, False])
def test_step_is_the_twins(kernels, clamped):
    """Equation: Chong2017 (4), (6), (7), (10), (11): double precision agrees to round-off."""
    points, velocity = cloud(1)
    fluid, parameters = built(
        points, velocity, kernels=kernels, pressure_clamped=clamped, time_step=1e-6
    )
    fluid.set_gravity((1.0, -2.0, 3.0))
    twin = twin_of(parameters)
    place, speed = sph_twin.steps(twin, points, velocity, np.array([1.0, -2.0, 3.0]), dt=1e-6)
    fluid.step_chunk(1.0, step_limit=1)
    order = np.argsort(fluid.id)
    assert fluid.density[order] == pytest.approx(sph_twin.densities(twin, points), rel=1e-12)
    scale = np.abs(speed - velocity).max()
    assert np.abs(fluid.velocity[order] - speed).max() < 1e-10 * scale
    assert np.abs(fluid.position[order] - place).max() < 1e-15


def test_comparison_with_the_twin_can_fail():
    """A twin without the self term of eq. (6) is told apart."""
    points, velocity = cloud(1)
    fluid, parameters = built(points, velocity)
    fluid.native.evaluate()
    twin = twin_of(parameters)
    own = twin.mass * twin.density_scale * twin.kernels.density(np.zeros(1))[0]
    wrong = sph_twin.densities(twin, points) - own
    assert fluid.density[np.argsort(fluid.id)] != pytest.approx(wrong, rel=1e-2)


@settings(derandomize=True, max_examples=8, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from(["wendland_c2", "mueller2003"]))
def test_internal_forces_cancel(seed, kernels):
    """Equation: Chong2017 (10), (11): the sum is round-off (1e-12 of the sum of magnitudes)."""
    points, velocity = cloud(seed)
    fluid, _ = built(points, velocity, kernels=kernels)
    fluid.native.evaluate()
    a = fluid.native.acceleration
    assert np.abs(a.sum(axis=0)).max() < 1e-12 * np.abs(a).sum()


def test_positive_pressure_repels():
    """Equation: Chong2017 (10), with the sign that the paper's print lacks."""
    points = np.array([[0.0, 0.0, 0.0], [0.4 * DX, 0.0, 0.0], [0.2 * DX, 0.3 * DX, 0.0]])
    points = np.concatenate([points, points + [0.0, 0.0, 0.3 * DX]])
    fluid, _ = built(points, np.zeros_like(points), density=300.0)
    fluid.native.evaluate()
    order = np.argsort(fluid.id)
    assert fluid.pressure.min() > 0.0
    assert fluid.native.acceleration[order][0, 0] < 0.0 < fluid.native.acceleration[order][1, 0]


def test_viscosity_slows_relative_motion():
    """Equation: Chong2017 (11)."""
    points = np.array([[0.0, 0.0, 0.0], [DX, 0.0, 0.0]])
    velocity = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    fluid, _ = built(points, velocity)
    fluid.native.evaluate()
    a = fluid.native.acceleration[np.argsort(fluid.id)]
    assert a[0, 1] < 0.0 < a[1, 1]


def test_gravity_accelerates_all_alike():
    """Equation: Chong2017 (12)."""
    fluid, _ = built(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.zeros((2, 3)))
    fluid.set_gravity((0.0, 0.0, -9.81))
    fluid.native.evaluate()
    assert fluid.native.acceleration == pytest.approx(np.array([[0, 0, -9.81]] * 2), abs=1e-12)


def test_energy_of_a_periodic_box_is_kept():
    """Density and pressure force of one kernel are one energy's: 1 % over 40 acoustic times."""
    side = 8
    rng = np.random.default_rng(0)
    points = box_lattice((0, 0, 0), (side * DX,) * 3, DX)
    parameters = FluidParameters(
        particle_spacing=DX,
        sound_speed=15.0,
        viscosity=1e-12,
        dissipation=0.0,
        pressure_clamped=False,
    )
    scene = FluidScene(parameters, threads=1)
    scene.add_fluid(points, rng.normal(0.0, 0.1, points.shape))
    for axis in range(3):
        scene.set_periodic(axis, 0.0, side * DX)
    fluid = scene.build(double=True)
    ratio = parameters.native().gradient_scale / parameters.native().density_scale

    def energy():
        s = fluid.density / parameters.density
        internal = parameters.sound_speed**2 * (np.log(s) + 1.0 / s - 1.0)
        return np.mean(0.5 * (fluid.velocity**2).sum(axis=1) + ratio * internal)

    fluid.step_chunk(1.0, step_limit=1)
    before = energy()
    fluid.advance(40 * DX / parameters.sound_speed)
    assert energy() == pytest.approx(before, rel=0.01)


def test_as_printed_differs_where_it_should():
    """Equation: Chong2017 (6), (7) as printed: a lone particle pulls, without its own share.

    Its density is that at which blood parts, 95 % of what the lattice of others gives.
    """
    points = np.array([[0.0, 0.0, 0.0]])
    printed, _ = built(points, np.zeros((1, 3)), as_printed=True)
    corrected, _ = built(points, np.zeros((1, 3)), kernels="mueller2003")
    printed.native.evaluate()
    corrected.native.evaluate()
    whole, others, _, _ = _native.lattice_sums_mueller2003(2.3, 1.0)
    assert corrected.density[0] == pytest.approx(1060.0 * (whole - others) / whole, rel=1e-9)
    assert printed.density[0] == pytest.approx(0.95 * 1060.0 * others, rel=1e-9)
    assert printed.pressure[0] < 0.0 <= corrected.pressure[0]
