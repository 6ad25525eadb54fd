"""Volumetric locking and what averaging the volume rate over a cell does about it (B-bar)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit

from vulnus.injury.boundaries import HeldEnds, Wall
from vulnus.injury.materials import elastic, material_table
from vulnus.injury.solver import STRAIN, MpmSolver, set_threads

pytestmark = pytest.mark.physics

SPACING = 0.01
DENSITY = 1000.0


def solver_of(law, x, *, boundaries=(), gravity=(0.0, 0.0, 0.0), precision="float32", v=None):
    solver = MpmSolver(
        materials=material_table([law], SPACING), grid_spacing=SPACING, lower=(-1.0,) * 3,
        upper=(1.0,) * 3, gravity=gravity, boundaries=boundaries, precision=precision,
    )  # fmt: skip
    volume = np.full(len(x), (SPACING / 2.0) ** 3)
    solver.set_particles(x, volume=volume, material=np.zeros(len(x), np.uint8), velocity=v)
    return solver


def lattice(*cells):
    """Eight points a cell; each of `cells` is a range of cell numbers."""
    axes = [(np.arange(2 * c.start, 2 * c.stop) + 0.5) * SPACING / 2.0 for c in cells]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


@pytest.fixture(autouse=True)
def _one_thread():
    """Bodies of a few hundred points: a second thread only waits."""
    set_threads(1)
    yield
    set_threads(0)


def cantilever_deflection(averaging: bool) -> float:
    """Static deflection under its own weight over that of a Timoshenko beam; nu = 0.4999.

    3 cells deep and 9 long; from a damped swing u = d (1 - exp(-z w t) cos w t) fitted to the tip.
    """
    young, poisson, depth, cells = 1e6, 0.4999, 3 * SPACING, 9
    length = cells * SPACING
    law = replace(elastic(DENSITY, young, poisson), volume_averaging=averaging)
    x = lattice(range(-3, cells), range(3), range(2))
    bending = DENSITY * length**4 * 12.0 / (8.0 * young * depth**2)
    shear_factor = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson)
    shear = DENSITY * length**2 * (1.0 + poisson) / (shear_factor * young)
    deflection = 0.01 * length
    period = 2.0 * np.pi / (3.516 / length**2 * depth * np.sqrt(young / (12.0 * DENSITY)))
    solver = solver_of(
        law, x, gravity=(0.0, -deflection / (bending + shear), 0.0),
        boundaries=[HeldEnds(axis=(1.0, 0.0, 0.0), lower=0.25 * SPACING, upper=1.0)],
    )  # fmt: skip
    tip = x[:, 0] > length - 0.6 * SPACING
    # A locked beam swings four times as fast.
    times, tips = np.linspace(0.1, 1.0 if averaging else 0.4, 19), []
    for t in times:
        solver.advance(until=t * period)
        tips.append(np.mean(x[tip, 1] - solver.position[tip, 1]) / deflection)

    def swing(t, static, speed, damping):
        return static * (1.0 - np.exp(-damping * speed * t) * np.cos(speed * t))

    return float(curve_fit(swing, 2.0 * np.pi * times, tips, p0=(1.0, 1.0, 0.1))[0][0])


def test_a_nearly_incompressible_cantilever_bends_as_the_theory_says():
    """PHYSICS M3 at nu = 0.4999 and three cells: 30 % off with the averaging, 3 times without.

    With it what is left is the resolution (19 % at 3, 13 % at 4 cells of depth) and the clamp,
    which keeps the ends from narrowing.
    """
    assert cantilever_deflection(averaging=True) == pytest.approx(0.85, abs=0.15)
    assert cantilever_deflection(averaging=False) < 0.4  # it locks: this case needs the averaging


def column_pressure_error(averaging: bool) -> float:
    """Rms error of the pressure in a box of heavy jelly, one cell from the walls, over rho g H."""
    cells, gravity = 6, 9.81
    law = replace(elastic(DENSITY, 1e5, 0.4999), volume_averaging=averaging)
    x = lattice(range(cells), range(cells), range(cells))
    side = cells * SPACING
    walls = [
        Wall(point=tuple(side * (s < 0) * e), normal=tuple(s * e), kind="slip")
        for e in np.eye(3)
        for s in (1.0, -1.0)
        if not (e[2] == 1.0 and s < 0.0)
    ]
    solver = solver_of(law, x, boundaries=walls, gravity=(0.0, 0.0, -gravity))
    solver.advance(until=0.02)
    pressure = []
    for t in 0.02 + np.linspace(0.0, 0.003, 12):  # some periods 4 H / c of the column's bounce
        solver.advance(until=t)
        pressure.append(solver.pressure)
    expected = DENSITY * gravity * (side - x[:, 2])
    inside = np.all((x > SPACING) & (x < side - SPACING), axis=1)
    error = (np.mean(pressure, axis=0) - expected)[inside]
    return float(np.sqrt(np.mean(error**2)) / (DENSITY * gravity * side))


def test_hydrostatic_pressure_is_smooth():
    """Constant in cells of 1/6 of the height it cannot be better than 0.042 (rms); it is 0.051.

    Between mirrors the column does not lock, so that without the averaging it is 0.028.
    """
    assert column_pressure_error(averaging=True) < 0.06
    assert column_pressure_error(averaging=False) < 0.04


def test_points_of_a_cell_get_one_volume_rate_and_keep_their_shears():
    """ln J grows alike within each cell; the volume-weighted mean of the cell is kept."""
    rng = np.random.default_rng(2)
    x = rng.uniform(0.0, 0.04, (500, 3))
    volume = rng.uniform(0.5, 2.0, 500) * 1e-7
    v = 20.0 * np.sin(120.0 * x[:, [1, 2, 0]]) + 30.0 * np.sin(90.0 * x)
    out = {}
    for averaging in (False, True):
        law = replace(elastic(DENSITY, 1e6, 0.45), volume_averaging=averaging)
        solver = MpmSolver(
            materials=material_table([law], SPACING), grid_spacing=SPACING, lower=(-1.0,) * 3,
            upper=(1.0,) * 3, precision="float64",
        )  # fmt: skip
        solver.set_particles(x, volume=volume, material=np.zeros(500, np.uint8), velocity=v)
        solver.advance(until=1e-6)
        out[averaging] = solver._native.values(STRAIN, 6)
    rate = {key: np.sum(e[:, :3], axis=1) for key, e in out.items()}
    _, cell = np.unique(np.floor(x / SPACING - 0.5), axis=0, return_inverse=True)
    cell = cell.ravel()
    weight = np.bincount(cell, volume)
    mean = np.bincount(cell, volume * rate[False]) / weight
    # Strains of 1e-4 in one step: what is quadratic in them is 1e-8.
    assert np.max(np.abs(rate[True] - mean[cell])) < 1e-3 * np.max(np.abs(rate[False]))
    assert np.max(np.abs(rate[True] - rate[False])) > 0.1 * np.max(np.abs(rate[False]))
    assert np.allclose(out[True][:, 3:], out[False][:, 3:], atol=1e-3 * np.max(np.abs(out[False])))


def test_energy_is_not_made():
    """A jelly cube that rings with random velocities: APIC takes energy, the averaging gives none.

    0.2 %: the elastic energy is read half a step from the kinetic one.
    """
    x = lattice(range(5), range(5), range(5))
    rng = np.random.default_rng(6)
    v = np.sum([rng.normal(size=3) * np.sin(x @ rng.normal(0, 60, (3, 1))) for _ in range(6)], 0)
    law = elastic(DENSITY, 1e5, 0.49)
    assert law.volume_averaging
    solver = solver_of(law, x, precision="float64", v=v)
    first = sum(solver.energies().values())
    last = first
    for t in np.linspace(0.0, 0.02, 11)[1:]:
        solver.advance(until=t)
        energy = sum(solver.energies().values())
        assert energy < last + 2e-3 * first
        last = energy
    assert last > 0.1 * first


def test_materials_that_share_a_cell_have_a_mean_of_their_own():
    """ln J grows by the volume-weighted mean over the points of one material in one cell."""
    rng = np.random.default_rng(3)
    x = rng.uniform(0.0, 0.03, (300, 3))
    volume = rng.uniform(0.5, 2.0, 300) * 1e-7
    material = rng.integers(0, 3, 300).astype(np.uint8)
    v = 20.0 * np.sin(120.0 * x[:, [1, 2, 0]]) + 30.0 * np.sin(90.0 * x)
    rate = {}
    for averaging in (False, True):
        law = replace(elastic(DENSITY, 1e6, 0.45), volume_averaging=averaging)
        plain = replace(law, volume_averaging=False)
        solver = MpmSolver(
            materials=material_table([law, law, plain], SPACING), grid_spacing=SPACING,
            lower=(-1.0,) * 3, upper=(1.0,) * 3, precision="float64",
        )  # fmt: skip
        solver.set_particles(x, volume=volume, material=material, velocity=v)
        solver.advance(until=1e-6)
        rate[averaging] = np.sum(solver._native.values(STRAIN, 6)[:, :3], axis=1)
    place = np.column_stack([np.floor(x / SPACING - 0.5), material])
    _, group = np.unique(place, axis=0, return_inverse=True)
    group = group.ravel()
    mean = np.bincount(group, volume * rate[False]) / np.bincount(group, volume)
    expected = np.where(material < 2, mean[group], rate[False])
    # Strains of 1e-4 in one step: what is quadratic in them is 1e-8.
    assert np.max(np.abs(rate[True] - expected)) < 1e-3 * np.max(np.abs(rate[False]))
