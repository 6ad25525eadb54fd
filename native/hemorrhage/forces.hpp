// Forces between two particles and on one, as accelerations a = f / rho.
#pragma once

#include "core/host_device.hpp"
#include "hemorrhage/smoothing_kernel.hpp"

namespace vulnus::hemorrhage {

// Equation: Chong2017 (4)
// The share of neighbour j in an interpolated quantity, A_j m_j / rho_j W.
template <class Real>
VULNUS_HD Real interpolation_share(Real quantity, Real mass_over_density, Real kernel) {
  return quantity * mass_over_density * kernel;
}

// Equation: Chong2017 (6)
// The share of neighbour j in the density of i, m_j W(r_i - r_j); j = i is one of them. `weight`
// is the neighbour's mass over a whole particle's, or rho0 V_b over it for a barrier particle.
template <class Real>
VULNUS_HD Real density_share(Real weight, Real kernel) {
  return weight * kernel;
}

// Equation: Chong2017 (10)
// a_i = - sum_j m_j (p_i/rho_i^2 + p_j/rho_j^2) grad W_p with the sign that makes pressure repel;
// returned without m and the kernel's factor, to be multiplied by r_i - r_j. `dissipation` is the
// pair's shock pressure over rho^2.
template <class Real>
VULNUS_HD Real pressure_pair(Real weight, Real p_over_rho2_i, Real p_over_rho2_j, Real dissipation,
                             Real gradient_over_r) {
  return weight * (p_over_rho2_i + p_over_rho2_j + dissipation) * gradient_over_r;
}

// Equation: Chong2017 (11)
// a_i = mu/rho_i sum_j (v_j - v_i) m_j/rho_j laplace W_v; returned without mu m / rho_i and the
// kernel's factor, to be multiplied by v_j - v_i.
template <class Real>
VULNUS_HD Real viscosity_pair(Real weight, Real inverse_density_j, Real laplacian) {
  return weight * inverse_density_j * laplacian;
}

// Pressure between two particles that close in at speed u, over rho^2: min(3 u, c0) u / rho, the
// limited dissipation of Zhang, Hu & Adams 2017 (JCP 335:605). It vanishes with u^2, so smooth
// flow keeps the viscosity of blood; it takes the ringing out of weakly compressible pressure.
template <class Real>
VULNUS_HD Real dissipation_zhang2017(Real closing_speed, Real coefficient, Real sound_speed,
                                     Real inverse_density) {
  const Real u = positive(closing_speed);
  const Real limited = coefficient * u < sound_speed ? coefficient * u : sound_speed;
  return limited * u * inverse_density;
}

// Pressure of blood continued to a barrier particle, p_j + rho0 g.(r_b - r_j), so that blood at
// rest stays at rest on a floor (Adami, Hu & Adams 2012, JCP 231:7057).
template <class Real>
VULNUS_HD Real mirrored_pressure(Real pressure, Real density, Real gravity_dot_offset) {
  return pressure + density * gravity_dot_offset;
}

// Equation: Chong2017 (12)
// Gravity per mass of blood.
template <class Real>
VULNUS_HD Real gravity_acceleration(Real gravity) {
  return gravity;
}

// Equation: Chong2017 (2)
// Dv/Dt = -grad p / rho + mu laplace v / rho + g in free blood, one component.
template <class Real>
VULNUS_HD Real navier_stokes_acceleration(Real pressure, Real viscosity, Real gravity) {
  return pressure + viscosity + gravity_acceleration(gravity);
}

}  // namespace vulnus::hemorrhage
