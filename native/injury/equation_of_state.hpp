// Pressure as a function of the volumetric Hencky strain t = tr(eps) = ln J.
#pragma once

#include "injury/material.hpp"

namespace vulnus::injury {

// Kirchhoff pressure part of the stress, -J p = (K/n) (J^a - J^(a-n)) [Pa]:
// Tait (PHYSICS 1.4) n = 7, a = 1: p = (K/7)(J^-7 - 1); quadratic (PHYSICS 1.4, neo-Hookean)
// n = 2, a = 2: (K/2)(J^2 - 1); its limit for n = 0, a = 0, linear: K ln J.
template <class R>
VULNUS_HD R volumetric_kirchhoff(const Material<R>& m, R trace) {
  const auto linear = m.volume_exponent <= R{};
  const R n = select(linear, broadcast<R>(1), m.volume_exponent);
  const R growth = exp_minus_one(m.volume_growth * trace) + broadcast<R>(1);
  const R curved = growth * (m.bulk_modulus / n) * -exp_minus_one(-m.volume_exponent * trace);
  return select(linear, m.bulk_modulus * trace, curved);
}

// (exp(x t) - 1) / x, t where x is 0.
template <class R>
VULNUS_HD R exponential_growth(R x, R t) {
  const auto none = x == R{};
  return select(none, t, exp_minus_one(x * t) / select(none, broadcast<R>(1), x));
}

// Stored energy [J/m^3, undeformed]: the integral of the Kirchhoff pressure part over t.
template <class R>
VULNUS_HD R volumetric_energy(const Material<R>& m, R trace) {
  const auto linear = m.volume_exponent <= R{};
  const R n = select(linear, broadcast<R>(1), m.volume_exponent);
  const R a = m.volume_growth;
  const R curved = exponential_growth(a, trace) - exponential_growth(a - m.volume_exponent, trace);
  const R square = broadcast<R>(0.5) * m.bulk_modulus * trace * trace;
  return select(linear, square, m.bulk_modulus / n * curved);
}

// The strain at which the pressure part is `wanted`, by Newton's method from t with steps up to 1.
// The part grows and is concave around 0, so that it converges from there; in 6 iterations a unit
// of strain. Few points need it in a step: it is kept out of the laws' loop, with its own
// constants.
template <class R>
[[gnu::cold, gnu::noinline]] R volume_strain_at(Material<R> m, R wanted, R t, int iterations) {
  const R one = broadcast<R>(1);
  const auto linear = m.volume_exponent <= R{};
  const R n = select(linear, one, m.volume_exponent), a = m.volume_growth;
  for (int i = 0; i < iterations; ++i) {
    const R up = exp_minus_one(a * t) + one, down = exp_minus_one((a - n) * t) + one;
    const R slope = m.bulk_modulus * (a * up - (a - n) * down) / n;
    const R step = (wanted - volumetric_kirchhoff(m, t)) / slope;
    t += minimum(maximum(step, -one), one);
  }
  return select(linear, wanted / m.bulk_modulus, t);
}

// K of a straight law through 0 with the pressure part that the strain t has; out of the loop, too.
template <class R>
[[gnu::cold, gnu::noinline]] R secant_bulk_modulus(Material<R> m, R t) {
  const auto strained = (m.volume_exponent > R{}) & (absolute(t) > broadcast<R>(1e-6));
  if (!any(strained)) return m.bulk_modulus;
  const R divisor = select(strained, t, broadcast<R>(1));
  return select(strained, volumetric_kirchhoff(m, t) / divisor, m.bulk_modulus);
}

// Slope d(-J p)/dt over K, or the larger J^-n of strong compression: stiffer than either.
template <class R>
VULNUS_HD R volumetric_stiffening(const Material<R>& m, R trace) {
  const R one = broadcast<R>(1);
  const R squeezed = exp_minus_one(-m.volume_exponent * trace) + one;
  const R stretched = exp_minus_one(m.volume_growth * trace) + one;
  return maximum(squeezed, stretched);
}

}  // namespace vulnus::injury
