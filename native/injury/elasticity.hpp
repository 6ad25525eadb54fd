// Hencky elasticity on the elastic left Cauchy-Green tensor, kept as its distance from identity
// so that small strains survive in single precision.
#pragma once

#include "core/symmetric_eigen.hpp"
#include "injury/equation_of_state.hpp"

namespace vulnus::injury {

// b <- F b F^T with F = I + L, for strain = b - I.
template <class R>
VULNUS_HD Symmetric3<R> advance_strain(const Symmetric3<R>& s, const Matrix3<R>& increment) {
  const auto& l = increment.m;
  const R e[3][3] = {{s.xx, s.xy, s.zx}, {s.xy, s.yy, s.yz}, {s.zx, s.yz, s.zz}};
  R h[3][3];  // (I + L) e + L
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      h[i][j] = e[i][j] + (l[i][0] * e[0][j] + l[i][1] * e[1][j] + l[i][2] * e[2][j]) + l[i][j];
  auto entry = [&](int i, int j) {  // h + h L^T + L^T, which is symmetric
    return h[i][j] + (h[i][0] * l[j][0] + h[i][1] * l[j][1] + h[i][2] * l[j][2]) + l[j][i];
  };
  return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(0, 2)};
}

template <class R>
VULNUS_HD R determinant_of_step(const Matrix3<R>& increment) {
  const auto& l = increment.m;
  const R one = broadcast<R>(1);
  const R a = one + l[0][0], e = one + l[1][1], i = one + l[2][2];
  return a * (e * i - l[1][2] * l[2][1]) - l[0][1] * (l[1][0] * i - l[1][2] * l[2][0]) +
         l[0][2] * (l[1][0] * l[2][1] - e * l[2][0]);
}

// sqrt(2/3) |dev sym C|: the equivalent strain rate [1/s] of a velocity gradient C.
template <class R>
VULNUS_HD R equivalent_strain_rate(const Matrix3<R>& c) {
  const R mean = (c.m[0][0] + c.m[1][1] + c.m[2][2]) * broadcast<R>(1.0 / 3.0);
  const R x = c.m[0][0] - mean, y = c.m[1][1] - mean, z = c.m[2][2] - mean;
  const R xy = c.m[0][1] + c.m[1][0], yz = c.m[1][2] + c.m[2][1], zx = c.m[0][2] + c.m[2][0];
  const R norm = x * x + y * y + z * z + broadcast<R>(0.5) * (xy * xy + yz * yz + zx * zx);
  return square_root(broadcast<R>(2.0 / 3.0) * norm);
}

// Principal Kirchhoff stress 2 mu dev(eps) - J p of the principal Hencky strain.
template <class R>
VULNUS_HD void hencky_kirchhoff(const Material<R>& m, const R (&strain)[3], R (&stress)[3]) {
  const R trace = strain[0] + strain[1] + strain[2];
  const R mean = trace * broadcast<R>(1.0 / 3.0);
  const R volumetric = volumetric_kirchhoff(m, trace);
  for (int a = 0; a < 3; ++a)
    stress[a] = broadcast<R>(2) * m.shear_modulus * (strain[a] - mean) + volumetric;
}

// Stored energy mu |dev eps|^2 and that of the volume [J/m^3, undeformed].
template <class R>
VULNUS_HD R hencky_energy(const Material<R>& m, const R (&strain)[3]) {
  const R trace = strain[0] + strain[1] + strain[2];
  const R mean = trace * broadcast<R>(1.0 / 3.0);
  R shear{};
  for (int a = 0; a < 3; ++a) shear += (strain[a] - mean) * (strain[a] - mean);
  return m.shear_modulus * shear + volumetric_energy(m, trace);
}

}  // namespace vulnus::injury
