"""Kernels are what they claim: normalised, with the stated gradient and Laplacian."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.hemorrhage import _native

H = 2e-3
KERNELS = {
    "mueller2003": _native.kernels_mueller2003,
    "wendland_c2": _native.kernels_wendland_c2,
}


def radial_integral(values: np.ndarray, r: np.ndarray) -> float:
    return float(np.trapezoid(4.0 * np.pi * r**2 * values, r))


@pytest.mark.parametrize("name", KERNELS)
def test_density_kernel_integrates_to_one(name):
    """Equation: Chong2017 (5). Positive, unlike as printed; the trapezoid's error is 1e-7."""
    r = np.linspace(0.0, H, 20001)
    w = np.array([KERNELS[name](x, H)[0] for x in r])
    assert w.min() >= 0.0
    assert radial_integral(w, r) == pytest.approx(1.0, abs=1e-6)


def test_wendland_gradient_is_the_derivative_of_its_kernel():
    """Central differences of step 1e-4 h err by 1e-7."""
    step = 1e-4 * H
    for r in np.linspace(0.05, 0.95, 19) * H:
        w = KERNELS["wendland_c2"]
        difference = (w(r + step, H)[0] - w(r - step, H)[0]) / (2.0 * step)
        assert w(r, H)[1] == pytest.approx(-difference, rel=1e-5)


def test_spiky_gradient_is_the_derivative_of_the_spiky_kernel():
    """Equation: Chong2017 (8). W = 15/(pi h^6) (h - r)^3 by central differences."""
    step = 1e-4 * H

    def spiky(r):
        return 15.0 / (np.pi * H**6) * (H - r) ** 3

    for r in np.linspace(0.05, 0.95, 19) * H:
        difference = (spiky(r + step) - spiky(r - step)) / (2.0 * step)
        assert KERNELS["mueller2003"](r, H)[1] == pytest.approx(-difference, rel=1e-5)


def test_viscosity_laplacian_is_that_of_the_viscosity_kernel():
    """Equation: Chong2017 (9). W = 15/(2 pi h^3)(-r^3/2h^3 + r^2/h^2 + h/2r - 1), W'' + 2W'/r."""
    step = 1e-3 * H

    def viscosity(r):
        shape = -(r**3) / (2 * H**3) + r**2 / H**2 + H / (2 * r) - 1.0
        return 15.0 / (2.0 * np.pi * H**3) * shape

    for r in np.linspace(0.2, 0.9, 15) * H:
        second = (viscosity(r + step) - 2 * viscosity(r) + viscosity(r - step)) / step**2
        first = (viscosity(r + step) - viscosity(r - step)) / (2 * step)
        laplacian = second + 2.0 * first / r
        assert KERNELS["mueller2003"](r, H)[2] == pytest.approx(laplacian, rel=1e-3)


@pytest.mark.parametrize("name", KERNELS)
def test_continuum_gradient_and_laplacian_are_exact_for_linear_and_quadratic_fields(name):
    """Integral of r |W'| / 3 and of r^2 laplace W / 6 over space are 1."""
    r = np.linspace(1e-9, H, 20001)
    values = np.array([KERNELS[name](x, H) for x in r])
    assert radial_integral(values[:, 1] * r / 3.0, r) == pytest.approx(1.0, abs=1e-6)
    assert radial_integral(values[:, 2] * r**2 / 6.0, r) == pytest.approx(1.0, abs=1e-6)


def test_lattice_sum_of_poly6():
    """Equation: Chong2017 (6). PHYSICS S0: 1.0098 at h = 2 dx, of which 19 % is the self term."""
    whole, others, _, _ = _native.lattice_sums_mueller2003(2.0, 1.0)
    assert whole == pytest.approx(1.0098, abs=5e-5)
    assert (whole - others) / whole == pytest.approx(0.19, abs=5e-3)
