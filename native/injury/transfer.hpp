// Transfers between the particles of one bundle of lanes and a tile of nodes: quadratic B-splines,
// affine velocities (APIC, Jiang et al. 2015) and the stress term of MLS-MPM (Hu et al. 2018). A
// row is four nodes in z with four components each: 16 values, of which the fourth node has weight
// 0.
#pragma once

#include <type_traits>

#include "injury/block_grid.hpp"
#include "injury/shape_function.hpp"

namespace vulnus::injury {

template <class T>
struct Stencil {
  using Real = typename LaneTraits<T>::Real;
  using IntegerScalar = typename LaneTraits<T>::IntegerScalar;
  static constexpr int kWidth = LaneTraits<T>::kWidth;

  Real fraction[3];                          // cells from the base node
  alignas(64) T weight[3][3][kWidth];        // axis, node, lane
  alignas(64) IntegerScalar offset[kWidth];  // of the base node's first value in the tile
  typename LaneTraits<T>::Integer outside;   // lanes whose stencil leaves the tile
};

// The stencil of positions given in cells from the tile's first node. Lanes outside are clamped so
// that nothing is written past the tile, and reported.
template <class T>
VULNUS_HD void place_stencil(const typename LaneTraits<T>::Real (&cell)[3], Stencil<T>& s) {
  using Real = typename LaneTraits<T>::Real;
  using Integer = typename LaneTraits<T>::Integer;
  Integer offset{};
  s.outside = Integer{};
  for (int a = 0; a < 3; ++a) {
    const Real shifted = cell[a] - T(0.5);
    const Integer inside = (shifted >= T(0)) & (shifted < T(6));
    s.outside |= ~inside;
    const Real safe = select(inside, shifted, Real{});
    const Integer base = truncated(safe);
    s.fraction[a] = safe + T(0.5) - real(base);
    Real weight[3];
    quadratic_weights(s.fraction[a], weight);
    for (int n = 0; n < 3; ++n) store_lanes(s.weight[a][n], weight[n]);
    offset = offset * kTileEdge + base;
  }
  offset *= kComponents;
  store_lanes(s.offset, offset);
}

template <class T>
VULNUS_HD typename LaneTraits<T>::Row node_pattern(T first, T second, T third) {
  typename LaneTraits<T>::Row r{};
  for (int c = 0; c < 4; ++c) {
    r[c] = first;
    r[4 + c] = second;
    r[8 + c] = third;
  }
  return r;
}

template <class T>
VULNUS_HD typename LaneTraits<T>::Row z_weights(const Stencil<T>& s, int lane) {
  return node_pattern<T>(1, 0, 0) * s.weight[2][0][lane] +
         node_pattern<T>(0, 1, 0) * s.weight[2][1][lane] +
         node_pattern<T>(0, 0, 1) * s.weight[2][2][lane];
}

// [sum over nodes of a | of b | of c | of d], each four components.
template <class Row>
VULNUS_HD Row sum_over_nodes(Row a, Row b, Row c, Row d) {
  const Row ab =
      __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
      __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  const Row cd =
      __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
      __builtin_shufflevector(c, d, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  return __builtin_shufflevector(ab, cd, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27) +
         __builtin_shufflevector(ab, cd, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30,
                                 31);
}
VULNUS_HD FloatHalf sum_over_nodes(LanePair<FloatHalf> a, LanePair<FloatHalf> b) {
  const FloatHalf x = a.half[0] + a.half[1], y = b.half[0] + b.half[1];
  return __builtin_shufflevector(x, y, 0, 1, 2, 3, 8, 9, 10, 11) +
         __builtin_shufflevector(x, y, 4, 5, 6, 7, 12, 13, 14, 15);
}
VULNUS_HD LanePair<FloatHalf> sum_over_nodes(LanePair<FloatHalf> a, LanePair<FloatHalf> b,
                                             LanePair<FloatHalf> c, LanePair<FloatHalf> d) {
  return {sum_over_nodes(a, b), sum_over_nodes(c, d)};
}

// [sum w g | sum w g i_x | sum w g i_y | sum w g i_z] of one lane over its 27 nodes, with node
// numbers i = 0, 1, 2 from the base node.
template <class T>
VULNUS_HD typename LaneTraits<T>::Row gather_moments(const T* tile, const Stencil<T>& s, int lane) {
  using Row = typename LaneTraits<T>::Row;
  const T* base = tile + s.offset[lane];
  const T wy0 = s.weight[1][0][lane], wy1 = s.weight[1][1][lane], wy2 = s.weight[1][2][lane];
  Row sum{}, sum_x{}, sum_y{};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const T* p = base + i * kTileEdge * kTileEdge * kComponents;
    const Row g0 = load_lanes<Row>(p);
    const Row g1 = load_lanes<Row>(p + kTileEdge * kComponents);
    const Row g2 = load_lanes<Row>(p + 2 * kTileEdge * kComponents);
    const Row second = wy1 * g1;
    const Row third = wy2 * g2;
    const T wx = s.weight[0][i][lane];
    const Row plane = wx * (wy0 * g0 + second + third);
    sum += plane;
    if (i == 1) sum_x += plane;
    if (i == 2) sum_x += plane + plane;
    sum_y += wx * (second + third + third);
  }
  const Row wz = z_weights(s, lane);
  const Row weighted = sum * wz;
  return sum_over_nodes(weighted, sum_x * wz, sum_y * wz, weighted * node_pattern<T>(0, 1, 2));
}

template <int Block, class Row>
VULNUS_HD Row repeat_block(Row r) {
  if constexpr (std::is_same_v<Row, LanePair<FloatHalf>>) {
    constexpr int b = 4 * (Block % 2);
    const FloatHalf h = r.half[Block / 2];
    const FloatHalf twice =
        __builtin_shufflevector(h, h, b, b + 1, b + 2, b + 3, b, b + 1, b + 2, b + 3);
    return {twice, twice};
  } else {
    constexpr int b = 4 * Block;
    return __builtin_shufflevector(r, r, b, b + 1, b + 2, b + 3, b, b + 1, b + 2, b + 3, b, b + 1,
                                   b + 2, b + 3, b, b + 1, b + 2, b + 3);
  }
}

// Adds w (q + i_x a_x + i_y a_y + i_z a_z) to the 27 nodes; `affine` = [q | a_x | a_y | a_z].
template <class T>
VULNUS_HD void scatter_affine(T* tile, const Stencil<T>& s, int lane,
                              typename LaneTraits<T>::Row affine) {
  using Row = typename LaneTraits<T>::Row;
  const Row wz = z_weights(s, lane);
  Row q = (repeat_block<0>(affine) + node_pattern<T>(0, 1, 2) * repeat_block<3>(affine)) * wz;
  const Row ax = repeat_block<1>(affine) * wz;
  const Row ay = repeat_block<2>(affine) * wz;
  T* base = tile + s.offset[lane];
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const T wx = s.weight[0][i][lane];
    const Row step = wx * ay;
    Row value = wx * q;
    T* p = base + i * kTileEdge * kTileEdge * kComponents;
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      store_lanes(p, load_lanes<Row>(p) + s.weight[1][j][lane] * value);
      value += step;
      p += kTileEdge * kComponents;
    }
    q += ax;
  }
}

}  // namespace vulnus::injury
