// The network: fibres and chains that remember the whole deformation, in parallel with the
// elasto-plastic part. Isotropic and incompressible in its law,
//   W = mu/(2 beta) (exp(beta (I - 3)) - 1)   (Demiray 1972, J Biomech; beta = 0: neo-Hookean),
// with I = tr(J^(-2/3) b) of the total left Cauchy-Green tensor b. Its stress is (PHYSICS 1.4)
//   tau = mu exp(beta (I - 3)) dev(J^(-2/3) b).
// With the equivalent strain e = sqrt((I - 3)/3) (the strain itself where it is small) the work is
// dW = 3 mu_I e de in any state of stress. Beyond the strain e_0 of failure the network stiffens no
// more and 3 mu_0 e (1 - D) falls on a straight line to zero at e_1, so that W_0 plus the triangle
// 3 mu_0 e_0 (e_1 - e_0) / 2 is what a volume spends: the fracture energy over the cell
// (materials.py).
#pragma once

#include "injury/damage.hpp"
#include "injury/equation_of_state.hpp"

namespace vulnus::injury {

template <class R>
struct NetworkStretch {
  R scale;   // J^(-2/3)
  R excess;  // I - 3
};

// Of strain = b - I and ln J.
template <class R>
VULNUS_HD NetworkStretch<R> network_stretch(const Symmetric3<R>& strain, R log_jacobian) {
  const R less = exp_minus_one(log_jacobian * broadcast<R>(-2.0 / 3.0));  // scale - 1
  const R scale = less + broadcast<R>(1);
  const R trace = strain.xx + strain.yy + strain.zz;
  return {scale, maximum(scale * trace + broadcast<R>(3) * less, R{})};
}

// mu exp(beta (I - 3)), which grows no more once the network breaks.
template <class R>
VULNUS_HD R network_modulus(const Material<R>& m, R excess) {
  const R limit = broadcast<R>(3) * m.break_start * m.break_start;
  const R exponent = m.network_stiffening * minimum(excess, limit);
  if (!any(exponent > R{})) return m.network_modulus;
  return m.network_modulus * (exp_minus_one(exponent) + broadcast<R>(1));
}

// W [J/m^3, undeformed] of the sound network; straight in I beyond failure.
template <class R>
VULNUS_HD R network_energy(const Material<R>& m, R excess) {
  const R limit = broadcast<R>(3) * m.break_start * m.break_start;
  const R curved = minimum(excess, limit);
  const R energy = exponential_growth(m.network_stiffening, curved) * m.network_modulus;
  return broadcast<R>(0.5) * (energy + network_modulus(m, excess) * (excess - curved));
}

// 1 - D = (e_0 / e) (1 - (e - e_0) / (e_1 - e_0)): the stress 3 mu e (1 - D) is linear in e.
template <class R>
VULNUS_HD R network_damage(const Material<R>& m, R excess) {
  const R one = broadcast<R>(1);
  const R e = square_root(excess * broadcast<R>(1.0 / 3.0));
  const auto breaking = e > m.break_start;
  if (!any(breaking)) return R{};
  const R line = maximum(one - (e - m.break_start) * m.break_slope, R{});
  return select(breaking, one - line * m.break_start / select(breaking, e, one), R{});
}

template <class R>
VULNUS_HD Symmetric3<R> network_kirchhoff(const Symmetric3<R>& strain, R scale, R modulus) {
  const R mean = (strain.xx + strain.yy + strain.zz) * broadcast<R>(1.0 / 3.0);
  const R k = modulus * scale;
  return {k * (strain.xx - mean), k * (strain.yy - mean), k * (strain.zz - mean),
          k * strain.xy,          k * strain.yz,          k * strain.zx};
}

// What the network adds to rho c^2 of the fastest wave [Pa]: 4/3 mu at rest, mu times the square
// of the largest stretch when stretched, and the exponential's own slope 2 beta mu dev(b)^2, whose
// entries are below sqrt(4/3 (I - 3) (1 + I - 3)).
template <class R>
VULNUS_HD R network_stiffness(const Material<R>& m, R excess, R modulus) {
  const R rise = m.network_stiffening * broadcast<R>(8.0 / 3.0) * (broadcast<R>(1) + excess);
  return modulus * (broadcast<R>(4.0 / 3.0) + excess * (broadcast<R>(1) + rise));
}

}  // namespace vulnus::injury
