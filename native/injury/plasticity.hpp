// Return maps in principal Hencky strains: von Mises and Drucker-Prager with linear hardening and
// softening, tension cut-off of the pressure (cavitation) and of the principal stress (Rankine).
#pragma once

#include "injury/elasticity.hpp"
#include "injury/network.hpp"

namespace vulnus::injury {

// Steepest fall of the yield stress over the elastic slope 3 mu. Chosen: above the 1/1.1 that
// `materials.Material.damage_span` leaves at rest, below the 1 of snap-back.
constexpr double kSteepestSoftening = 0.95;

// What a material point remembers: elastic strain b_e - I and total strain b - I of the network,
// equivalent plastic strain, the volumetric (logarithmic) strain of its open voids and cracks, and
// damage.
template <class R>
struct PointState {
  Symmetric3<R> strain;
  Symmetric3<R> network;
  R plastic_strain;
  R opening;
  R damage;

  // Of what the shear yield has softened and what the network has lost, the worse.
  VULNUS_HD R worst_damage(const Material<R>& m) const {
    return maximum(damage, softening_damage(m, plastic_strain));
  }
};

template <class R>
struct StressUpdate {
  Symmetric3<R> kirchhoff;
  R sound_speed_squared;
};

// What damage leaves of a strength. One without limit falls from the elastic `modulus` on, which no
// stress reaches, so that nothing jumps when the damage is complete.
template <class R>
VULNUS_HD R strength_left(R limit, R modulus, R sound) {
  const auto damaged = (limit > broadcast<R>(kUnlimited)) & (sound < broadcast<R>(1));
  return sound * select(damaged, modulus, limit);
}

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
// with Y linear within the step: rising by hardening, falling where damage has begun. High rates
// raise Y and its slope; the fall stops short of 3 mu, beyond which a point would snap back and
// gain strength. A material without shear modulus keeps no elastic shear. Rates only raise Y: below
// the yield at rest nothing flows.
template <class R>
VULNUS_HD Mask<R> return_to_shear_yield(const Material<R>& m, R rate, R (&strain)[3],
                                        PointState<R>& point) {
  const R one = broadcast<R>(1);
  const R mean = (strain[0] + strain[1] + strain[2]) * broadcast<R>(1.0 / 3.0);
  R deviator[3];
  for (int a = 0; a < 3; ++a) deviator[a] = strain[a] - mean;
  const R norm_squared =
      deviator[0] * deviator[0] + deviator[1] * deviator[1] + deviator[2] * deviator[2];
  const R three_mu = broadcast<R>(3) * m.shear_modulus;
  const R q = three_mu * square_root(broadcast<R>(2.0 / 3.0) * norm_squared);
  const auto rubbing = (m.friction > R{}) & (m.volume_exponent > R{});
  const R bulk = any(rubbing) ? secant_bulk_modulus(m, mean * broadcast<R>(3)) : m.bulk_modulus;
  const R pressure = -bulk * mean * broadcast<R>(3);
  const R softened_part = softening_damage(m, point.plastic_strain);
  const R sound = one - maximum(point.damage, softened_part);
  const auto never = (m.yield_stress > broadcast<R>(kUnlimited)) & (sound < one);
  const R slow = select(never, three_mu, m.yield_stress) + m.hardening * point.plastic_strain;
  const R frictional = m.friction * pressure;
  const auto fluid = three_mu <= R{};
  if (!any((q > maximum(slow * sound + frictional, R{})) | fluid)) return fluid;
  const R factor = rate_factor(m, rate);
  const R full = slow * factor;
  const R cohesion = full * sound;
  const R yield = maximum(cohesion + frictional, R{});
  const auto flowing = q > yield;
  const auto softening = (point.plastic_strain >= m.damage_start) & (softened_part < one) &
                         (softened_part >= point.damage);
  const R steepest = broadcast<R>(kSteepestSoftening) * three_mu;
  const R fall = select(softening, minimum(full * m.damage_slope, steepest), R{});
  const R slope = fall - m.hardening * factor * sound;
  const R guess = (q - yield) / (three_mu - slope);
  const R left = maximum(maximum(cohesion - slope * guess, R{}) + frictional, R{});
  const R scale = select(flowing, left / maximum(q, broadcast<R>(1e-30)), one);
  for (int a = 0; a < 3; ++a) strain[a] = mean + select(fluid, R{}, scale) * deviator[a];
  point.plastic_strain += select(flowing, (q - left) / three_mu, R{});
  return flowing | fluid;
}

constexpr int kCutoffIterations = 6;  // for strengths up to K, 1 % off there, exact below K/10
constexpr int kCrackIterations = 4;   // each leaves a part of the order of the volume strain

// Largest tension of the pressure: what exceeds it opens voids.
template <class R>
VULNUS_HD Mask<R> return_to_pressure_cutoff(const Material<R>& m, R (&strain)[3],
                                            PointState<R>& point) {
  const R trace = strain[0] + strain[1] + strain[2];
  const R sound = broadcast<R>(1) - point.worst_damage(m);
  const R strength = strength_left(m.pressure_cutoff, m.bulk_modulus, sound);
  R limit = strength / m.bulk_modulus;
  const auto bent = (m.volume_exponent > R{}) & (limit > R{}) & (limit < broadcast<R>(1)) &
                    (trace > broadcast<R>(0.9) * limit);
  if (any(bent)) {  // from the straight law's strain x one iteration leaves 15 x^4 of Tait's
    const int iterations = any(bent & (limit > broadcast<R>(0.01))) ? kCutoffIterations : 1;
    limit = select(bent, volume_strain_at(m, strength, limit, iterations), limit);
  }
  const R excess = maximum(trace - limit, R{});
  for (int a = 0; a < 3; ++a) strain[a] -= excess * broadcast<R>(1.0 / 3.0);
  point.opening += excess;
  point.plastic_strain += m.opening_damage * excess;
  return excess > R{};
}

// The sum of the crack strains of a closest-point return to max principal stress <= f_t: with n
// active principal stresses it is S_n = sum(tau - f_t) / (n lambda + 2 mu); the right n has the
// largest S_n. `over` is tau - f_t.
template <class R>
VULNUS_HD R crack_strain(const R (&over)[3], R lambda, R two_mu) {
  const R largest = maximum(over[0], maximum(over[1], over[2]));
  const R smallest = minimum(over[0], minimum(over[1], over[2]));
  const R total = over[0] + over[1] + over[2];
  R crack = maximum(R{}, largest / (lambda + two_mu));
  crack = maximum(crack, (total - smallest) / (broadcast<R>(2) * lambda + two_mu));
  return maximum(crack, total / (broadcast<R>(3) * lambda + two_mu));
}

// Crack strain and tau - f_t, and Lame's first constant that goes with them.
template <class R>
struct Crack {
  R over[3];
  R lambda, sum;
};

template <class R>
VULNUS_HD Crack<R> crack_at(R bulk, R two_mu, R strength, const R (&strain)[3]) {
  Crack<R> c;
  const R trace = strain[0] + strain[1] + strain[2];
  c.lambda = bulk - two_mu * broadcast<R>(1.0 / 3.0);
  for (int a = 0; a < 3; ++a) c.over[a] = two_mu * strain[a] + c.lambda * trace - strength;
  c.sum = R{};
  const R largest = maximum(c.over[0], maximum(c.over[1], c.over[2]));
  if (any(largest > R{})) c.sum = crack_strain(c.over, c.lambda, two_mu);
  return c;
}

// Where pressure is not straight in the volume strain its secant is, at the strain that the crack
// leaves; rare, and so out of the laws' loop.
template <class R>
[[gnu::cold, gnu::noinline]] Crack<R> bent_crack(Material<R> m, R strength, R a, R b, R c) {
  const R strain[3] = {a, b, c}, two_mu = broadcast<R>(2) * m.shear_modulus;
  Crack<R> crack = crack_at(secant_bulk_modulus(m, a + b + c), two_mu, strength, strain);
  for (int n = 0; n < kCrackIterations; ++n)
    crack = crack_at(secant_bulk_modulus(m, a + b + c - crack.sum), two_mu, strength, strain);
  return crack;
}

// The return itself. Without shear modulus the pressure's cut-off is all there is.
template <class R>
VULNUS_HD Mask<R> return_to_rankine(const Material<R>& m, R (&strain)[3], PointState<R>& point) {
  const R two_mu = broadcast<R>(2) * m.shear_modulus;
  const R sound = broadcast<R>(1) - point.worst_damage(m);
  const R strength = strength_left(m.tensile_strength, m.bulk_modulus, sound);
  const auto bent =
      (m.tensile_strength < broadcast<R>(kUnlimited)) & (two_mu > R{}) & (m.volume_exponent > R{});
  Crack<R> crack = crack_at(m.bulk_modulus, two_mu, strength, strain);
  if (any(bent)) crack = bent_crack(m, strength, strain[0], strain[1], strain[2]);
  const auto cracking = (crack.sum > R{}) & (two_mu > R{});
  if (!any(cracking)) return cracking;
  for (int a = 0; a < 3; ++a) {
    const R part = maximum(crack.over[a] - crack.lambda * crack.sum, R{}) / two_mu;
    strain[a] -= select(cracking, part, R{});
  }
  const R opened = select(cracking, crack.sum, R{});
  point.opening += opened;
  point.plastic_strain += m.opening_damage * opened;
  return cracking;
}

}  // namespace vulnus::injury
