// Pressure as a function of the volumetric Hencky strain tr(eps) = ln J.
#pragma once

#include "injury/material.hpp"

namespace vulnus::injury {

// Kirchhoff pressure part of the stress, -J p [Pa].
// Tait: p = (K/n)(J^-n - 1) (PHYSICS 1.4, n = 7); linear: -J p = K ln J.
template <class R>
VULNUS_HD R volumetric_kirchhoff(const Material<R>& m, R trace) {
  const auto linear = m.tait_exponent <= R{};
  const R n = select(linear, broadcast<R>(1), m.tait_exponent);
  const R jacobian = exp_minus_one(trace) + broadcast<R>(1);
  const R tait = jacobian * (m.bulk_modulus / n) * -exp_minus_one(-n * trace);
  return select(linear, m.bulk_modulus * trace, tait);
}

// Square of the longitudinal wave speed [m^2/s^2]; compression stiffens the Tait law.
template <class R>
VULNUS_HD R sound_speed_squared(const Material<R>& m, R trace) {
  const R stiffening = exp_minus_one(-m.tait_exponent * trace) + broadcast<R>(1);
  return (m.bulk_modulus * stiffening + broadcast<R>(4.0 / 3.0) * m.shear_modulus) / m.density;
}

}  // namespace vulnus::injury
