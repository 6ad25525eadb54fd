#include "geometry/marching_cubes.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "geometry/cube_cases.hpp"

namespace vulnus::geometry {

namespace {

constexpr int kCorners = kSide + 1;
constexpr int kWords = 3 * kBlock / 64;

struct CornerValues {
  float phi[kCorners][kCorners][kCorners];
};

// Grid edges that start in a block and cross the surface: bit (axis * 512 + voxel offset).
struct CrossedEdges {
  std::array<std::uint64_t, kWords> bits{};
  std::array<std::uint16_t, kWords> before{};  // set bits in the words before
  std::int64_t first_vertex = 0;
  std::int64_t first_triangle = 0;

  void set(int edge) { bits[static_cast<std::size_t>(edge >> 6)] |= 1ull << (edge & 63); }
  int count() {
    int sum = 0;
    for (std::size_t w = 0; w < kWords; ++w) {
      before[w] = static_cast<std::uint16_t>(sum);
      sum += std::popcount(bits[w]);
    }
    return sum;
  }
  std::int64_t vertex(int edge) const {
    const std::size_t word = static_cast<std::size_t>(edge >> 6);
    const std::uint64_t below = bits[word] & ((1ull << (edge & 63)) - 1);
    return first_vertex + before[word] + std::popcount(below);
  }
};

// Stored blocks and those below them: every cell and edge that can cross belongs to one.
std::vector<BlockCoordinate> cell_blocks(const LevelSet& set) {
  BlockMap met;
  std::vector<BlockCoordinate> cells = set.blocks;
  for (const BlockCoordinate& at : set.blocks) {
    for (int c = 1; c < 8; ++c) {
      const BlockCoordinate below{at.x - (c >> 2), at.y - (c >> 1 & 1), at.z - (c & 1)};
      if (set.map.find(below) >= 0) continue;
      if (met.find_or_insert(below, 0) == 0) {
        cells.push_back(below);
        met.find_or_insert(below, 0) = 1;
      }
    }
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

void gather(const LevelSet& set, const BlockCoordinate& at, CornerValues& corners) {
  for (int c = 0; c < 8; ++c) {
    const int bx = c >> 2, by = c >> 1 & 1, bz = c & 1;
    const std::int32_t index = set.map.find({at.x + bx, at.y + by, at.z + bz});
    const float* values = index >= 0 ? set.block(index) : nullptr;
    const float tile = set.tile_value(index);
    for (int x = 0; x < (bx ? 1 : kSide); ++x) {
      for (int y = 0; y < (by ? 1 : kSide); ++y) {
        for (int z = 0; z < (bz ? 1 : kSide); ++z) {
          corners.phi[x + bx * kSide][y + by * kSide][z + bz * kSide] =
              values ? values[voxel_offset(x, y, z)] : tile;
        }
      }
    }
  }
}

bool crosses(float a, float b) { return (a < 0.0f) != (b < 0.0f); }

float far_corner(const CornerValues& c, int x, int y, int z, int axis) {
  return c.phi[x + (axis == 0)][y + (axis == 1)][z + (axis == 2)];
}

int signs_of(const CornerValues& c, int x, int y, int z) {
  int signs = 0;
  for (int k = 0; k < 8; ++k) {
    signs |= (c.phi[x + (k >> 2)][y + (k >> 1 & 1)][z + (k & 1)] < 0.0f) << k;
  }
  return signs;
}

bool has_both_signs(const CornerValues& corners) {
  const float* phi = &corners.phi[0][0][0];
  int inside = 0;
  for (int c = 0; c < kCorners * kCorners * kCorners; ++c) inside += phi[c] < 0.0f;
  return inside != 0 && inside != kCorners * kCorners * kCorners;
}

struct BlockCount {
  int vertices = 0, triangles = 0;
};

BlockCount mark_crossings(const CornerValues& corners, CrossedEdges& edges) {
  BlockCount count;
  for (int o = 0; o < kBlock; ++o) {
    const int x = o >> 6, y = o >> 3 & 7, z = o & 7;
    for (int axis = 0; axis < 3; ++axis) {
      if (crosses(corners.phi[x][y][z], far_corner(corners, x, y, z, axis))) {
        edges.set(axis * kBlock + o);
      }
    }
    count.triangles += CubeCases::table()[signs_of(corners, x, y, z)].triangle_count;
  }
  count.vertices = edges.count();
  return count;
}

class Surface {
 public:
  explicit Surface(const LevelSet& set) : set_(set), cells_(cell_blocks(set)) {}

  Mesh extract() {
    count_crossings();
    for (std::size_t b = 0; b < active_.size(); ++b) {
      index_.find_or_insert(active_[b], static_cast<std::int32_t>(b));
    }
#pragma omp parallel for schedule(static)
    for (std::int64_t b = 0; b < static_cast<std::int64_t>(active_.size()); ++b) {
      CornerValues corners;
      gather(set_, active_[static_cast<std::size_t>(b)], corners);
      write_vertices(b, corners);
      write_triangles(b, corners);
    }
    return std::move(mesh_);
  }

 private:
  void count_crossings() {
    const std::int64_t count = static_cast<std::int64_t>(cells_.size());
    std::vector<std::uint8_t> mixed(cells_.size());
#pragma omp parallel for schedule(static)
    for (std::int64_t b = 0; b < count; ++b) {
      CornerValues corners;
      gather(set_, cells_[static_cast<std::size_t>(b)], corners);
      mixed[static_cast<std::size_t>(b)] = has_both_signs(corners);
    }
    for (std::size_t b = 0; b < cells_.size(); ++b) {
      if (mixed[b]) active_.push_back(cells_[b]);
    }
    edges_.resize(active_.size());
    std::vector<BlockCount> counts(active_.size());
#pragma omp parallel for schedule(static)
    for (std::int64_t b = 0; b < static_cast<std::int64_t>(active_.size()); ++b) {
      CornerValues corners;
      gather(set_, active_[static_cast<std::size_t>(b)], corners);
      counts[static_cast<std::size_t>(b)] =
          mark_crossings(corners, edges_[static_cast<std::size_t>(b)]);
    }
    std::int64_t vertices = 0, triangles = 0;
    for (std::size_t b = 0; b < active_.size(); ++b) {
      edges_[b].first_vertex = vertices;
      edges_[b].first_triangle = triangles;
      vertices += counts[b].vertices;
      triangles += counts[b].triangles;
    }
    mesh_.vertices.resize(static_cast<std::size_t>(3 * vertices));
    mesh_.triangles.resize(static_cast<std::size_t>(3 * triangles));
  }

  void write_vertices(std::int64_t b, const CornerValues& corners) {
    const BlockCoordinate at = active_[static_cast<std::size_t>(b)];
    const CrossedEdges& edges = edges_[static_cast<std::size_t>(b)];
    for (int axis = 0; axis < 3; ++axis) {
      for (int o = 0; o < kBlock; ++o) {
        const int x = o >> 6, y = o >> 3 & 7, z = o & 7;
        const float start = corners.phi[x][y][z], end = far_corner(corners, x, y, z, axis);
        if (!crosses(start, end)) continue;
        // Kept off the corners, where several edges would give one point and empty triangles.
        const double t = std::clamp(static_cast<double>(start) / (start - end), 1e-3, 1.0 - 1e-3);
        double point[3] = {8.0 * at.x + x, 8.0 * at.y + y, 8.0 * at.z + z};
        point[axis] += t;
        float* out = mesh_.vertices.data() + 3 * edges.vertex(axis * kBlock + o);
        for (int d = 0; d < 3; ++d) out[d] = static_cast<float>(point[d] * set_.voxel);
      }
    }
  }

  void write_triangles(std::int64_t b, const CornerValues& corners) {
    const BlockCoordinate at = active_[static_cast<std::size_t>(b)];
    const CrossedEdges* owner[8];
    for (int c = 0; c < 8; ++c) {
      const std::int32_t found =
          index_.find({at.x + (c >> 2), at.y + (c >> 1 & 1), at.z + (c & 1)});
      owner[c] = found >= 0 ? &edges_[static_cast<std::size_t>(found)] : nullptr;
    }
    std::int32_t* out =
        mesh_.triangles.data() + 3 * edges_[static_cast<std::size_t>(b)].first_triangle;
    const CubeCases& cases = CubeCases::table();
    for (int o = 0; o < kBlock; ++o) {
      const int x = o >> 6, y = o >> 3 & 7, z = o & 7;
      const CubeCase& cube = cases[signs_of(corners, x, y, z)];
      for (int e = 0; e < 3 * cube.triangle_count; ++e) {
        const CubeEdge& edge = cases.edge(cube.edge[static_cast<std::size_t>(e)]);
        const int sx = x + (edge.start >> 2), sy = y + (edge.start >> 1 & 1),
                  sz = z + (edge.start & 1);
        const int block = (sx >> 3) << 2 | (sy >> 3) << 1 | sz >> 3;
        const int bit = edge.axis * kBlock + voxel_offset(sx & 7, sy & 7, sz & 7);
        *out++ = static_cast<std::int32_t>(owner[block]->vertex(bit));
      }
    }
  }

  const LevelSet& set_;
  std::vector<BlockCoordinate> cells_, active_;
  std::vector<CrossedEdges> edges_;
  BlockMap index_;
  Mesh mesh_;
};

}  // namespace

Mesh marching_cubes(const LevelSet& set) { return Surface(set).extract(); }

}  // namespace vulnus::geometry
