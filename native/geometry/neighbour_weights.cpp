// How crowded each particle is, for a curvature flow that spares single drops (the weighting of
// Loeschner et al. 2023, doi:10.2312/vmv.20231245, applied to the flow of the level set).

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/shapes.hpp"

namespace vulnus::geometry {

void neighbour_weights(const double* centres, std::int64_t count, double reach, double full,
                       float* weights) {
  auto cell_of = [&](const double* p) {
    return BlockCoordinate{static_cast<std::int32_t>(std::floor(p[0] / reach)),
                           static_cast<std::int32_t>(std::floor(p[1] / reach)),
                           static_cast<std::int32_t>(std::floor(p[2] / reach))};
  };
  BlockMap cells;
  std::vector<std::int32_t> cell(static_cast<std::size_t>(count)), next(cell.size());
  std::vector<std::int32_t> head;
  for (std::int64_t p = 0; p < count; ++p) {
    std::int32_t& id =
        cells.find_or_insert(cell_of(centres + 3 * p), static_cast<std::int32_t>(head.size()));
    if (id == static_cast<std::int32_t>(head.size())) head.push_back(-1);
    next[static_cast<std::size_t>(p)] = head[static_cast<std::size_t>(id)];
    head[static_cast<std::size_t>(id)] = static_cast<std::int32_t>(p);
  }
#pragma omp parallel for schedule(dynamic, 256)
  for (std::int64_t p = 0; p < count; ++p) {
    const double* own = centres + 3 * p;
    const BlockCoordinate at = cell_of(own);
    std::int64_t neighbours = -1;  // the particle finds itself
    for (int c = 0; c < 27; ++c) {
      const std::int32_t id =
          cells.find({at.x + c / 9 - 1, at.y + c / 3 % 3 - 1, at.z + c % 3 - 1});
      if (id < 0) continue;
      for (std::int32_t q = head[static_cast<std::size_t>(id)]; q >= 0;
           q = next[static_cast<std::size_t>(q)]) {
        const double* other = centres + 3 * static_cast<std::int64_t>(q);
        const double dx = other[0] - own[0], dy = other[1] - own[1], dz = other[2] - own[2];
        neighbours += dx * dx + dy * dy + dz * dz <= reach * reach;
      }
    }
    const double x = std::clamp(static_cast<double>(neighbours) / full, 0.0, 1.0);
    weights[p] = static_cast<float>(x * x * (3.0 - 2.0 * x));  // smoothstep
  }
}

}  // namespace vulnus::geometry
