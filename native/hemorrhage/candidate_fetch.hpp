// Brings the values of listed particles side by side. Four values of a particle lie together in
// memory, so that one load fetches them and a 4 x 4 transposition sorts them into rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hemorrhage/neighbours.hpp"

namespace vulnus::hemorrhage {

template <class Real>
struct Quad;
template <>
struct Quad<float> {
  typedef float Lanes __attribute__((vector_size(16)));
  typedef std::int32_t Index __attribute__((vector_size(16)));
};
template <>
struct Quad<double> {
  typedef double Lanes __attribute__((vector_size(32)));
  typedef std::int64_t Index __attribute__((vector_size(32)));
};

// Rows a, b, c, d receive the four values of particles list[0..n) from `packed` (4 a particle).
template <class Real>
inline void fetch_quads(const Real* packed, const std::uint32_t* list, std::size_t n, Real* a,
                        Real* b, Real* c, Real* d) {
  using Lanes = typename Quad<Real>::Lanes;
  using Index = typename Quad<Real>::Index;
  const auto at = [packed](std::uint32_t candidate) {
    Lanes lanes;
    __builtin_memcpy(&lanes, packed + 4 * std::size_t(candidate & kIndexMask), sizeof(Lanes));
    return lanes;
  };
  std::size_t k = 0;
  for (; k + 4 <= n; k += 4) {
    const Lanes p = at(list[k]), q = at(list[k + 1]), r = at(list[k + 2]), s = at(list[k + 3]);
    const Lanes pq_low = __builtin_shuffle(p, q, Index{0, 4, 1, 5});
    const Lanes rs_low = __builtin_shuffle(r, s, Index{0, 4, 1, 5});
    const Lanes pq_high = __builtin_shuffle(p, q, Index{2, 6, 3, 7});
    const Lanes rs_high = __builtin_shuffle(r, s, Index{2, 6, 3, 7});
    const Lanes rows[4] = {__builtin_shuffle(pq_low, rs_low, Index{0, 1, 4, 5}),
                           __builtin_shuffle(pq_low, rs_low, Index{2, 3, 6, 7}),
                           __builtin_shuffle(pq_high, rs_high, Index{0, 1, 4, 5}),
                           __builtin_shuffle(pq_high, rs_high, Index{2, 3, 6, 7})};
    __builtin_memcpy(a + k, &rows[0], sizeof(Lanes));
    __builtin_memcpy(b + k, &rows[1], sizeof(Lanes));
    __builtin_memcpy(c + k, &rows[2], sizeof(Lanes));
    __builtin_memcpy(d + k, &rows[3], sizeof(Lanes));
  }
  for (; k < n; ++k) {
    const Lanes p = at(list[k]);
    a[k] = p[0], b[k] = p[1], c[k] = p[2], d[k] = p[3];
  }
}

template <class Real>
inline void fetch_single(const Real* values, const std::uint32_t* list, std::size_t n, Real* row) {
  for (std::size_t k = 0; k < n; ++k) row[k] = values[list[k] & kIndexMask];
}

// Moves candidates that stand for periodic images to where the image is; own images come first in
// every list.
template <class Real>
inline void shift_images(const Periodicity<Real>& periodicity, const std::uint32_t* list,
                         std::size_t n, Real* x, Real* y, Real* z) {
  for (std::size_t k = n; k > 0 && list[k - 1] >> kImageShift != kOwnImage; --k) {
    const std::array<Real, 3> shift = periodicity.shift(list[k - 1] >> kImageShift);
    x[k - 1] += shift[0], y[k - 1] += shift[1], z[k - 1] += shift[2];
  }
}

}  // namespace vulnus::hemorrhage
