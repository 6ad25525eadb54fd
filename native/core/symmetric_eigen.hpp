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

// Entries below its root are zero. Chosen: far below any strain, and a normal number as a float.
constexpr double kSmallestSquare = 1e-36;

// Rotates the plane (p, q) so that the entry pq vanishes; r is the third index, v0..v2 the rows
// of the eigenvector matrix.
template <class R>
VULNUS_HD void rotate_plane(R& app, R& aqq, R& apq, R& arp, R& arq, Matrix3<R>& v, int p, int q) {
  const R one = broadcast<R>(1), half = broadcast<R>(0.5);
  const R half_difference = (aqq - app) * half;
  const R squared = half_difference * half_difference + apq * apq;
  const auto diagonal = squared < broadcast<R>(kSmallestSquare);
  const R inverse = reciprocal_square_root(select(diagonal, one, squared));
  const R cosine_squared = select(diagonal, one, half + half * absolute(half_difference) * inverse);
  const R secant = reciprocal_square_root(cosine_squared);
  const R c = cosine_squared * secant;
  const R s =
      select(diagonal, R{}, half * select(half_difference < R{}, -apq, apq) * inverse * secant);
  const R t = s * secant;
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

// Whether the entries off the diagonal are rounding errors of those on it, in all lanes.
template <class R>
VULNUS_HD bool is_diagonal(const Symmetric3<R>& a) {
  constexpr double rounding = sizeof(typename ScalarOf<R>::Type) == 4 ? 1e-7 : 2e-16;
  const R off = maximum(maximum(absolute(a.xy), absolute(a.yz)), absolute(a.zx));
  const R on = maximum(maximum(absolute(a.xx), absolute(a.yy)), absolute(a.zz));
  return !any(off > broadcast<R>(rounding) * on);
}

// 4 sweeps reach float rounding, 6 double rounding, for any 3x3 matrix (convergence is quadratic
// from the second sweep on); most are there after 3.
template <class R>
VULNUS_HD Eigen3<R> symmetric_eigen(Symmetric3<R> a) {
  constexpr int kSweeps = sizeof(typename ScalarOf<R>::Type) == 4 ? 4 : 6;
  Eigen3<R> e;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) e.vector.m[i][j] = broadcast<R>(i == j ? 1 : 0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    if (sweep >= 2 && is_diagonal(a)) break;
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
