#include "geometry/level_set.hpp"

#include <algorithm>
#include <cmath>

namespace vulnus::geometry {

namespace {

struct Cell {
  std::int32_t i, j, k;
  float corner[2][2][2];
  float u, v, w;
};

void gather_corners(const LevelSet& set, Cell& cell) {
  const int x = within_block(cell.i), y = within_block(cell.j), z = within_block(cell.k);
  if (x < kSide - 1 && y < kSide - 1 && z < kSide - 1) {
    const std::int32_t index = set.map.find({block_of(cell.i), block_of(cell.j), block_of(cell.k)});
    const float* values = index >= 0 ? set.block(index) : nullptr;
    for (int c = 0; c < 8; ++c) {
      const int a = c >> 2, b = (c >> 1) & 1, d = c & 1;
      cell.corner[a][b][d] =
          values ? values[voxel_offset(x + a, y + b, z + d)] : set.tile_value(index);
    }
    return;
  }
  for (int c = 0; c < 8; ++c) {
    const int a = c >> 2, b = (c >> 1) & 1, d = c & 1;
    cell.corner[a][b][d] = set.value(cell.i + a, cell.j + b, cell.k + d);
  }
}

Cell cell_at(const LevelSet& set, const Point& point) {
  const double x = point.x / set.voxel, y = point.y / set.voxel, z = point.z / set.voxel;
  Cell cell;
  cell.i = static_cast<std::int32_t>(std::floor(x));
  cell.j = static_cast<std::int32_t>(std::floor(y));
  cell.k = static_cast<std::int32_t>(std::floor(z));
  cell.u = static_cast<float>(x - cell.i);
  cell.v = static_cast<float>(y - cell.j);
  cell.w = static_cast<float>(z - cell.k);
  gather_corners(set, cell);
  return cell;
}

float mix(float a, float b, float t) { return a + t * (b - a); }

}  // namespace

std::size_t LevelSet::memory_bytes() const {
  return values.size() * sizeof(float) + weights.size() * sizeof(float) +
         blocks.size() * sizeof(BlockCoordinate) + map.memory_bytes();
}

float LevelSet::value(std::int32_t i, std::int32_t j, std::int32_t k) const {
  const std::int32_t index = map.find({block_of(i), block_of(j), block_of(k)});
  if (index < 0) return tile_value(index);
  return block(index)[voxel_offset(within_block(i), within_block(j), within_block(k))];
}

float LevelSet::sample(const Point& point) const {
  const Cell c = cell_at(*this, point);
  const float a = mix(mix(c.corner[0][0][0], c.corner[0][0][1], c.w),
                      mix(c.corner[0][1][0], c.corner[0][1][1], c.w), c.v);
  const float b = mix(mix(c.corner[1][0][0], c.corner[1][0][1], c.w),
                      mix(c.corner[1][1][0], c.corner[1][1][1], c.w), c.v);
  return mix(a, b, c.u);
}

Point LevelSet::gradient(const Point& point) const {
  const Cell c = cell_at(*this, point);
  float slope_x[2][2], slope_y[2][2], slope_z[2][2];
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      slope_x[a][b] = c.corner[1][a][b] - c.corner[0][a][b];
      slope_y[a][b] = c.corner[a][1][b] - c.corner[a][0][b];
      slope_z[a][b] = c.corner[a][b][1] - c.corner[a][b][0];
    }
  }
  auto bilinear = [](const float s[2][2], float p, float q) {
    return mix(mix(s[0][0], s[0][1], q), mix(s[1][0], s[1][1], q), p);
  };
  return {bilinear(slope_x, c.v, c.w) / voxel, bilinear(slope_y, c.u, c.w) / voxel,
          bilinear(slope_z, c.u, c.v) / voxel};
}

double LevelSet::volume() const {
  // A voxel counts by the part of it that a plane at its distance cuts off: 1/2 - phi / voxel,
  // clamped. Blocks are summed apart and then in order, whatever the number of threads.
  const std::int64_t count = block_count();
  std::vector<double> part(static_cast<std::size_t>(count));
  const float inverse = static_cast<float>(1.0 / voxel);
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < count; ++b) {
    double sum = 0.0;
    for (int o = 0; o < kBlock; ++o) {
      sum += std::clamp(0.5f - block(b)[o] * inverse, 0.0f, 1.0f);
    }
    part[static_cast<std::size_t>(b)] = sum;
  }
  double voxels = 0.0;
  for (double p : part) voxels += p;
  std::int64_t tiles = 0;
  map.for_each([&](const BlockCoordinate&, std::int32_t index) { tiles += index == kInside; });
  return (voxels + static_cast<double>(tiles) * kBlock) * voxel * voxel * voxel;
}

LevelSet allocate(double voxel, float background, const BlockMap& met) {
  LevelSet set;
  set.voxel = voxel;
  set.background = background;
  met.for_each([&](const BlockCoordinate& block, std::int32_t mark) {
    if (mark == kInside) {
      set.map.find_or_insert(block, kInside);
    } else {
      set.blocks.push_back(block);
    }
  });
  std::sort(set.blocks.begin(), set.blocks.end());
  for (std::size_t b = 0; b < set.blocks.size(); ++b) {
    set.map.find_or_insert(set.blocks[b], static_cast<std::int32_t>(b));
  }
  set.values.assign(set.blocks.size() * kBlock, background);
  return set;
}

