// Fields on a regular grid of nodes, sampled trilinearly; x is the slowest index, z the fastest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace vulnus::hemorrhage {

template <class Real>
struct GridFrame {
  std::array<Real, 3> origin{};
  Real inverse_cell = 1;
  std::array<std::int64_t, 3> shape{0, 0, 0};

  // Finds the cell of a point and its fractions; false outside the grid.
  bool locate(Real x, Real y, Real z, std::size_t& node, std::array<Real, 3>& fraction) const {
    const std::array<Real, 3> point{x, y, z};
    std::array<std::int64_t, 3> base{};
    for (int a = 0; a < 3; ++a) {
      const Real u = (point[a] - origin[a]) * inverse_cell;
      if (!(u >= Real(0)) || u > Real(shape[a] - 1)) return false;
      base[a] = std::min<std::int64_t>(static_cast<std::int64_t>(u), shape[a] - 2);
      fraction[a] = u - Real(base[a]);
    }
    node = static_cast<std::size_t>((base[0] * shape[1] + base[1]) * shape[2] + base[2]);
    return true;
  }
  std::size_t corner(std::size_t node, int c) const {
    return node +
           static_cast<std::size_t>(((c >> 2) * shape[1] + ((c >> 1) & 1)) * shape[2] + (c & 1));
  }
};

template <class Real>
Real corner_weight(const std::array<Real, 3>& f, int c) {
  return ((c & 4) ? f[0] : Real(1) - f[0]) * ((c & 2) ? f[1] : Real(1) - f[1]) *
         ((c & 1) ? f[2] : Real(1) - f[2]);
}

// A signed distance [m]; far outside its grid nothing is near.
template <class Real>
class DistanceField {
 public:
  GridFrame<Real> frame;
  std::vector<float> value;

  bool empty() const { return value.empty(); }
  static constexpr Real far() { return Real(1e3); }

  Real sample(Real x, Real y, Real z) const {
    std::size_t node;
    std::array<Real, 3> f;
    if (empty() || !frame.locate(x, y, z, node, f)) return far();
    Real sum = 0;
    for (int c = 0; c < 8; ++c) sum += corner_weight(f, c) * Real(value[frame.corner(node, c)]);
    return sum;
  }

  // Unit vector out of the solid: the gradient of the trilinear interpolant.
  std::array<Real, 3> normal(Real x, Real y, Real z) const {
    std::size_t node;
    std::array<Real, 3> f, g{0, 0, 0};
    if (empty() || !frame.locate(x, y, z, node, f)) return g;
    for (int c = 0; c < 8; ++c) {
      const Real v = Real(value[frame.corner(node, c)]);
      const Real wx = (c & 4) ? f[0] : Real(1) - f[0];
      const Real wy = (c & 2) ? f[1] : Real(1) - f[1];
      const Real wz = (c & 1) ? f[2] : Real(1) - f[2];
      g[0] += ((c & 4) ? v : -v) * wy * wz;
      g[1] += ((c & 2) ? v : -v) * wx * wz;
      g[2] += ((c & 1) ? v : -v) * wx * wy;
    }
    const Real norm = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    if (norm > Real(0)) {
      for (Real& component : g) component /= norm;
    }
    return g;
  }
};

// A flat slab: a square face with a normal, solid below it to a depth. Local frame [m].
template <class Real>
struct Slab {
  bool enabled = false;
  std::array<Real, 3> point{}, normal{}, along{}, across{};
  Real half_extent = 0, thickness = 0;

  Real distance(Real x, Real y, Real z) const {
    if (!enabled) return DistanceField<Real>::far();
    const std::array<Real, 3> d{x - point[0], y - point[1], z - point[2]};
    const auto dot = [&d](const std::array<Real, 3>& u) {
      return d[0] * u[0] + d[1] * u[1] + d[2] * u[2];
    };
    const Real height = dot(normal);
    const bool over = std::abs(dot(along)) < half_extent && std::abs(dot(across)) < half_extent;
    return over && height > -thickness ? height : DistanceField<Real>::far();
  }
};

// Tissue on its grid: porosity and the logarithm of the drag rate. The logarithm makes the border
// between open tract and tight tissue lie half way between their nodes; where a cell touches no
// tissue, blood is free.
template <class Real>
class TissueField {
 public:
  GridFrame<Real> frame;
  std::vector<float> porosity, log_rate;  // log_rate = kFree in nodes without tissue
  static constexpr float kFree = -1e30f;
  // Drag that nobody can tell from none [1/s]: it would take 100 s to stop a drop. Chosen.
  static constexpr double kFreeLogRate = -4.6;

  bool empty() const { return porosity.empty(); }

  void sample(Real x, Real y, Real z, Real& eps, Real& rate) const {
    eps = 1;
    rate = 0;
    std::size_t node;
    std::array<Real, 3> f;
    if (empty() || !frame.locate(x, y, z, node, f)) return;
    Real eps_sum = 0, log_sum = 0;
    bool tissue = false;
    for (int c = 0; c < 8; ++c) {
      const std::size_t k = frame.corner(node, c);
      const Real w = corner_weight(f, c);
      const bool free = log_rate[k] == kFree;
      tissue = tissue || (!free && w > Real(0));
      eps_sum += w * Real(porosity[k]);
      log_sum += w * (free ? Real(kFreeLogRate) : Real(log_rate[k]));
    }
    if (!tissue) return;
    eps = eps_sum;
    rate = std::exp(log_sum);
  }
};

}  // namespace vulnus::hemorrhage
