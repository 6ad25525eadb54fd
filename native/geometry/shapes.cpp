#include "geometry/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vulnus::geometry {

namespace {

// Shapes live in voxel units relative to the origin of the grid; a law gives the signed distance
// along one row of eight voxels of a block (z fastest).
struct Interval {
  double low[3], high[3];
};

struct SphereLaw {
  Point c;
  double radius;

  Interval bounds() const {
    return {{c.x - radius, c.y - radius, c.z - radius}, {c.x + radius, c.y + radius, c.z + radius}};
  }

  // Range of the signed distance over the voxels of a block.
  void range(const BlockCoordinate& block, double& nearest, double& farthest) const {
    const double centre[3] = {c.x, c.y, c.z};
    const std::int32_t corner[3] = {block.x, block.y, block.z};
    double near2 = 0.0, far2 = 0.0;
    for (int a = 0; a < 3; ++a) {
      const double low = 8.0 * corner[a], high = low + 7.0;
      const double gap = std::max({low - centre[a], centre[a] - high, 0.0});
      const double span = std::max(std::abs(centre[a] - low), std::abs(centre[a] - high));
      near2 += gap * gap;
      far2 += span * span;
    }
    nearest = std::sqrt(near2) - radius;
    farthest = std::sqrt(far2) - radius;
  }

  void row(const BlockCoordinate& block, int x, int y, float* distance) const {
    const float dx = static_cast<float>(8.0 * block.x + x - c.x);
    const float dy = static_cast<float>(8.0 * block.y + y - c.y);
    const float z0 = static_cast<float>(8.0 * block.z - c.z);
    const float r = static_cast<float>(radius);
    const float square = dx * dx + dy * dy;
    for (int z = 0; z < kSide; ++z) {
      const float dz = z0 + static_cast<float>(z);
      distance[z] = std::sqrt(square + dz * dz) - r;
    }
  }

  bool row_in_reach(const BlockCoordinate& block, int x, int y, double reach) const {
    const double dx = 8.0 * block.x + x - c.x, dy = 8.0 * block.y + y - c.y;
    return dx * dx + dy * dy < (radius + reach) * (radius + reach);
  }
};

struct ConeLaw {
  Point a, axis;  // start and (end - start)
  double radius_start, radius_change, inverse_square;

  Interval bounds() const {
    const double r = std::max(radius_start, radius_start + radius_change);
    Interval box;
    const double start[3] = {a.x, a.y, a.z}, step[3] = {axis.x, axis.y, axis.z};
    for (int d = 0; d < 3; ++d) {
      box.low[d] = std::min(start[d], start[d] + step[d]) - r;
      box.high[d] = std::max(start[d], start[d] + step[d]) + r;
    }
    return box;
  }

  double distance_at(double x, double y, double z) const {
    const double px = x - a.x, py = y - a.y, pz = z - a.z;
    const double t =
        std::clamp((px * axis.x + py * axis.y + pz * axis.z) * inverse_square, 0.0, 1.0);
    const double dx = px - t * axis.x, dy = py - t * axis.y, dz = pz - t * axis.z;
    return std::sqrt(dx * dx + dy * dy + dz * dz) - (radius_start + t * radius_change);
  }

  void range(const BlockCoordinate& block, double& nearest, double& farthest) const {
    const double half_diagonal = 1.25 * 3.5 * std::sqrt(3.0);  // a taper makes it steeper than 1
    const double middle =
        distance_at(8.0 * block.x + 3.5, 8.0 * block.y + 3.5, 8.0 * block.z + 3.5);
    nearest = middle - half_diagonal;
    farthest = middle + half_diagonal;
  }

  void row(const BlockCoordinate& block, int x, int y, float* distance) const {
    for (int z = 0; z < kSide; ++z) {
      distance[z] =
          static_cast<float>(distance_at(8.0 * block.x + x, 8.0 * block.y + y, 8.0 * block.z + z));
    }
  }

