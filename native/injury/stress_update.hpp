// The stress of a material point: the elasto-plastic part, the pressure and the network.
#pragma once

#include "injury/plasticity.hpp"

namespace vulnus::injury {

template <class R>
VULNUS_HD Symmetric3<R> add(const Symmetric3<R>& a, const Symmetric3<R>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.yz + b.yz, a.zx + b.zx};
}

template <class Mask, class R>
VULNUS_HD Symmetric3<R> choose(Mask mask, const Symmetric3<R>& a, const Symmetric3<R>& b) {
  return {select(mask, a.xx, b.xx), select(mask, a.yy, b.yy), select(mask, a.zz, b.zz),
          select(mask, a.xy, b.xy), select(mask, a.yz, b.yz), select(mask, a.zx, b.zx)};
}

// Principal Hencky strains of b_e - I; not a number where rounding or inversion left no b_e.
template <class R>
VULNUS_HD void principal_hencky(const Eigen3<R>& e, R (&hencky)[3]) {
  for (int a = 0; a < 3; ++a) {
    const R strain = broadcast<R>(0.5) * log_one_plus(e.value[a]);
    hencky[a] = select(e.value[a] > broadcast<R>(-1), strain, broadcast<R>(NAN));
  }
}

// rho c^2 of the fastest wave [Pa]; `modulus` is the network's.
template <class R>
VULNUS_HD R point_stiffness(const Material<R>& m, R trace, R excess, R modulus) {
  return m.bulk_modulus * volumetric_stiffening(m, trace) +
         broadcast<R>(4.0 / 3.0) * m.shear_modulus + network_stiffness(m, excess, modulus);
}

// Kirchhoff stress of a point that has not moved since its last return.
template <class R>
VULNUS_HD Symmetric3<R> resting_kirchhoff(const Material<R>& m, const PointState<R>& point) {
  const Eigen3<R> e = symmetric_eigen(point.strain);
  R hencky[3], stress[3];
  principal_hencky(e, hencky);
  hencky_kirchhoff(m, hencky, stress);
  const R log_jacobian = hencky[0] + hencky[1] + hencky[2] + point.opening;
  const NetworkStretch<R> stretch = network_stretch(point.network, log_jacobian);
  const R modulus = network_modulus(m, stretch.excess) * (broadcast<R>(1) - point.damage);
  return add(from_principal(e.vector, stress),
             network_kirchhoff(point.network, stretch.scale, modulus));
}

// Returns the trial state of a step to all limits and gives its stress. Damage never heals, and a
// point without network, or whose network is gone, forgets its total strain.
template <class R>
VULNUS_HD StressUpdate<R> update_stress(const Material<R>& m, R rate, PointState<R>& point) {
  const Eigen3<R> e = symmetric_eigen(point.strain);
  R hencky[3], stress[3];
  principal_hencky(e, hencky);
  const R opening = point.opening;
  const R log_jacobian = hencky[0] + hencky[1] + hencky[2] + opening;
  const NetworkStretch<R> stretch = network_stretch(point.network, log_jacobian);
  point.damage = maximum(point.damage, network_damage(m, stretch.excess));

  close_opening(hencky, point.opening);
  auto changed = return_to_shear_yield(m, rate, hencky, point);
  changed |= return_to_pressure_cutoff(m, hencky, point);
  changed |= return_to_rankine(m, hencky, point);
  changed |= opening > R{};
  point.damage = point.worst_damage(m);
  if (any(changed)) {
    R rebuilt[3];
    for (int a = 0; a < 3; ++a) rebuilt[a] = exp_minus_one(broadcast<R>(2) * hencky[a]);
    point.strain = choose(changed, from_principal(e.vector, rebuilt), point.strain);
  }

  hencky_kirchhoff(m, hencky, stress);
  const R sound = broadcast<R>(1) - point.damage;
  const R modulus = network_modulus(m, stretch.excess) * sound;
  const Symmetric3<R> network = network_kirchhoff(point.network, stretch.scale, modulus);
  const auto connected = (m.network_modulus > R{}) & (sound > R{});
  point.network = choose(connected, point.network, Symmetric3<R>{});
  const R trace = hencky[0] + hencky[1] + hencky[2];
  const R stiffness = point_stiffness(m, trace, stretch.excess, modulus);
  return {add(from_principal(e.vector, stress), network), stiffness / m.density};
}

}  // namespace vulnus::injury
