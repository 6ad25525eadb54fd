// Points sorted by cubic cells, only occupied cells stored: memory grows with the points, not with
// the box around them. A box query visits rows of cells, each one stretch of the sorted points.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vulnus::hemorrhage {

template <class Real>
struct Box {
  std::array<Real, 3> lower, upper;
};

// Cell coordinates of points relative to their own lowest corner, as one 64-bit key, x fastest.
template <class Real>
class CellOrder {
 public:
  void frame(const Real* x, const Real* y, const Real* z, std::size_t n, Real edge) {
    const std::array<const Real*, 3> axes{x, y, z};
    inverse_edge_ = Real(1) / edge;
    for (int a = 0; a < 3; ++a) {
      Real low = n ? axes[a][0] : Real(0), high = low;
      for (std::size_t i = 1; i < n; ++i) {
        low = std::min(low, axes[a][i]);
        high = std::max(high, axes[a][i]);
      }
      origin_[a] = low;
      count_[a] = static_cast<std::int64_t>(std::floor((high - low) * inverse_edge_)) + 1;
    }
  }

  std::uint64_t key(Real x, Real y, Real z) const {
    return join(cell(x, 0), cell(y, 1), cell(z, 2));
  }

  // Largest key possible; tells the sort how many bits matter.
  std::uint64_t key_limit() const { return join(count_[0] - 1, count_[1] - 1, count_[2] - 1); }

  // Takes over keys in ascending order and keeps where each occupied cell starts.
  void index(const std::vector<std::uint64_t>& sorted_keys) {
    keys_.clear();
    starts_.clear();
    for (std::size_t i = 0; i < sorted_keys.size(); ++i) {
      if (keys_.empty() || sorted_keys[i] != keys_.back()) {
        keys_.push_back(sorted_keys[i]);
        starts_.push_back(static_cast<std::int32_t>(i));
      }
    }
    starts_.push_back(static_cast<std::int32_t>(sorted_keys.size()));
  }

  std::size_t cell_count() const { return keys_.size(); }
  std::int32_t cell_start(std::size_t c) const { return starts_[c]; }

  // Calls visit(first, last) for each stretch of points whose cells overlap the box.
  template <class Visit>
  void visit_rows(const Box<Real>& box, Visit&& visit) const {
    if (keys_.empty()) return;
    std::array<std::int64_t, 3> low, high;
    for (int a = 0; a < 3; ++a) {
      low[a] = std::max<std::int64_t>(cell(box.lower[a], a), 0);
      high[a] = std::min<std::int64_t>(cell(box.upper[a], a), count_[a] - 1);
      if (low[a] > high[a]) return;
    }
    for (std::int64_t k = low[2]; k <= high[2]; ++k) {
      for (std::int64_t j = low[1]; j <= high[1]; ++j) {
        const auto first = std::lower_bound(keys_.begin(), keys_.end(), join(low[0], j, k));
        const auto last = std::upper_bound(first, keys_.end(), join(high[0], j, k));
        if (first == last) continue;
        visit(starts_[first - keys_.begin()], starts_[last - keys_.begin()]);
      }
    }
  }

  std::size_t memory_bytes() const {
    return keys_.capacity() * sizeof(std::uint64_t) + starts_.capacity() * sizeof(std::int32_t);
  }

 private:
  std::int64_t cell(Real value, int axis) const {
    return static_cast<std::int64_t>(std::floor((value - origin_[axis]) * inverse_edge_));
  }
  std::uint64_t join(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::uint64_t>((k * count_[1] + j) * count_[0] + i);
  }

  std::array<Real, 3> origin_{};
  std::array<std::int64_t, 3> count_{1, 1, 1};
  Real inverse_edge_ = 1;
  std::vector<std::uint64_t> keys_;
  std::vector<std::int32_t> starts_;
};

// Stable order of 64-bit keys by a least-significant-digit radix sort; `order` receives indices.
inline void radix_order(std::vector<std::uint64_t>& keys, std::vector<std::int32_t>& order,
                        std::uint64_t limit) {
  constexpr int kBits = 11;
  constexpr std::size_t kBuckets = std::size_t(1) << kBits;
  const std::size_t n = keys.size();
  std::vector<std::uint64_t> other_keys(n);
  std::vector<std::int32_t> other_order(n);
  order.resize(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::int32_t>(i);
  for (int shift = 0; shift < 64 && (limit >> shift) != 0; shift += kBits) {
    std::array<std::size_t, kBuckets + 1> start{};
    for (std::uint64_t key : keys) ++start[((key >> shift) & (kBuckets - 1)) + 1];
    for (std::size_t b = 0; b < kBuckets; ++b) start[b + 1] += start[b];
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t slot = start[(keys[i] >> shift) & (kBuckets - 1)]++;
      other_keys[slot] = keys[i];
      other_order[slot] = order[i];
    }
    keys.swap(other_keys);
    order.swap(other_order);
  }
}

}  // namespace vulnus::hemorrhage
