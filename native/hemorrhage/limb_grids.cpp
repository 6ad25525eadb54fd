#include "hemorrhage/limb_grids.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "hemorrhage/smoothing_kernel.hpp"

namespace vulnus::hemorrhage {
namespace {

// Calls visit(node, squared distance) for the nodes within `reach` of a point.
template <class Visit>
void visit_nodes(const NodeGrid& grid, const float* point, double reach, Visit&& visit) {
  std::array<std::int64_t, 3> low, high;
  for (int a = 0; a < 3; ++a) {
    const double u = point[a] - grid.origin[a];
    low[a] =
        std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil((u - reach) / grid.cell)));
    high[a] = std::min<std::int64_t>(
        grid.shape[a] - 1, static_cast<std::int64_t>(std::floor((u + reach) / grid.cell)));
  }
  for (std::int64_t i = low[0]; i <= high[0]; ++i) {
    const double dx = grid.origin[0] + grid.cell * i - point[0];
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      const double dy = grid.origin[1] + grid.cell * j - point[1];
      for (std::int64_t k = low[2]; k <= high[2]; ++k) {
        const double dz = grid.origin[2] + grid.cell * k - point[2];
        const double r2 = dx * dx + dy * dy + dz * dz;
        if (r2 < reach * reach) {
          visit(static_cast<std::size_t>((i * grid.shape[1] + j) * grid.shape[2] + k), r2);
        }
      }
    }
  }
}

}  // namespace

void nearest_distance(const float* points, std::size_t n, const NodeGrid& grid, double reach,
                      float* distance) {
  std::fill(distance, distance + grid.count(), static_cast<float>(reach * reach));
  for (std::size_t p = 0; p < n; ++p) {
    visit_nodes(grid, points + 3 * p, reach, [distance](std::size_t node, double r2) {
      distance[node] = std::min(distance[node], static_cast<float>(r2));
    });
  }
  for (std::size_t node = 0; node < grid.count(); ++node)
    distance[node] = std::sqrt(distance[node]);
}

void tissue_fraction(const float* points, const float* volume, const float* damage, std::size_t n,
                     const NodeGrid& grid, double reach, float* fraction, float* mean_damage) {
  std::fill(fraction, fraction + grid.count(), 0.0f);
  std::fill(mean_damage, mean_damage + grid.count(), 0.0f);
  const WendlandKernels<double> kernel(reach);
  for (std::size_t p = 0; p < n; ++p) {
    const double scale = volume[p] * kernel.density_factor;
    visit_nodes(grid, points + 3 * p, reach, [&](std::size_t node, double r2) {
      const double share = scale * kernel.density(r2);
      fraction[node] += static_cast<float>(share);
      mean_damage[node] += static_cast<float>(share * damage[p]);
    });
  }
  for (std::size_t node = 0; node < grid.count(); ++node) {
    if (fraction[node] > 0.0f) mean_damage[node] /= fraction[node];
  }
}

std::vector<std::int64_t> thin_points(const double* points, std::size_t n, double distance) {
  // Cells so small that each holds at most one kept point.
  const double edge = distance / std::sqrt(3.0) * 0.999;
  std::unordered_map<std::uint64_t, std::int64_t> kept_in_cell;
  std::vector<std::int64_t> kept;
  const auto cell_of = [edge](double u) { return static_cast<std::int64_t>(std::floor(u / edge)); };
  const auto key_of = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    constexpr std::int64_t kHalf = 1 << 20;
    return (static_cast<std::uint64_t>(i + kHalf) << 42) |
           (static_cast<std::uint64_t>(j + kHalf) << 21) | static_cast<std::uint64_t>(k + kHalf);
  };
  const auto crowded = [&](const double* p, std::int64_t i, std::int64_t j, std::int64_t k) {
    const auto found = kept_in_cell.find(key_of(i, j, k));
    if (found == kept_in_cell.end()) return false;
    const double* q = points + 3 * found->second;
    const double dx = p[0] - q[0], dy = p[1] - q[1], dz = p[2] - q[2];
    return dx * dx + dy * dy + dz * dz < distance * distance;
  };
  for (std::size_t index = 0; index < n; ++index) {
    const double* p = points + 3 * index;
    const std::int64_t i = cell_of(p[0]), j = cell_of(p[1]), k = cell_of(p[2]);
    bool free = true;
    for (int c = 0; c < 125 && free; ++c) {
      free = !crowded(p, i + c / 25 - 2, j + c / 5 % 5 - 2, k + c % 5 - 2);
    }
    if (!free) continue;
    kept_in_cell.emplace(key_of(i, j, k), static_cast<std::int64_t>(index));
    kept.push_back(static_cast<std::int64_t>(index));
  }
  return kept;
}

}  // namespace vulnus::hemorrhage
