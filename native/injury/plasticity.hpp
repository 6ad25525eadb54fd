// Return maps in principal Hencky strains: von Mises and Drucker-Prager with linear softening,
// tension cut-off of the pressure (cavitation) and of the principal stress (Rankine).
#pragma once

#include "injury/damage.hpp"
#include "injury/elasticity.hpp"

namespace vulnus::injury {

// Steepest fall of the yield stress over the elastic slope 3 mu. Chosen: above the 1/1.1 that
// `materials.Material.damage_span` leaves at rest, below the 1 of snap-back.
constexpr double kSteepestSoftening = 0.95;

// What a material point remembers: elastic strain b_e - I, equivalent plastic strain, and the
// volumetric (logarithmic) strain of its open voids and cracks.
template <class R>
struct PointState {
  Symmetric3<R> strain;
  R plastic_strain;
  R opening;
};

template <class R>
struct StressUpdate {
  Symmetric3<R> kirchhoff;
  R sound_speed_squared;
};

// 1 + (rate / reference)^exponent (PHYSICS 1.2); 1 where the material has no reference rate.
template <class R>
VULNUS_HD R rate_factor(const Material<R>& m, R rate) {
  const R one = broadcast<R>(1);
  const auto rated = m.rate_reference > R{};
  const R reference = select(rated, m.rate_reference, one);
  const R ratio = maximum(rate / reference, broadcast<R>(1e-12));
  return one + select(rated, power(ratio, m.rate_exponent), R{});
}

// Compression closes voids before it loads the material.
template <class R>
VULNUS_HD void close_opening(R (&strain)[3], R& opening) {
  const R trace = strain[0] + strain[1] + strain[2];
  const R closed = minimum(maximum(-trace, R{}), opening);
  opening -= closed;
  for (int a = 0; a < 3; ++a) strain[a] += closed * broadcast<R>(1.0 / 3.0);
}

// Radial return at constant pressure (isochoric flow): q = sqrt(3/2)|dev tau| <= Y(alpha) + M p,
// with Y falling linearly within the step where damage has begun. High rates raise Y and its slope;
// the slope stops short of 3 mu, beyond which a point would snap back and gain strength.
template <class R>
VULNUS_HD auto return_to_shear_yield(const Material<R>& m, R rate, R (&strain)[3],
                                     R& plastic_strain) {
  const R one = broadcast<R>(1);
  const R mean = (strain[0] + strain[1] + strain[2]) * broadcast<R>(1.0 / 3.0);
  R deviator[3];
  for (int a = 0; a < 3; ++a) deviator[a] = strain[a] - mean;
  const R norm_squared =
      deviator[0] * deviator[0] + deviator[1] * deviator[1] + deviator[2] * deviator[2];
  const R three_mu = broadcast<R>(3) * m.shear_modulus;
  const R q = three_mu * square_root(broadcast<R>(2.0 / 3.0) * norm_squared);
  const R pressure = -m.bulk_modulus * mean * broadcast<R>(3);
  const R full = m.yield_stress * rate_factor(m, rate);
  const R cohesion = full * (one - damage_of(m, plastic_strain));
  const R frictional = m.friction * pressure;
  const R yield = maximum(cohesion + frictional, R{});
  const auto flowing = q > yield;
  const auto softening = (plastic_strain >= m.damage_start) & (plastic_strain < m.damage_end);
  const R steepest = broadcast<R>(kSteepestSoftening) * three_mu;
  const R slope = select(softening, minimum(full / (m.damage_end - m.damage_start), steepest), R{});
  const R guess = (q - yield) / (three_mu - slope);
  const R softened = maximum(maximum(cohesion - slope * guess, R{}) + frictional, R{});
  const R scale = select(flowing, softened / maximum(q, broadcast<R>(1e-30)), one);
  for (int a = 0; a < 3; ++a) strain[a] = mean + scale * deviator[a];
  plastic_strain += select(flowing, (q - softened) / three_mu, R{});
  return flowing;
}

// Largest tension of the pressure: what exceeds it opens voids.
template <class R>
VULNUS_HD auto return_to_pressure_cutoff(const Material<R>& m, R (&strain)[3], R& plastic_strain,
                                         R& opening) {
  const R trace = strain[0] + strain[1] + strain[2];
  const R sound = broadcast<R>(1) - damage_of(m, plastic_strain);
  const R excess = maximum(trace - sound * m.pressure_cutoff / m.bulk_modulus, R{});
  for (int a = 0; a < 3; ++a) strain[a] -= excess * broadcast<R>(1.0 / 3.0);
  opening += excess;
  plastic_strain += m.opening_damage * excess;
  return excess > R{};
}

// Closest-point return to max principal stress <= f_t. With n active principal stresses the sum of
// the crack strains is S_n = sum(tau - f_t) / (n lambda + 2 mu); the right n has the largest S_n.
template <class R>
VULNUS_HD auto return_to_rankine(const Material<R>& m, R (&strain)[3], R& plastic_strain,
                                 R& opening) {
  const R two_mu = broadcast<R>(2) * m.shear_modulus;
  const R lambda = m.bulk_modulus - two_mu * broadcast<R>(1.0 / 3.0);
  const R strength = m.tensile_strength * (broadcast<R>(1) - damage_of(m, plastic_strain));
  const R trace = strain[0] + strain[1] + strain[2];
  R over[3];
  for (int a = 0; a < 3; ++a) over[a] = two_mu * strain[a] + lambda * trace - strength;
  const R largest = maximum(over[0], maximum(over[1], over[2]));
  const R smallest = minimum(over[0], minimum(over[1], over[2]));
  const R total = over[0] + over[1] + over[2];
  R crack = maximum(R{}, largest / (lambda + two_mu));
  crack = maximum(crack, (total - smallest) / (broadcast<R>(2) * lambda + two_mu));
  crack = maximum(crack, total / (broadcast<R>(3) * lambda + two_mu));
  const auto cracking = largest > R{};
  crack = select(cracking, crack, R{});
  for (int a = 0; a < 3; ++a) {
    const R part = maximum(over[a] - lambda * crack, R{}) / two_mu;
    strain[a] -= select(cracking, part, R{});
  }
  opening += crack;
  plastic_strain += m.opening_damage * crack;
  return cracking;
}

// Returns the trial state of a step to all limits and gives its stress.
template <class R>
VULNUS_HD StressUpdate<R> update_stress(const Material<R>& m, R rate, PointState<R>& point) {
  const Eigen3<R> e = symmetric_eigen(point.strain);
  R hencky[3], stress[3], rebuilt[3];
  for (int a = 0; a < 3; ++a) hencky[a] = broadcast<R>(0.5) * log_one_plus(e.value[a]);
  const R opening = point.opening;
  close_opening(hencky, point.opening);
  auto changed = return_to_shear_yield(m, rate, hencky, point.plastic_strain);
  changed |= return_to_pressure_cutoff(m, hencky, point.plastic_strain, point.opening);
  changed |= return_to_rankine(m, hencky, point.plastic_strain, point.opening);
  changed |= opening > R{};
  hencky_kirchhoff(m, hencky, stress);
  for (int a = 0; a < 3; ++a) rebuilt[a] = exp_minus_one(broadcast<R>(2) * hencky[a]);
  const Symmetric3<R> b = from_principal(e.vector, rebuilt);
  Symmetric3<R>& s = point.strain;
  s = {select(changed, b.xx, s.xx), select(changed, b.yy, s.yy), select(changed, b.zz, s.zz),
       select(changed, b.xy, s.xy), select(changed, b.yz, s.yz), select(changed, b.zx, s.zx)};
  return {from_principal(e.vector, stress),
          sound_speed_squared(m, hencky[0] + hencky[1] + hencky[2])};
}

}  // namespace vulnus::injury
