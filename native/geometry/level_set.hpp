// Narrow-band signed distance on sparse 8x8x8 blocks, negative inside.
//
// Voxel (i, j, k) lies at (i, j, k) * voxel in the patient frame, so that every level set of one
// voxel size shares one grid and a moving surface does not flicker. Blocks hold phi in units of
// metres as float32, clamped to +-background; where no block is stored, phi is +background, or
// -background on tiles marked inside.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/block_map.hpp"

namespace vulnus::geometry {

struct Point {
  double x, y, z;
};

struct LevelSet {
  double voxel = 1.0;
  float background = 3.0f;
  std::vector<BlockCoordinate> blocks;  // ascending
  std::vector<float> values;            // 512 a block, z fastest
  std::vector<float> weights;           // of the curvature flow, as `values`; empty: all 1
  BlockMap map;                         // index of a block, or kInside

  const float* block(std::int64_t index) const { return values.data() + index * kBlock; }
  float* block(std::int64_t index) { return values.data() + index * kBlock; }
  std::int64_t block_count() const { return static_cast<std::int64_t>(blocks.size()); }
  std::size_t memory_bytes() const;

  float value(std::int32_t i, std::int32_t j, std::int32_t k) const;
  float tile_value(std::int32_t mark) const { return mark == kInside ? -background : background; }

  // Trilinear phi at a point [m], and its gradient.
  float sample(const Point& point) const;
  Point gradient(const Point& point) const;

  double volume() const;

  // Drops blocks that lie wholly outside the band and turns those wholly inside into tiles, but
  // for those that touch the outside.
  void prune();
};

// Blocks that a constructor met, before their values are known: sorted, with empty values.
LevelSet allocate(double voxel, float background, const BlockMap& met);

enum class Combination { kUnion, kIntersection, kDifference };

LevelSet combine(const LevelSet& a, const LevelSet& b, Combination how);

// `set`, but nowhere more than `limit` away from `reference`.
LevelSet limited(const LevelSet& set, const LevelSet& reference, float limit);

// Moves a level set over its fixed blocks; keeps the table of neighbours and the second array of
// values between steps. The level set must outlive the flow.
class BandFlow {
 public:
  explicit BandFlow(LevelSet& set);

  // One explicit step of mean curvature flow and one re-distance step (VISUALIZATION appendix).
  void curvature_step();

  // One Godunov step towards |grad phi| = 1 with a time step of `courant` voxels.
  void redistance_step(float courant);

 private:
  template <typename Law>
  void update(Law&& law);

  LevelSet& set_;
  std::vector<std::array<std::int32_t, 27>> neighbours_;
  std::vector<float> next_;
};

}  // namespace vulnus::geometry
