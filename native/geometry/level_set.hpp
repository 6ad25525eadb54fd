// Narrow-band signed distance on sparse 8x8x8 blocks, negative inside.
//
// Voxel (i, j, k) lies at (i, j, k) * voxel in the patient frame, so that every level set of one
// voxel size shares one grid and a moving surface does not flicker. Blocks hold phi in units of
// metres as float32, clamped to +-background; where no block is stored, phi is +background, or
// -background on tiles marked inside.
#pragma once

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

  // Drops blocks that lie wholly outside the band and turns those wholly inside into tiles.
  void prune();
};

// Blocks that a constructor met, before their values are known: sorted, with empty values.
LevelSet allocate(double voxel, float background, const BlockMap& met);

enum class Combination { kUnion, kIntersection, kDifference };

LevelSet combine(const LevelSet& a, const LevelSet& b, Combination how);

// One explicit step of mean curvature flow and one re-distance step (VISUALIZATION appendix).
void flow_step(LevelSet& level_set);

// `steps` Godunov steps towards |grad phi| = 1 with time step `courant` voxels.
void redistance(LevelSet& level_set, int steps, float courant);

}  // namespace vulnus::geometry
