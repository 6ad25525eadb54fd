// Slip walls that are planes of symmetry. The nodes behind such a wall are the mirror images of
// those before it: what particles scatter behind it is added to its image, and the velocity there
// is the image's. Strain, stress and motion beside the wall are then those of the whole body of
// which the half is computed, without a layer of cells that is too stiff or that opens a gap.
#pragma once

#include <cmath>
#include <optional>

#include "injury/boundary.hpp"

namespace vulnus::injury {

// A plane through a layer of nodes, across a coordinate axis.
struct Mirror {
  int axis;
  int free_side;  // +1 or -1 along the axis
  int node;       // of the layer on the plane, in the solver's local frame
};

constexpr int kMirrorDepth = 2;  // layers of nodes behind the plane that particles reach
constexpr double kMirrorTolerance =
    1e-5;  // cells between plane and nodes; walls come 1e-6 too high

// The mirror that a half space is: a slip wall at rest, on nodes and across an axis.
inline std::optional<Mirror> mirror_of(const HalfSpace& wall, double grid_spacing) {
  if (wall.kind != BoundaryKind::kSlip) return std::nullopt;
  for (int a = 0; a < 3; ++a) {
    if (wall.velocity[a] != 0) return std::nullopt;
    if (std::abs(std::abs(wall.normal[a]) - 1) > 1e-12) continue;
    const double place = wall.normal[a] * wall.height / grid_spacing;
    if (!(std::abs(place) < 1e6) || std::abs(place - std::round(place)) > kMirrorTolerance)
      return std::nullopt;
    return Mirror{a, wall.normal[a] > 0 ? 1 : -1, static_cast<int>(std::lround(place))};
  }
  return std::nullopt;
}

}  // namespace vulnus::injury
