// Loops over particles and tracers: the passes of a step and the sums for tests and reports.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "injury/mpm_solver.hpp"
#include "injury/particle_pass.hpp"

namespace vulnus::injury {

namespace {

template <class T>
void cell_coordinates(const Bundle<T>& b, const BlockIndex& block, const PassNumbers<T>& n,
                      typename LaneTraits<T>::Real (&cell)[3]) {
  const T corner[3] = {T(block.x * kBlockEdge - 1), T(block.y * kBlockEdge - 1),
                       T(block.z * kBlockEdge - 1)};
  for (int a = 0; a < 3; ++a) cell[a] = b.x[a] * n.cells_per_metre - corner[a];
}

// Reports the particles of a bundle that are not finite, inverted or out of the domain.
template <class T>
void report(const Bundle<T>& b, typename LaneTraits<T>::Integer bad,
            typename LaneTraits<T>::Integer inverted, const PassNumbers<T>& n, FaultRecord& fault) {
  for (int i = 0; i < Bundle<T>::kWidth; ++i) {
    const std::int32_t id = b.set.id[b.first + i];
    if (id < 0 || !(bad[i] | inverted[i])) continue;
    std::uint32_t bits = inverted[i] ? kInvertedElement : kNoFault;
    for (int a = 0; a < 3; ++a) {
      if (!std::isfinite(b.x[a][i]) || !std::isfinite(b.v[a][i])) bits |= kNotFinite;
      if (b.x[a][i] < n.lower[a] || b.x[a][i] > n.upper[a]) bits |= kLeftDomain;
    }
    fault.raise(bits == kNoFault ? kNotFinite : bits, id);
  }
}

}  // namespace

template <class T>
template <bool Gather, bool Scatter>
void MpmSolver<T>::particle_pass(double dt, double next_dt) {
  using Real = typename LaneTraits<T>::Real;
  using Integer = typename LaneTraits<T>::Integer;
  PassNumbers<T> n{
      T(1 / settings_.grid_spacing), T(settings_.grid_spacing), T(dt), T(next_dt), {}, {}};
  for (int a = 0; a < 3; ++a) {
    n.lower[a] = T(settings_.domain_lower[a]);
    n.upper[a] = T(settings_.domain_upper[a]);
  }
  T fastest = 0;
#pragma omp parallel reduction(max : fastest)
  {
    AlignedVector<T> around(kTileValues);
    std::memset(around.data(), 0, kTileValues * sizeof(T));
    Real fastest_lane{};
#pragma omp for schedule(dynamic, 4)
    for (int i = 0; i < grid_.occupied(); ++i) {
      if constexpr (Gather) grid_.load_tile(i, around.data());
      T* tile = grid_.tile(i);
      if constexpr (Scatter) std::memset(tile, 0, kTileValues * sizeof(T));
      const BlockIndex block = grid_.block(i);
      const int last = particles_.first_bundle(i + 1);
      for (int bundle = particles_.first_bundle(i); bundle < last; ++bundle) {
        Bundle<T> b(particles_, std::size_t(bundle) * Bundle<T>::kWidth, materials_);
        Stencil<T> stencil;
        Real cell[3];
        cell_coordinates(b, block, n, cell);
        place_stencil(cell, stencil);
        Symmetric3<Real> kirchhoff;
        if constexpr (Gather) {
          gather_velocity(b, around.data(), stencil, n);
          const auto stress = deform(b, n);
          kirchhoff = stress.kirchhoff;
          fastest_lane = maximum(fastest_lane, stress.sound_speed_squared);
          b.store_point();
          cell_coordinates(b, block, n, cell);
          place_stencil(cell, stencil);
          Integer bad = stencil.outside;
          for (int a = 0; a < 3; ++a) bad |= ~((b.x[a] >= n.lower[a]) & (b.x[a] <= n.upper[a]));
          Matrix3<Real> increment;
          for (int r = 0; r < 9; ++r) increment.m[r / 3][r % 3] = n.dt * b.c.m[r / 3][r % 3];
          const Integer inverted = ~(determinant_of_step(increment) > T(0));
          if (any(bad | inverted)) report(b, bad, inverted, n, fault_);
        } else {
          b.load_velocity();
          kirchhoff = elastic_kirchhoff(b.material, b.point.strain);
          if (any(stencil.outside)) report(b, stencil.outside, Integer{}, n, fault_);
        }
        if constexpr (Scatter)
          scatter_momentum(b, tile, stencil, kirchhoff, n);
        else
          b.store_velocity();
      }
    }
    for (int lane = 0; lane < Bundle<T>::kWidth; ++lane)
      fastest = std::max(fastest, fastest_lane[lane]);
  }
  if (Gather) sound_speed_ = std::sqrt(double(fastest));
}

// Tracers move with the velocity that the nodes around them have.
template <class T>
void MpmSolver<T>::move_tracers(double dt) {
  const double dx = settings_.grid_spacing;
  const Sphere& sphere = settings_.sphere;
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < tracers_.size(); ++p) {
    Tracer& tracer = tracers_[p];
    std::int32_t base[3];
    double weight[3][3], velocity[3] = {0, 0, 0}, apart = 0;
    for (int a = 0; a < 3; ++a) {
      const double cell = tracer.position[a] / dx;
      base[a] = static_cast<std::int32_t>(std::floor(cell - 0.5));
      quadratic_weights(cell - base[a], weight[a]);
    }
    for (int n = 0; n < 27; ++n) {
      const std::int32_t x = base[0] + n / 9, y = base[1] + n / 3 % 3, z = base[2] + n % 3;
      const int block = grid_.find(morton_key({x >> 2, y >> 2, z >> 2}));
      if (block < 0) continue;
      const T* value = grid_.nodes(block) + ((x & 3) << 4 | (y & 3) << 2 | (z & 3)) * kComponents;
      const double w = weight[0][n / 9] * weight[1][n / 3 % 3] * weight[2][n % 3];
      for (int a = 0; a < 3; ++a) velocity[a] += w * value[1 + a];
    }
    for (int a = 0; a < 3; ++a) {
      tracer.position[a] += dt * velocity[a];
      const double d = tracer.position[a] - sphere.centre[a] - sphere.velocity[a] * (time_ + dt);
      apart += d * d;
    }
    tracer.smallest_gap = std::min(tracer.smallest_gap, std::sqrt(apart) - sphere.radius);
  }
}

