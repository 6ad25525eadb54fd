// Eigenvalues and eigenvectors of a symmetric 3x3 matrix by cyclic Jacobi rotations, branch-free.
#pragma once

#include "core/lanes.hpp"

namespace vulnus {

// A symmetric matrix as xx, yy, zz, xy, yz, zx.
template <class R>
struct Symmetric3 {
  R xx, yy, zz, xy, yz, zx;
};

template <class R>
struct Matrix3 {
  R m[3][3];
};

template <class R>
struct Eigen3 {
  R value[3];
  Matrix3<R> vector;  // the columns are the eigenvectors
};

// Rotates the plane (p, q) so that the entry pq vanishes; r is the third index, v0..v2 the rows
// of the eigenvector matrix.
template <class R>
VULNUS_HD void rotate_plane(R& app, R& aqq, R& apq, R& arp, R& arq, Matrix3<R>& v, int p, int q) {
  const R one = broadcast<R>(1);
  const R half_difference = (aqq - app) * broadcast<R>(0.5);
  const R root = square_root(half_difference * half_difference + apq * apq);
  const R magnitude = select(half_difference < R{}, -half_difference, half_difference) + root;
  const auto none = magnitude <= R{};
  const R signed_apq = select(half_difference < R{}, -apq, apq);
  const R t = select(none, R{}, signed_apq / select(none, one, magnitude));
  const R c = one / square_root(one + t * t);
  const R s = t * c;
  app -= t * apq;
  aqq += t * apq;
  apq = R{};
  const R rp = c * arp - s * arq;
  arq = s * arp + c * arq;
  arp = rp;
  for (int i = 0; i < 3; ++i) {
    const R vp = c * v.m[i][p] - s * v.m[i][q];
    v.m[i][q] = s * v.m[i][p] + c * v.m[i][q];
    v.m[i][p] = vp;
  }
}

// The number of sweeps is fixed: 4 reach float rounding, 6 double rounding, for any 3x3 matrix
// (convergence is quadratic from the second sweep on).
template <class R>
VULNUS_HD Eigen3<R> symmetric_eigen(Symmetric3<R> a) {
  constexpr int kSweeps = sizeof(typename ScalarOf<R>::Type) == 4 ? 4 : 6;
  Eigen3<R> e;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e.vector.m[i][j] = broadcast<R>(i == j ? 1 : 0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    rotate_plane(a.xx, a.yy, a.xy, a.zx, a.yz, e.vector, 0, 1);
    rotate_plane(a.yy, a.zz, a.yz, a.xy, a.zx, e.vector, 1, 2);
    rotate_plane(a.xx, a.zz, a.zx, a.xy, a.yz, e.vector, 0, 2);
  }
  e.value[0] = a.xx;
  e.value[1] = a.yy;
  e.value[2] = a.zz;
  return e;
}

// V diag(d) V^T.
template <class R>
VULNUS_HD Symmetric3<R> from_principal(const Matrix3<R>& v, const R (&d)[3]) {
  auto entry = [&](int i, int j) {
    return v.m[i][0] * d[0] * v.m[j][0] + v.m[i][1] * d[1] * v.m[j][1] +
           v.m[i][2] * d[2] * v.m[j][2];
  };
  return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(0, 2)};
}

}  // namespace vulnus
