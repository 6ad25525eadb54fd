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

// Places of the halo that neighbour b (-1, 0, 1) fills along one axis.
constexpr int first_place(int b) { return b < 0 ? 0 : b == 0 ? 1 : kHalo - 1; }
constexpr int last_place(int b) { return b < 0 ? 1 : b == 0 ? kHalo - 1 : kHalo; }

// The neighbour's voxel at a place of the halo, or the block's own nearest one.
constexpr int voxel_at(int place, bool own) {
  return own ? std::clamp(place - 1, 0, kSide - 1) : (place + kSide - 1) & 7;
}

void copy_part(const float* values, bool own, int bx, int by, int bz, float scale, Halo& halo) {
  for (int x = first_place(bx); x < last_place(bx); ++x) {
    for (int y = first_place(by); y < last_place(by); ++y) {
      const float* row = values + voxel_offset(voxel_at(x, own), voxel_at(y, own), 0);
      if (bz == 0) {
        for (int z = 0; z < kSide; ++z) halo.phi[x][y][z + 1] = row[z] * scale;
      } else {
        const int place = first_place(bz);
        halo.phi[x][y][place] = row[voxel_at(place, own)] * scale;
      }
    }
  }
}

// The block with one voxel of its 26 neighbours around it [voxels]; clamped where none is stored.
void gather(const LevelSet& set, std::int64_t index, const std::array<std::int32_t, 27>& neighbours,
            Halo& halo) {
  const float scale = static_cast<float>(1.0 / set.voxel);
  for (int n = 0; n < 27; ++n) {
    const std::int32_t found = neighbours[static_cast<std::size_t>(n)];
    const bool own = found < 0;
    copy_part(set.block(own ? index : found), own, n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1, scale,
              halo);
  }
}

constexpr int kX = kHalo * kHalo, kY = kHalo, kZ = 1;  // steps to the neighbours in a halo

// Mean curvature (k1 + k2)/2 times |grad phi| by central differences, in voxels.
VULNUS_HD float curvature_speed(const float* p) {
  const float dx = 0.5f * (p[kX] - p[-kX]);
  const float dy = 0.5f * (p[kY] - p[-kY]);
  const float dz = 0.5f * (p[kZ] - p[-kZ]);
  const float dxx = p[kX] - 2.0f * p[0] + p[-kX];
  const float dyy = p[kY] - 2.0f * p[0] + p[-kY];
  const float dzz = p[kZ] - 2.0f * p[0] + p[-kZ];
  const float dxy = 0.25f * (p[kX + kY] - p[kX - kY] - p[kY - kX] + p[-kX - kY]);
  const float dxz = 0.25f * (p[kX + kZ] - p[kX - kZ] - p[kZ - kX] + p[-kX - kZ]);
  const float dyz = 0.25f * (p[kY + kZ] - p[kY - kZ] - p[kZ - kY] + p[-kY - kZ]);
  const float square = dx * dx + dy * dy + dz * dz;
  const float numerator = dx * dx * (dyy + dzz)    //
                          + dy * dy * (dxx + dzz)  //
                          + dz * dz * (dxx + dyy)  //
                          - 2.0f * (dx * dy * dxy + dx * dz * dxz + dy * dz * dyz);
  // Where phi is flat (the axis between two sheets) the normal, and so the curvature, is undefined.
  const float curved = square > 1e-6f ? numerator : 0.0f;
  return curved / (2.0f * square + 1e-12f);
}

// Godunov's upwind choice of the squared slope along one axis, away from the surface.
VULNUS_HD float upwind_square(float sign, float backward, float forward) {
  const float b = std::max(sign * backward, 0.0f);
  const float f = std::max(-sign * forward, 0.0f);
  return std::max(b * b, f * f);
}

// phi - courant * S(phi) (|grad phi| - 1), in voxels.
VULNUS_HD float redistanced(const float* p, float courant) {
  const float sign = p[0] > 0.0f ? 1.0f : -1.0f;
  const float slope = std::sqrt(upwind_square(sign, p[0] - p[-kX], p[kX] - p[0]) +
                                upwind_square(sign, p[0] - p[-kY], p[kY] - p[0]) +
                                upwind_square(sign, p[0] - p[-kZ], p[kZ] - p[0]));
  const float smooth_sign = p[0] / std::sqrt(p[0] * p[0] + 1.0f);
  return p[0] - courant * smooth_sign * (slope - 1.0f);
}

}  // namespace

BandFlow::BandFlow(LevelSet& set)
    : set_(set), neighbours_(set.blocks.size()), next_(set.values.size()) {
#pragma omp parallel for schedule(static)
  for (std::int64_t b = 0; b < set.block_count(); ++b) {
    const BlockCoordinate at = set.blocks[static_cast<std::size_t>(b)];
    for (int n = 0; n < 27; ++n) {
      neighbours_[static_cast<std::size_t>(b)][static_cast<std::size_t>(n)] =
          set.map.find({at.x + n / 9 - 1, at.y + n / 3 % 3 - 1, at.z + n % 3 - 1});
    }
  }
}

// New values from old ones; `law(row, weight, moved)` fills the eight voxels of a row, in voxels.
template <typename Law>
void BandFlow::update(Law&& law) {
  const float band = static_cast<float>(set_.background / set_.voxel);
  const float voxel = static_cast<float>(set_.voxel);
  constexpr float full_weight[kSide] = {1, 1, 1, 1, 1, 1, 1, 1};
#pragma omp parallel for schedule(static)
  for (std::int64_t index = 0; index < set_.block_count(); ++index) {
    Halo halo;
    gather(set_, index, neighbours_[static_cast<std::size_t>(index)], halo);
    for (int row = 0; row < kBlock; row += kSide) {
      const float* here = &halo.phi[(row >> 6) + 1][(row >> 3 & 7) + 1][1];
      const std::size_t place = static_cast<std::size_t>(index * kBlock + row);
      float moved[kSide];
      law(here, set_.weights.empty() ? full_weight : &set_.weights[place], moved);
      for (int z = 0; z < kSide; ++z) {
        const float kept = std::min(std::max(moved[z], -band), band) * voxel;
        next_[place + static_cast<std::size_t>(z)] =
            std::abs(here[z]) >= band ? here[z] * voxel : kept;
      }
    }
  }
  set_.values.swap(next_);
}

void BandFlow::curvature_step() {
  update([](const float* row, const float* weight, float* moved) {
    for (int z = 0; z < kSide; ++z) {
      moved[z] = row[z] + weight[z] * (1.0f / 3.0f) * curvature_speed(row + z);
    }
  });
  redistance_step(0.3f);
}

void BandFlow::redistance_step(float courant) {
  update([courant](const float* row, const float*, float* moved) {
    for (int z = 0; z < kSide; ++z) moved[z] = redistanced(row + z, courant);
  });
}

}  // namespace vulnus::geometry
