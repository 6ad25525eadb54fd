// Damage: how much of the strength is gone, from the plastic strain that a point has seen.
#pragma once

#include "core/symmetric_eigen.hpp"
#include "injury/material.hpp"

namespace vulnus::injury {

// 0 up to damage_start, then linear up to 1 (linear softening; the slope is regularised by the
// fracture energy over the cell, see materials.py).
template <class R>
VULNUS_HD R softening_damage(const Material<R>& m, R plastic_strain) {
  const R d = (plastic_strain - m.damage_start) * m.damage_slope;
  return minimum(maximum(d, R{}), broadcast<R>(1));
}

}  // namespace vulnus::injury
