// Against volumetric locking: what is nearly incompressible strains with the mean volume rate of
// its cell (B-bar, Hughes 1980). The points of one cell, as sorted when the epoch began, share
// their 27 nodes; there they are given one volume rate instead of eight that the nodes could not
// all meet. Points of one cell thus keep equal pressures, and where p is equal in a group the power
// of the stress, sum V p tr(C), is the power that the strain takes up, sum V p mean(tr C): the
// averaging is a symmetric operator in the volume-weighted product, so that energy is kept.
#pragma once

#include <cstdint>

#include "injury/block_grid.hpp"

namespace vulnus::injury {

// Replaces the volume rates [1/s] of a block's points by what is to be added to each diagonal entry
// of their velocity gradient. `cell_end` holds, for each of the block's cells, the place behind its
// last point; `weight` the volume of the points that take part, 0 of the others; all places count
// from `begin`, and those from the last cell's end to `end` have no point.
template <class T>
void average_volume_rate(const std::int32_t* cell_end, std::int32_t begin, std::int32_t end,
                         const T* weight, T* rate) {
  std::int32_t p = begin;
  for (int c = 0; c < kBlockNodes; ++c) {
    T volume = 0, change = 0;
    for (std::int32_t q = p; q < cell_end[c]; ++q) {
      volume += weight[q - begin];
      change += weight[q - begin] * rate[q - begin];
    }
    const T mean = volume > T(0) ? change / volume : T(0);
    for (; p < cell_end[c]; ++p)
      rate[p - begin] = weight[p - begin] > T(0) ? (mean - rate[p - begin]) * T(1.0 / 3.0) : T(0);
  }
  for (; p < end; ++p) rate[p - begin] = T(0);
}

}  // namespace vulnus::injury