  bool row_in_reach(const BlockCoordinate&, int, int, double) const { return true; }
};

// The smallest radius [voxels] that surely holds a grid point (half a voxel's diagonal, and a bit):
// thinner shapes are drawn with it, so that none is lost between the grid points.
constexpr double kSmallestRadius = 0.88;

// Visits the blocks whose voxels come within `reach` of the shape's surface from outside.
template <typename Shape, typename Visit>
void visit_blocks(const Shape& shape, double reach, Visit&& visit) {
  const Interval box = shape.bounds();
  std::int32_t low[3], high[3];
  for (int d = 0; d < 3; ++d) {
    low[d] = block_of(static_cast<std::int32_t>(std::ceil(box.low[d] - reach)));
    high[d] = block_of(static_cast<std::int32_t>(std::floor(box.high[d] + reach)));
  }
  BlockCoordinate block;
  for (block.x = low[0]; block.x <= high[0]; ++block.x) {
    for (block.y = low[1]; block.y <= high[1]; ++block.y) {
      for (block.z = low[2]; block.z <= high[2]; ++block.z) {
        double nearest, farthest;
        shape.range(block, nearest, farthest);
        if (nearest < reach) visit(block, farthest <= -reach);
      }
    }
  }
}

// Shapes of each block in their given order: those of block b are item[first[b] .. first[b + 1]).
struct Membership {
  std::vector<std::int64_t> first;
  std::vector<std::int32_t> item;
};

template <typename Shape>
Membership list_members(const std::vector<Shape>& shapes, const LevelSet& set, double reach) {
  Membership members;
  members.first.assign(set.blocks.size() + 1, 0);
  for (const Shape& shape : shapes) {
    visit_blocks(shape, reach, [&](const BlockCoordinate& block, bool) {
      const std::int32_t index = set.map.find(block);
      if (index >= 0) ++members.first[static_cast<std::size_t>(index) + 1];
    });
  }
  for (std::size_t b = 1; b < members.first.size(); ++b) members.first[b] += members.first[b - 1];
  members.item.resize(static_cast<std::size_t>(members.first.back()));
  std::vector<std::int64_t> next(members.first.begin(), members.first.end() - 1);
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    visit_blocks(shapes[s], reach, [&](const BlockCoordinate& block, bool) {
      const std::int32_t index = set.map.find(block);
      if (index >= 0) {
        members.item[static_cast<std::size_t>(next[static_cast<std::size_t>(index)]++)] =
            static_cast<std::int32_t>(s);
      }
    });
  }
  return members;
}

// Smallest distance of the block's voxels to the shapes in it, and the weight of that shape.
template <typename Shape>
void fill_block(const std::vector<Shape>& shapes, const std::int32_t* item, std::int64_t count,
                const BlockCoordinate& block, double reach, const float* weights, float* phi,
                float* weight) {
  std::fill_n(phi, kBlock, static_cast<float>(reach));
  for (std::int64_t m = 0; m < count; ++m) {
    const Shape& shape = shapes[static_cast<std::size_t>(item[m])];
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        if (!shape.row_in_reach(block, x, y, reach)) continue;
        float distance[kSide];
        shape.row(block, x, y, distance);
        float* row = phi + voxel_offset(x, y, 0);
        if (weights) {
          float* row_weight = weight + voxel_offset(x, y, 0);
          for (int z = 0; z < kSide; ++z) {
            row_weight[z] = distance[z] < row[z] ? weights[item[m]] : row_weight[z];
          }
        }
        for (int z = 0; z < kSide; ++z) row[z] = std::min(row[z], distance[z]);
      }
    }
  }
}

