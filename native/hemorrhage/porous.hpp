// Tissue as a porous medium that blood seeps through.
#pragma once

#include <cmath>

#include "core/host_device.hpp"
#include "hemorrhage/smoothing_kernel.hpp"

namespace vulnus::hemorrhage {

// Grain diameter [m] by damage: 82 um (a muscle fibre; gives K = 1e-13 m^2, the measured
// conductivity of intact muscle, at eps = 0.12), 0.5 mm from bruised (0.3) to torn (0.7), 1 mm
// shredded (1); log-linear between (PHYSICS 4.3).
VULNUS_HD double grain_diameter(double damage) {
  const double intact = std::log(82e-6), torn = std::log(0.5e-3), shredded = std::log(1e-3);
  if (damage <= 0.3) return std::exp(intact + (torn - intact) * positive(damage) / 0.3);
  if (damage <= 0.7) return 0.5e-3;
  const double share = damage < 1.0 ? (damage - 0.7) / 0.3 : 1.0;
  return std::exp(torn + (shredded - torn) * share);
}

// Rate at which tissue stops blood, eps mu / (rho K) [1/s].
template <class Real>
VULNUS_HD Real drag_rate(Real porosity, Real viscosity, Real density, Real permeability) {
  return porosity * viscosity / (density * permeability);
}

// Equation: Chong2017 (13)
// f_d = -eps mu/K v, taken at the end of the step: v <- v*/(1 + dt eps mu/(rho K)), stable at any
// dt.
template <class Real>
VULNUS_HD Real darcy_drag_implicit(Real velocity, Real dt, Real rate) {
  return velocity / (Real(1) + dt * rate);
}

// Equation: Chong2017 (3)
// One step of the Brinkman equation for the pore velocity, one component: all of eq. (2), then
// drag.
template <class Real>
VULNUS_HD Real brinkman_velocity(Real velocity, Real dt, Real navier_stokes, Real rate) {
  const Real predicted = velocity + dt * navier_stokes;
  return darcy_drag_implicit(predicted, dt, rate);
}

}  // namespace vulnus::hemorrhage
