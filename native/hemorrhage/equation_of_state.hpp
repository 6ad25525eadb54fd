// Pressure of weakly compressible blood from its density.
#pragma once

#include "core/host_device.hpp"

namespace vulnus::hemorrhage {

// Equation: Chong2017 (7)
// p = k (rho - rho0), k = c0^2 [m^2/s^2].
template <class Real>
VULNUS_HD Real pressure_linear(Real density, Real rest_density, Real sound_speed_squared) {
  return sound_speed_squared * (density - rest_density);
}

// No tension: a particle with too few neighbours is at the free surface, where p = 0.
template <class Real>
VULNUS_HD Real pressure_clamped(Real pressure) {
  return pressure > Real(0) ? pressure : Real(0);
}

}  // namespace vulnus::hemorrhage
