// Mean curvature flow on the narrow band, with the re-distance step that keeps |grad phi| near 1.

#include <algorithm>
#include <cmath>

#include "core/host_device.hpp"
#include "geometry/level_set.hpp"

namespace vulnus::geometry {

namespace {

constexpr int kHalo = kSide + 2;

struct Halo {
  float phi[kHalo][kHalo][kHalo];
};

// The block with one voxel of its 26 neighbours around it [voxels]; clamped where none is stored.
void gather(const LevelSet& set, std::int64_t index, Halo& halo) {
  const BlockCoordinate at = set.blocks[static_cast<std::size_t>(index)];
  const float inverse = static_cast<float>(1.0 / set.voxel);
  for (int bx = -1; bx <= 1; ++bx) {
    for (int by = -1; by <= 1; ++by) {
      for (int bz = -1; bz <= 1; ++bz) {
        const std::int32_t found = set.map.find({at.x + bx, at.y + by, at.z + bz});
        const float* values = set.block(found >= 0 ? found : index);
        auto first = [](int b) { return b < 0 ? 0 : b == 0 ? 1 : kHalo - 1; };
        auto last = [](int b) { return b < 0 ? 1 : b == 0 ? kHalo - 1 : kHalo; };
        for (int x = first(bx); x < last(bx); ++x) {
          for (int y = first(by); y < last(by); ++y) {
            for (int z = first(bz); z < last(bz); ++z) {
              const bool own = found < 0;
              const int sx = own ? std::clamp(x - 1, 0, kSide - 1) : (x + kSide - 1) & 7;
              const int sy = own ? std::clamp(y - 1, 0, kSide - 1) : (y + kSide - 1) & 7;
              const int sz = own ? std::clamp(z - 1, 0, kSide - 1) : (z + kSide - 1) & 7;
              halo.phi[x][y][z] = values[voxel_offset(sx, sy, sz)] * inverse;
            }
          }
        }
      }
    }
  }
}

// Mean curvature (k1 + k2)/2 times |grad phi| by central differences, in voxels.
VULNUS_HD float curvature_speed(const Halo& h, int x, int y, int z) {
  const float c = h.phi[x][y][z];
  const float dx = 0.5f * (h.phi[x + 1][y][z] - h.phi[x - 1][y][z]);
  const float dy = 0.5f * (h.phi[x][y + 1][z] - h.phi[x][y - 1][z]);
  const float dz = 0.5f * (h.phi[x][y][z + 1] - h.phi[x][y][z - 1]);
  const float dxx = h.phi[x + 1][y][z] - 2.0f * c + h.phi[x - 1][y][z];
  const float dyy = h.phi[x][y + 1][z] - 2.0f * c + h.phi[x][y - 1][z];
  const float dzz = h.phi[x][y][z + 1] - 2.0f * c + h.phi[x][y][z - 1];
  const float dxy = 0.25f * (h.phi[x + 1][y + 1][z] - h.phi[x + 1][y - 1][z] -
                             h.phi[x - 1][y + 1][z] + h.phi[x - 1][y - 1][z]);
  const float dxz = 0.25f * (h.phi[x + 1][y][z + 1] - h.phi[x + 1][y][z - 1] -
                             h.phi[x - 1][y][z + 1] + h.phi[x - 1][y][z - 1]);
  const float dyz = 0.25f * (h.phi[x][y + 1][z + 1] - h.phi[x][y + 1][z - 1] -
                             h.phi[x][y - 1][z + 1] + h.phi[x][y - 1][z - 1]);
  const float square = dx * dx + dy * dy + dz * dz;
  const float numerator = dx * dx * (dyy + dzz)    //
                          + dy * dy * (dxx + dzz)  //
                          + dz * dz * (dxx + dyy)  //
                          - 2.0f * (dx * dy * dxy + dx * dz * dxz + dy * dz * dyz);
  // Where phi is flat (the axis between two sheets) the normal, and so the curvature, is undefined.
  return square > 1e-6f ? numerator / (2.0f * square) : 0.0f;
}

// |grad phi| of Godunov's upwind scheme for the sign of phi, in voxels.
VULNUS_HD float godunov_slope(const Halo& h, int x, int y, int z) {
  const float c = h.phi[x][y][z];
  const float sign = c > 0.0f ? 1.0f : -1.0f;
  auto axis = [sign](float backward, float forward) {
    const float b = std::max(sign * backward, 0.0f);
    const float f = std::max(-sign * forward, 0.0f);
    return std::max(b * b, f * f);
  };
  const float x2 = axis(c - h.phi[x - 1][y][z], h.phi[x + 1][y][z] - c);
  const float y2 = axis(c - h.phi[x][y - 1][z], h.phi[x][y + 1][z] - c);
  const float z2 = axis(c - h.phi[x][y][z - 1], h.phi[x][y][z + 1] - c);
  return std::sqrt(x2 + y2 + z2);
}

// New values from old ones, a block at a time; `law(halo, x, y, z, block, offset)` in voxels.
template <typename Law>
void update(LevelSet& set, Law&& law) {
  std::vector<float> next(set.values.size());
  const float band = static_cast<float>(set.background / set.voxel);
  const float voxel = static_cast<float>(set.voxel);
#pragma omp parallel for schedule(static)
  for (std::int64_t index = 0; index < set.block_count(); ++index) {
    Halo halo;
    gather(set, index, halo);
    float* out = next.data() + index * kBlock;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          const int offset = voxel_offset(x, y, z);
          const float old = halo.phi[x + 1][y + 1][z + 1];
          const float moved = law(halo, x + 1, y + 1, z + 1, index, offset);
          out[offset] = std::abs(old) >= band ? set.block(index)[offset]
                                              : std::clamp(moved, -band, band) * voxel;
        }
      }
    }
  }
  set.values.swap(next);
}

void godunov_step(LevelSet& set, float courant) {
  update(set, [courant](const Halo& h, int x, int y, int z, std::int64_t, int) {
    const float c = h.phi[x][y][z];
    const float sign = c / std::sqrt(c * c + 1.0f);
    return c - courant * sign * (godunov_slope(h, x, y, z) - 1.0f);
  });
}

}  // namespace

void flow_step(LevelSet& set) {
  const float* weights = set.weights.empty() ? nullptr : set.weights.data();
  update(set, [weights](const Halo& h, int x, int y, int z, std::int64_t index, int offset) {
    const float weight = weights ? weights[index * kBlock + offset] : 1.0f;
    return h.phi[x][y][z] + weight * (1.0f / 3.0f) * curvature_speed(h, x, y, z);
  });
  godunov_step(set, 0.3f);
}

void redistance(LevelSet& set, int steps, float courant) {
  for (int step = 0; step < steps; ++step) godunov_step(set, courant);
}

}  // namespace vulnus::geometry
