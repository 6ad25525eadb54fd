// Poisson-disk points inside a level set (Bridson 2007), on a sparse background grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/level_set.hpp"

namespace vulnus::geometry {

// SplitMix64 (Steele, Lea & Flood 2014): one 64-bit state, the same numbers on every machine.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  // Three numbers in [0, 1) of 21 bits each.
  std::array<float, 3> triple() {
    constexpr float scale = 1.0f / (1 << 21);
    const std::uint64_t b = bits();
    return {static_cast<float>(b & 0x1FFFFF) * scale,
            static_cast<float>(b >> 21 & 0x1FFFFF) * scale,
            static_cast<float>(b >> 42 & 0x1FFFFF) * scale};
  }

 private:
  std::uint64_t state_;
};

// Points around a place, relative to it, in vectors of eight; padded by points far away.
struct Neighbourhood {
  static constexpr int kLargest = 160;  // closest packing within 2.05 spacings holds fewer than 105
  alignas(64) float x[kLargest], y[kLargest], z[kLargest];
  int count = 0;

  void clear();
  void add(float px, float py, float pz);
  bool conflicts(float px, float py, float pz, float square) const;
};

// Grows one set of points. The level set must outlive the sampler.
class PoissonDiskSampler {
 public:
  PoissonDiskSampler(const LevelSet& domain, double spacing, std::uint64_t seed, const Point& low,
                     const Point& high);

  // Works on `parents` more points; false when the set is complete.
  bool advance(std::int64_t parents);

  // 3 a point [m]; no two are nearer than the spacing, exactly, as float32 numbers.
  const std::vector<float>& points() const { return points_; }
  std::int64_t count() const { return static_cast<std::int64_t>(points_.size() / 3); }

 private:
  static constexpr int kCellCapacity = 8;  // points a spacing apart in a cube of that edge
  struct CellBlock {
    std::array<std::uint8_t, kBlock> count{};
    std::array<std::array<std::int32_t, kCellCapacity>, kBlock> point;
  };
  using Position = std::array<float, 3>;

  std::int32_t& block_place(std::int64_t x, std::int64_t y, std::int64_t z) {
    return table_[static_cast<std::size_t>(((x >> 3) * blocks_[1] + (y >> 3)) * blocks_[2] +
                                           (z >> 3))];
  }
  std::int64_t cell_of(float coordinate, std::size_t axis) const;
  bool in_box(const Position& point) const;
  void gather(const Position& centre, double reach, Neighbourhood& around);
  bool accept(const Position& point, const Position& centre, Neighbourhood& around);
  void grow_from(std::int32_t parent);
  bool seed_next_block();

  const LevelSet& domain_;
  double spacing_, cell_size_;
  float square_;  // of the smallest distance, with a margin for rounding
  std::array<double, 3> low_, high_;
  std::array<std::int64_t, 3> blocks_;
  RandomNumbers random_;
  std::vector<std::int32_t> table_;  // block of cells -> place in `cells_`, or -1
  std::vector<CellBlock> cells_;
  std::vector<std::int32_t> active_;
  std::vector<float> points_;
  std::int64_t next_block_ = 0;
};

}  // namespace vulnus::geometry
