// Damage: how much of the strength is gone, from the plastic strain that a point has seen.
#pragma once

#include "injury/material.hpp"

namespace vulnus::injury {

// 0 up to damage_start, 1 from damage_end on, linear between (linear softening; the span is
// regularised by the fracture energy over the cell, see materials.py).
template <class R>
VULNUS_HD R damage_of(const Material<R>& m, R plastic_strain) {
  const R d = (plastic_strain - m.damage_start) / (m.damage_end - m.damage_start);
  return minimum(maximum(d, R{}), broadcast<R>(1));
}

}  // namespace vulnus::injury
