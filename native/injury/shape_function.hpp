// Quadratic B-spline shape functions of one axis (Jiang et al. 2016, MPM course, eq. 123).
#pragma once

#include "core/lanes.hpp"

namespace vulnus::injury {

// Weights of the nodes base, base + 1, base + 2 for a particle at `fraction` cells from base, 0.5
// <= fraction < 1.5. They are positive and sum to one.
template <class R>
VULNUS_HD void quadratic_weights(R fraction, R (&weight)[3]) {
  const R half = broadcast<R>(0.5);
  const R a = broadcast<R>(1.5) - fraction;
  const R b = fraction - broadcast<R>(1);
  const R c = fraction - half;
  weight[0] = half * a * a;
  weight[1] = broadcast<R>(0.75) - b * b;
  weight[2] = half * c * c;
}

}  // namespace vulnus::injury
