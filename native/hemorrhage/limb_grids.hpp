// Grids around the injured limb: distance to points, and how much tissue is where.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vulnus::hemorrhage {

// A regular grid of nodes; x slowest, z fastest.
struct NodeGrid {
  std::array<double, 3> origin{};
  double cell = 0;
  std::array<std::int64_t, 3> shape{};
  std::size_t count() const { return static_cast<std::size_t>(shape[0] * shape[1] * shape[2]); }
};

// Distance [m] of each node to the nearest point, `reach` where none is nearer than that.
void nearest_distance(const float* points, std::size_t n, const NodeGrid& grid, double reach,
                      float* distance);

// Volume fraction of tissue (1 where points stand as densely as they were made) and mean damage at
// each node, smoothed by the Wendland C2 kernel of radius `reach`.
void tissue_fraction(const float* points, const float* volume, const float* damage, std::size_t n,
                     const NodeGrid& grid, double reach, float* fraction, float* mean_damage);

// Indices of points, in order, that keep at least `distance` from all kept before them.
std::vector<std::int64_t> thin_points(const double* points, std::size_t n, double distance);

}  // namespace vulnus::hemorrhage
