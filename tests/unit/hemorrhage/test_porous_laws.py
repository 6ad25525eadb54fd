"""Laws of tissue as a porous medium."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.hemorrhage import _native
from vulnus.hemorrhage.tissue_field import (
    grain_diameters,
    permeability_kozeny_carman,
    porosity_from_density,
)


@pytest.mark.parametrize(
    ("porosity", "grain", "permeability"),
    [(0.4, 0.5e-3, 3e-10), (0.7, 0.5e-3, 6.4e-9), (0.9, 1e-3, 4.9e-7)],
)
def test_kozeny_carman_gives_the_table(porosity, grain, permeability):
    """PHYSICS 4.3, whose numbers have two digits."""
    found = permeability_kozeny_carman(np.float32([porosity]), np.float32([grain]))
    assert found[0] == pytest.approx(permeability, rel=0.05)


def test_intact_muscle_is_as_tight_as_measured():
    """PHYSICS 4.3: 8e-14 to 8e-13 m^2 measured."""
    (k,) = permeability_kozeny_carman(np.float32([0.12]), grain_diameters(np.float32([0.0])))
    assert 8e-14 < k < 8e-13


def test_grains_grow_with_damage():
    sizes = [_native.grain_diameter(d / 20) for d in range(21)]
    assert all(b >= a * (1.0 - 1e-12) for a, b in pairwise(sizes))
    assert sizes[-1] == pytest.approx(1e-3)


def test_porosity_of_intact_empty_and_packed_tissue():
    intact, empty, packed = porosity_from_density(np.float32([1.0, 0.0, 2.0]), 0.12)
    assert intact == pytest.approx(0.12)
    assert empty == 1.0
    assert packed == np.float32(0.05)


def test_pressure_is_linear_in_density():
    """Equation: Chong2017 (7)."""
    assert _native.pressure_linear(1070.0, 1060.0, 900.0) == pytest.approx(9000.0)


@settings(derandomize=True, max_examples=50)
@given(st.floats(-10, 10), st.floats(1e-7, 1e-3), st.floats(0, 1e12))
def test_drag_never_reverses_or_speeds_up_blood(velocity, dt, rate):
    """Equation: Chong2017 (13). Implicit: |v| falls, its sign stays, at any step."""
    after = _native.brinkman_velocity(velocity, dt, 0.0, rate)
    assert abs(after) <= abs(velocity)
    assert after * velocity >= 0.0


def test_brinkman_velocity_tends_to_darcy():
    """Equation: Chong2017 (3). With steps of 100 times rho K/(eps mu), one step is Darcy's."""
    eps, mu, rho, k, force = 0.3, 3.5e-3, 1060.0, 1e-10, 500.0
    rate = _native.drag_rate(eps, mu, rho, k)
    v = _native.brinkman_velocity(0.0, 100.0 / rate, force, rate)
    assert v == pytest.approx(k * rho * force / (eps * mu), rel=0.01)


def test_without_tissue_the_step_is_navier_stokes():
    """Equation: Chong2017 (2)."""
    assert _native.brinkman_velocity(1.0, 0.1, 2.0, 0.0) == pytest.approx(1.2)
