// Against volumetric locking: what is nearly incompressible strains with the mean volume rate of
// its cell (B-bar, Hughes 1980). The points of one cell, as sorted when the epoch began, share
// their 27 nodes; there they are given one volume rate instead of eight that the nodes could not
// all meet. Points of one cell thus keep equal pressures, and where p is equal in a group the power
// of the stress, sum V p tr(C), is the power that the strain takes up, sum V p mean(tr C): the
// averaging is a symmetric operator in the volume-weighted product, so that energy is kept. Where
// two materials meet in a cell each has its own group: with one volume rate the stiffer would get
// the larger part of the pressure, and p would not be equal in the group.
#pragma once

#include <cstdint>
#include <cstring>

#include "injury/block_grid.hpp"
#include "injury/material.hpp"

namespace vulnus::injury {

// Sums of one group: the volume of its points, and their volume rates times their volumes.
template <class T>
struct VolumeRate {
  T volume = 0, change = 0;

  void add(T weight, T rate) {
    volume += weight;
    change += weight * rate;
  }
  T mean() const { return volume > T(0) ? change / volume : T(0); }
};

// What is to be added to each diagonal entry of a point's velocity gradient.
template <class T>
T rate_correction(T mean, T weight, T rate) {
  return weight > T(0) ? (mean - rate) * T(1.0 / 3.0) : T(0);
}

inline bool is_uniform(const std::uint8_t* material, std::int32_t count) {
  return count < 2 || std::memcmp(material, material + 1, count - 1) == 0;
}

// The points of one cell, `count` of them.
template <class T>
void average_cell(std::int32_t count, const std::uint8_t* material, const T* weight, T* rate) {
  VolumeRate<T> all;
  for (std::int32_t q = 0; q < count; ++q) all.add(weight[q], rate[q]);
  if (is_uniform(material, count)) {
    const T mean = all.mean();
    for (std::int32_t q = 0; q < count; ++q) rate[q] = rate_correction(mean, weight[q], rate[q]);
    return;
  }
  VolumeRate<T> group[kMaterialCapacity];
  for (std::int32_t q = 0; q < count; ++q) group[material[q]].add(weight[q], rate[q]);
  for (std::int32_t q = 0; q < count; ++q)
    rate[q] = rate_correction(group[material[q]].mean(), weight[q], rate[q]);
}

// Replaces the volume rates [1/s] of a block's points by what is to be added to each diagonal entry
// of their velocity gradient. `cell_end` holds, for each of the block's cells, the place behind its
// last point; `weight` the volume of the points that take part, 0 of the others; all places count
// from `begin`, and those from the last cell's end to `end` have no point.
template <class T>
void average_volume_rate(const std::int32_t* cell_end, std::int32_t begin, std::int32_t end,
                         const std::uint8_t* material, const T* weight, T* rate) {
  std::int32_t p = 0;
  for (int c = 0; c < kBlockNodes; ++c) {
    const std::int32_t last = cell_end[c] - begin;
    average_cell(last - p, material + p, weight + p, rate + p);
    p = last;
  }
  for (; p < end - begin; ++p) rate[p] = T(0);
}

}  // namespace vulnus::injury