namespace {

// Whether one of the 26 blocks around is outside the band; `is_outside(coordinate)`.
template <typename Outside>
bool has_outside_neighbour(const BlockCoordinate& at, Outside&& is_outside) {
  for (int n = 0; n < 27; ++n) {
    if (is_outside(BlockCoordinate{at.x + n / 9 - 1, at.y + n / 3 % 3 - 1, at.z + n % 3 - 1})) {
      return true;
    }
  }
  return false;
}

}  // namespace

void LevelSet::prune() {
  const std::int64_t count = block_count();
  std::vector<std::int32_t> mark(static_cast<std::size_t>(count));
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < count; ++b) {
    const auto [low, high] = std::minmax_element(block(b), block(b) + kBlock);
    mark[static_cast<std::size_t>(b)] = *low >= background     ? kOutside
                                        : *high <= -background ? kInside
                                                               : 0;
  }
  // Tiles inside do not touch the outside: where phi jumps (a field cut off by its grid's end) a
  // block of values stays between them, so that every crossing has its block.
  auto is_outside = [&](const BlockCoordinate& at) {
    const std::int32_t index = map.find(at);
    return index == kOutside || (index >= 0 && mark[static_cast<std::size_t>(index)] == kOutside);
  };
  BlockMap kept;
  for (std::int64_t b = 0; b < count; ++b) {
    const BlockCoordinate at = blocks[static_cast<std::size_t>(b)];
    std::int32_t m = mark[static_cast<std::size_t>(b)];
    if (m == kInside && has_outside_neighbour(at, is_outside)) m = 0;
    if (m != kOutside) kept.find_or_insert(at, m);
  }
  map.for_each([&](const BlockCoordinate& at, std::int32_t index) {
    if (index != kInside) return;
    kept.find_or_insert(at, has_outside_neighbour(at, is_outside) ? 0 : kInside);
  });
  LevelSet next = allocate(voxel, background, kept);
  if (!weights.empty()) next.weights.assign(next.values.size(), 1.0f);
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < next.block_count(); ++b) {
    const std::int32_t old = map.find(next.blocks[static_cast<std::size_t>(b)]);
    if (old == kInside) {
      std::fill_n(next.block(b), kBlock, -background);
    } else {
      std::copy_n(block(old), kBlock, next.block(b));
      if (!weights.empty()) std::copy_n(&weights[old * kBlock], kBlock, &next.weights[b * kBlock]);
    }
  }
  *this = std::move(next);
}

namespace {

// Copies a level set's block, or its tile value, to `out`.
void read_block(const LevelSet& set, const BlockCoordinate& at, float* out) {
  const std::int32_t index = set.map.find(at);
  if (index >= 0) {
    std::copy_n(set.block(index), kBlock, out);
  } else {
    std::fill_n(out, kBlock, set.tile_value(index));
  }
}

// What is known without values where `a` or `b` is a tile; otherwise 0.
std::int32_t combine_marks(std::int32_t a, std::int32_t b, Combination how) {
  if (how == Combination::kUnion) {
    if (a == kInside || b == kInside) return kInside;
    return a == kOutside && b == kOutside ? kOutside : 0;
  }
  if (a == kOutside || b == kOutside) return kOutside;
  return a == kInside && b == kInside ? kInside : 0;
}

std::int32_t opposite(std::int32_t mark) {
  if (mark == kInside) return kOutside;
  return mark == kOutside ? kInside : mark;
}

}  // namespace

LevelSet combine(const LevelSet& a, const LevelSet& b, Combination how) {
  const bool negate = how == Combination::kDifference;
  BlockMap met;
  auto meet = [&](const BlockCoordinate& at, std::int32_t) {
    const std::int32_t in_b = b.map.find(at);
    const std::int32_t mark = combine_marks(a.map.find(at), negate ? opposite(in_b) : in_b, how);
    if (mark != kOutside) met.find_or_insert(at, mark);
  };
  a.map.for_each(meet);
  b.map.for_each(meet);
  LevelSet out = allocate(a.voxel, std::min(a.background, b.background), met);
#pragma omp parallel for schedule(static)
  for (std::int64_t index = 0; index < out.block_count(); ++index) {
    float left[kBlock], right[kBlock];
    read_block(a, out.blocks[static_cast<std::size_t>(index)], left);
    read_block(b, out.blocks[static_cast<std::size_t>(index)], right);
    float* result = out.block(index);
    for (int o = 0; o < kBlock; ++o) {
      const float other = negate ? -right[o] : right[o];
      const float phi =
          how == Combination::kUnion ? std::min(left[o], other) : std::max(left[o], other);
      result[o] = std::clamp(phi, -out.background, out.background);
    }
  }
  out.prune();
  return out;
}

LevelSet limited(const LevelSet& set, const LevelSet& reference, float limit) {
  LevelSet out = reference;
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < out.block_count(); ++b) {
    float wanted[kBlock];
    read_block(set, out.blocks[static_cast<std::size_t>(b)], wanted);
    float* phi = out.block(b);
    for (int o = 0; o < kBlock; ++o) {
      const float near = std::clamp(wanted[o], phi[o] - limit, phi[o] + limit);
      phi[o] = std::clamp(near, -out.background, out.background);
    }
  }
  out.prune();
  return out;
}

}  // namespace vulnus::geometry