template <typename Shape>
LevelSet union_of(const std::vector<Shape>& shapes, const float* weights, double voxel,
                  double half_width) {
  BlockMap met;
  for (const Shape& shape : shapes) {
    visit_blocks(shape, half_width, [&](const BlockCoordinate& block, bool inside) {
      std::int32_t& mark = met.find_or_insert(block, 0);
      if (inside) mark = kInside;
    });
  }
  LevelSet set = allocate(voxel, static_cast<float>(half_width * voxel), met);
  if (weights) set.weights.assign(set.values.size(), 1.0f);
  const Membership members = list_members(shapes, set, half_width);
  const float scale = static_cast<float>(voxel);
#pragma omp parallel for schedule(dynamic, 16)
  for (std::int64_t b = 0; b < set.block_count(); ++b) {
    const std::int64_t first = members.first[static_cast<std::size_t>(b)];
    const std::int64_t count = members.first[static_cast<std::size_t>(b) + 1] - first;
    float* phi = set.block(b);
    fill_block(shapes, members.item.data() + first, count, set.blocks[static_cast<std::size_t>(b)],
               half_width, weights, phi, weights ? &set.weights[b * kBlock] : nullptr);
    for (int o = 0; o < kBlock; ++o) {
      phi[o] = std::clamp(phi[o] * scale, -set.background, set.background);
    }
  }
  set.prune();
  return set;
}

Point scaled(const double* p, double factor) {
  return {p[0] * factor, p[1] * factor, p[2] * factor};
}

}  // namespace

LevelSet union_of_spheres(const double* centres, const double* radii, std::int64_t count,
                          const float* weights, double voxel, double half_width) {
  std::vector<SphereLaw> shapes(static_cast<std::size_t>(count));
  for (std::int64_t s = 0; s < count; ++s) {
    shapes[static_cast<std::size_t>(s)] = {scaled(centres + 3 * s, 1.0 / voxel),
                                           std::max(radii[s] / voxel, kSmallestRadius)};
  }
  return union_of(shapes, weights, voxel, half_width);
}

LevelSet tube(const double* points, const double* radii, std::int64_t count, double voxel,
              double half_width) {
  std::vector<ConeLaw> shapes;
  for (std::int64_t s = 0; s < std::max<std::int64_t>(count - 1, 1); ++s) {
    const std::int64_t next = std::min(s + 1, count - 1);
    const Point a = scaled(points + 3 * s, 1.0 / voxel), b = scaled(points + 3 * next, 1.0 / voxel);
    const Point axis{b.x - a.x, b.y - a.y, b.z - a.z};
    const double square = axis.x * axis.x + axis.y * axis.y + axis.z * axis.z;
    const double start = std::max(radii[s] / voxel, kSmallestRadius);
    const double end = std::max(radii[next] / voxel, kSmallestRadius);
    shapes.push_back({a, axis, start, end - start, square > 0.0 ? 1.0 / square : 0.0});
  }
  return union_of(shapes, nullptr, voxel, half_width);
}

namespace {

float sample_field(const DenseField& field, double x, double y, double z) {
  const double* m = field.to_index;
  const std::int64_t size[3] = {field.nx, field.ny, field.nz};
  std::int64_t base[3];
  float part[3];
  for (int a = 0; a < 3; ++a) {
    const double index = m[4 * a] * x + m[4 * a + 1] * y + m[4 * a + 2] * z + m[4 * a + 3];
    const double inner = std::clamp(index, 0.0, static_cast<double>(size[a] - 1));
    base[a] = std::min(static_cast<std::int64_t>(inner), std::max<std::int64_t>(size[a] - 2, 0));
    part[a] = static_cast<float>(inner - static_cast<double>(base[a]));
  }
  const std::int64_t step_x = size[0] > 1 ? field.ny * field.nz : 0;
  const std::int64_t step_y = size[1] > 1 ? field.nz : 0;
  const std::int64_t step_z = size[2] > 1 ? 1 : 0;
  const float* p = field.phi + (base[0] * field.ny + base[1]) * field.nz + base[2];
  auto along_z = [&](const float* q) { return q[0] + part[2] * (q[step_z] - q[0]); };
  auto along_y = [&](const float* q) {
    const float low = along_z(q), high = along_z(q + step_y);
    return low + part[1] * (high - low);
  };
  const float low = along_y(p), high = along_y(p + step_x);
  return low + part[0] * (high - low);
}

}  // namespace