template <class T>
Totals MpmSolver<T>::particle_totals() const {
  Totals sum{};
  const double d = 0.25 * settings_.grid_spacing * settings_.grid_spacing;  // APIC's D_p
  for (int p = 0; p < particles_.places(); ++p) {
    auto get = [&](int f) { return double(particles_.field[f][p]); };
    const double m = get(kVolume) * materials_.column[kDensity][particles_.material[p]];
    double x[3], v[3];
    for (int a = 0; a < 3; ++a) {
      x[a] = get(kPosition + a);
      v[a] = get(kVelocity + a);
      sum.momentum[a] += m * v[a];
      sum.kinetic_energy += 0.5 * m * v[a] * v[a];
    }
    sum.mass += m;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      const double spin = d * (get(kGradient + 3 * c + b) - get(kGradient + 3 * b + c));
      sum.angular_momentum[a] += m * (x[b] * v[c] - x[c] * v[b] + spin);
    }
  }
  return sum;
}

template <class T>
Totals MpmSolver<T>::grid_totals() const {
  Totals sum{};
  const double dx = settings_.grid_spacing;
  for (int i = 0; i < grid_.active(); ++i)
    for (int n = 0; n < kBlockNodes; ++n) {
      const T* value = grid_.nodes(i) + n * kComponents;
      const BlockIndex b = grid_.block(i);
      const double x[3] = {(b.x * 4 + (n >> 4)) * dx, (b.y * 4 + (n >> 2 & 3)) * dx,
                           (b.z * 4 + (n & 3)) * dx};
      sum.mass += value[0];
      for (int a = 0; a < 3; ++a) {
        const int j = (a + 1) % 3, k = (a + 2) % 3;
        sum.momentum[a] += value[1 + a];
        sum.angular_momentum[a] += x[j] * value[1 + k] - x[k] * value[1 + j];
        if (value[0] > T(0))
          sum.kinetic_energy += 0.5 * double(value[1 + a]) * value[1 + a] / value[0];
      }
    }
  return sum;
}

template void MpmSolver<float>::particle_pass<false, true>(double, double);
template void MpmSolver<float>::particle_pass<true, false>(double, double);
template void MpmSolver<float>::particle_pass<true, true>(double, double);
template void MpmSolver<double>::particle_pass<false, true>(double, double);
template void MpmSolver<double>::particle_pass<true, false>(double, double);
template void MpmSolver<double>::particle_pass<true, true>(double, double);
template void MpmSolver<float>::move_tracers(double);
template void MpmSolver<double>::move_tracers(double);
template Totals MpmSolver<float>::particle_totals() const;
template Totals MpmSolver<double>::particle_totals() const;
template Totals MpmSolver<float>::grid_totals() const;
template Totals MpmSolver<double>::grid_totals() const;

}  // namespace vulnus::injury
