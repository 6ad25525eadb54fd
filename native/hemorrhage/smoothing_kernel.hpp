// Smoothing kernels: what share of a particle's quantity is felt at distance r.
//
// A kernel set offers the three forms that the sums need, without their constant factors, so that
// a loop multiplies by them once: `density`, `gradient_over_r` (= -W'(r)/r) and `laplacian`.
#pragma once

#include <cmath>
#include <numbers>

#include "core/host_device.hpp"

namespace vulnus::hemorrhage {

template <class Real>
VULNUS_HD Real positive(Real value) {
  return value > Real(0) ? value : Real(0);
}

// Equation: Chong2017 (5)
// W = 315/(64 pi h^9) (h^2 - r^2)^3, positive (PHYSICS 4.1b), without the factor.
template <class Real>
VULNUS_HD Real poly6_mueller2003(Real r2, Real h2) {
  const Real q = positive(h2 - r2);
  return q * q * q;
}

// Equation: Chong2017 (8)
// grad W_p = -45/(pi h^6) (h - r)^2 r_hat; here -W'/r without the factor.
template <class Real>
VULNUS_HD Real spiky_gradient_over_r_mueller2003(Real r, Real inverse_r, Real h) {
  const Real q = positive(h - r);
  return q * q * inverse_r;
}

// Equation: Chong2017 (9)
// laplace W_v = 45/(pi h^6) (h - r), without the factor.
template <class Real>
VULNUS_HD Real viscosity_laplacian_mueller2003(Real r, Real h) {
  return positive(h - r);
}

// The paper's three kernels (Mueller 2003), cut off at h.
template <class Real>
struct MuellerKernels {
  Real h, h2, density_factor, gradient_factor, laplacian_factor;

  explicit MuellerKernels(double radius)
      : h(Real(radius)),
        h2(Real(radius * radius)),
        density_factor(Real(315.0 / (64.0 * std::numbers::pi * std::pow(radius, 9)))),
        gradient_factor(Real(45.0 / (std::numbers::pi * std::pow(radius, 6)))),
        laplacian_factor(gradient_factor) {}

  VULNUS_HD Real density(Real r2) const { return poly6_mueller2003(r2, h2); }
  VULNUS_HD Real gradient_over_r(Real r, Real inverse_r) const {
    return spiky_gradient_over_r_mueller2003(r, inverse_r, h);
  }
  VULNUS_HD Real laplacian(Real r) const { return viscosity_laplacian_mueller2003(r, h); }
};

// Wendland C2 in three dimensions (Wendland 1995), cut off at h:
// W = 21/(2 pi h^3) (1 - q)^4 (4 q + 1), q = r/h; W' = -210/(pi h^4) q (1 - q)^3.
// Its Laplacian is Brookshaw's -2 W'/r (Morris 1997).
template <class Real>
struct WendlandKernels {
  Real h, h2, inverse_h, density_factor, gradient_factor, laplacian_factor;

  explicit WendlandKernels(double radius)
      : h(Real(radius)),
        h2(Real(radius * radius)),
        inverse_h(Real(1.0 / radius)),
        density_factor(Real(21.0 / (2.0 * std::numbers::pi * std::pow(radius, 3)))),
        gradient_factor(Real(210.0 / (std::numbers::pi * std::pow(radius, 5)))),
        laplacian_factor(Real(2) * gradient_factor) {}

  VULNUS_HD Real density(Real r2) const {
    const Real q = std::sqrt(r2) * inverse_h;
    const Real s = positive(Real(1) - q);
    return s * s * s * s * (Real(4) * q + Real(1));
  }
  VULNUS_HD Real gradient_over_r(Real r, Real /*inverse_r*/) const {
    const Real s = positive(Real(1) - r * inverse_h);
    return s * s * s;
  }
  VULNUS_HD Real laplacian(Real r) const { return gradient_over_r(r, Real(0)); }
};

// How far a cubic lattice of spacing dx is from the continuum: what the discrete sums return for a
// constant (density), a linear field's slope (gradient) and a quadratic field's Laplacian, all 1
// in the continuum. Poly6 at h = 2 dx: 1.0098 (PHYSICS S0); 19 % of it is the self term.
struct LatticeSums {
  double density = 0.0, density_without_self = 0.0, gradient = 0.0, laplacian = 0.0;
};

template <class Kernels>
LatticeSums lattice_sums(double h, double dx) {
  const Kernels kernels(h);
  const int reach = static_cast<int>(std::ceil(h / dx));
  const double volume = dx * dx * dx;
  LatticeSums sums;
  for (int k = -reach; k <= reach; ++k) {
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        const double r2 = dx * dx * (i * i + j * j + k * k);
        if (r2 >= h * h) continue;
        const double w = volume * kernels.density(r2) * kernels.density_factor;
        sums.density += w;
        if (r2 == 0.0) continue;
        sums.density_without_self += w;
        const double r = std::sqrt(r2);
        const double slope = kernels.gradient_over_r(r, 1.0 / r) * kernels.gradient_factor;
        sums.gradient += volume * slope * r2 / 3.0;
        sums.laplacian += volume * kernels.laplacian(r) * kernels.laplacian_factor * r2 / 6.0;
      }
    }
  }
  return sums;
}

}  // namespace vulnus::hemorrhage