LevelSet resample(const DenseField& field, double voxel, double half_width, const Point& low,
                  const Point& high) {
  const double band = half_width * voxel;
  // |phi| changes by at most the distance; a quarter more allows for fields that are steeper.
  const double margin = band + 1.25 * 3.5 * std::sqrt(3.0) * voxel;
  const double corner[2][3] = {{low.x, low.y, low.z}, {high.x, high.y, high.z}};
  std::int32_t first[3], last[3];
  for (int a = 0; a < 3; ++a) {
    first[a] = block_of(static_cast<std::int32_t>(std::floor((corner[0][a] - band) / voxel)));
    last[a] = block_of(static_cast<std::int32_t>(std::ceil((corner[1][a] + band) / voxel)));
  }
  const std::int64_t ny = last[1] - first[1] + 1, nz = last[2] - first[2] + 1;
  const std::int64_t total = (last[0] - first[0] + 1) * ny * nz;
  auto block_at = [&](std::int64_t b) {
    return BlockCoordinate{static_cast<std::int32_t>(first[0] + b / (ny * nz)),
                           static_cast<std::int32_t>(first[1] + b / nz % ny),
                           static_cast<std::int32_t>(first[2] + b % nz)};
  };
  std::vector<std::int32_t> mark(static_cast<std::size_t>(total));
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < total; ++b) {
    const BlockCoordinate at = block_at(b);
    const float phi = sample_field(field, (8.0 * at.x + 3.5) * voxel, (8.0 * at.y + 3.5) * voxel,
                                   (8.0 * at.z + 3.5) * voxel);
    mark[static_cast<std::size_t>(b)] = phi > margin ? kOutside : phi < -margin ? kInside : 0;
  }
  BlockMap met;
  for (std::int64_t b = 0; b < total; ++b) {
    const std::int32_t m = mark[static_cast<std::size_t>(b)];
    if (m != kOutside) met.find_or_insert(block_at(b), m);
  }
  LevelSet set = allocate(voxel, static_cast<float>(band), met);
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < set.block_count(); ++b) {
    const BlockCoordinate at = set.blocks[static_cast<std::size_t>(b)];
    for (int o = 0; o < kBlock; ++o) {
      const float phi =
          sample_field(field, (8.0 * at.x + o / 64) * voxel, (8.0 * at.y + o / 8 % 8) * voxel,
                       (8.0 * at.z + o % 8) * voxel);
      set.block(b)[o] = std::clamp(phi, -set.background, set.background);
    }
  }
  set.prune();
  return set;
}

LevelSet cut(const LevelSet& set, const Point& normal, double offset) {
  const double reach =
      3.5 * set.voxel * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
  auto height = [&](double x, double y, double z) {
    return (normal.x * x + normal.y * y + normal.z * z) * set.voxel - offset;
  };
  BlockMap met;
  set.map.for_each([&](const BlockCoordinate& at, std::int32_t index) {
    const double middle = height(8.0 * at.x + 3.5, 8.0 * at.y + 3.5, 8.0 * at.z + 3.5);
    if (middle - reach > set.background) return;
    const bool wholly = index == kInside && middle + reach < -set.background;
    met.find_or_insert(at, wholly ? kInside : 0);
  });
  LevelSet out = allocate(set.voxel, set.background, met);
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < out.block_count(); ++b) {
    const BlockCoordinate at = out.blocks[static_cast<std::size_t>(b)];
    const std::int32_t index = set.map.find(at);
    for (int o = 0; o < kBlock; ++o) {
      const float old = index >= 0 ? set.block(index)[o] : set.tile_value(index);
      const double plane = height(8.0 * at.x + o / 64, 8.0 * at.y + o / 8 % 8, 8.0 * at.z + o % 8);
      out.block(b)[o] =
          std::clamp(std::max(old, static_cast<float>(plane)), -out.background, out.background);
    }
  }
  out.prune();
  return out;
}

}  // namespace vulnus::geometry
