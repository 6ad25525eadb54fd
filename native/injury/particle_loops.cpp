// Loops over particles: the passes of a step and the sums for tests and reports.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "injury/mpm_solver.hpp"
#include "injury/particle_pass.hpp"

namespace vulnus::injury {

namespace {

template <class T>
VULNUS_HD void cell_coordinates(const typename LaneTraits<T>::Real (&x)[3], const BlockIndex& block,
                                const PassNumbers<T>& n, typename LaneTraits<T>::Real (&cell)[3]) {
  const T corner[3] = {T(block.x * kBlockEdge - 1), T(block.y * kBlockEdge - 1),
                       T(block.z * kBlockEdge - 1)};
  for (int a = 0; a < 3; ++a) cell[a] = x[a] * n.cells_per_metre - corner[a];
}

template <class T>
VULNUS_HD typename LaneTraits<T>::Integer not_finite(typename LaneTraits<T>::Real value) {
  constexpr T limit = T(1e30);
  return ~((value < limit) & (value > -limit));
}

// Evenly spread over the steps between -1 and 1 halves of a float's last digit (golden ratio).
float dither_of_step(std::int64_t step) {
  const double turns = 0.6180339887498949 * static_cast<double>(step);
  return static_cast<float>((turns - std::floor(turns) - 0.5) * 0x1p-23);
}

// What may be wrong with the lanes of a bundle; a mask each.
template <class T>
struct Trouble {
  typename LaneTraits<T>::Integer bad{};
  typename LaneTraits<T>::Integer inverted{};
  typename LaneTraits<T>::Real stress{};
};

// Reports the particles of a bundle that are not finite, inverted, out of the domain, or further
// than a cell from where they were sorted.
template <class T>
[[gnu::cold, gnu::noinline]] void report(const Bundle<T>& b, const Trouble<T>& trouble,
                                         const PassNumbers<T>& n, FaultRecord& fault) {
  for (int i = 0; i < Bundle<T>::kWidth; ++i) {
    const std::int32_t id = b.set.id[b.first + i];
    if (id < 0 || !(trouble.bad[i] | trouble.inverted[i])) continue;
    std::uint32_t bits = trouble.inverted[i] ? kInvertedElement : kNoFault;
    bool finite = std::isfinite(trouble.stress[i]);
    for (int a = 0; a < 3; ++a) {
      finite = finite && std::isfinite(b.x[a][i]) && std::isfinite(b.motion.v[a][i]);
      if (b.x[a][i] < n.lower[a] || b.x[a][i] > n.upper[a]) bits |= kLeftDomain;
    }
    if (!finite) bits |= kNotFinite;
    fault.raise(bits == kNoFault ? kNeighbourOverflow : bits, id);
  }
}

// Trouble of a bundle that has moved: its place, its stress, and the volume of its step.
template <class T>
VULNUS_HD Trouble<T> trouble_of_step(const Bundle<T>& b, const Stencil<T>& stencil,
                                     const Symmetric3<typename LaneTraits<T>::Real>& kirchhoff,
                                     typename LaneTraits<T>::Real determinant,
                                     const PassNumbers<T>& n) {
  Trouble<T> t;
  t.stress = kirchhoff.xx + kirchhoff.yy + kirchhoff.zz;
  t.bad = stencil.outside | not_finite<T>(t.stress);
  for (int i = 0; i < 3; ++i) t.bad |= ~((b.x[i] >= n.lower[i]) & (b.x[i] <= n.upper[i]));
  t.inverted = ~(determinant > T(0));
  return t;
}

// Places the stencil of a bundle's positions.
template <class T>
VULNUS_HD void place(const typename LaneTraits<T>::Real (&x)[3], const BlockIndex& block,
                     const PassNumbers<T>& n, Stencil<T>& stencil) {
  typename LaneTraits<T>::Real cell[3];
  cell_coordinates<T>(x, block, n, cell);
  place_stencil(cell, stencil);
}

// Gathers the motion of one bundle from `around`, the tile of nodes of its block.
template <class T>
VULNUS_HD void gather_bundle(const ParticleSet<T>& set, const MaterialTable<T>& materials,
                             std::size_t first, const BlockIndex& block, const T* around,
                             const PassNumbers<T>& n, int bundle, GatheredBlock<T>& gathered) {
  using Real = typename LaneTraits<T>::Real;
  auto load = [&](int field) {
    return *reinterpret_cast<const Real*>(set.field[field].data() + first);
  };
  const Real x[3] = {load(kPosition), load(kPosition + 1), load(kPosition + 2)};
  typename LaneTraits<T>::Integer index{};
  for (int i = 0; i < LaneTraits<T>::kWidth; ++i) index[i] = set.material[first + i];
  const Real weight = load(kVolume) * look_up(materials.column[kVolumeAveraging], index);
  Stencil<T> stencil;
  place(x, block, n, stencil);
  gathered.put(bundle, gather_motion(around, stencil, n), weight);
}

// Strains one bundle with what it has gathered, or (at an epoch's beginning) takes it as it is;
// then scatters it to `tile`, or (at an epoch's end) stores its motion. Returns the squared sound
// speeds. Lanes without a particle (volume 0) strain as no cell's mean tells them: whatever becomes
// of them, they give nodes and time step nothing.
template <bool Gather, bool Scatter, class T>
VULNUS_HD typename LaneTraits<T>::Real step_bundle(Bundle<T>& b, const BlockIndex& block,
                                                   int bundle, const GatheredBlock<T>& gathered,
                                                   T* tile, const PassNumbers<T>& n,
                                                   FaultRecord& fault) {
  Stencil<T> stencil;
  StressUpdate<typename LaneTraits<T>::Real> stress{};
  Trouble<T> trouble;
  if constexpr (Gather) {
    gathered.take(bundle, b.motion);
    const auto increment = increment_of_step(b, gathered.correction(bundle), n);
    stress = deform(b, increment, n);
    b.store_point();
    place(b.x, block, n, stencil);
    trouble = trouble_of_step(b, stencil, stress.kirchhoff, determinant_of_step(increment), n);
  } else {
    b.load_motion();
    b.move(n);
    b.store_point();
    place(b.x, block, n, stencil);
    stress.kirchhoff = resting_kirchhoff(b.material, b.point);
    const auto& v = b.motion.v;
    trouble.stress = stress.kirchhoff.xx + stress.kirchhoff.yy + stress.kirchhoff.zz;
    trouble.bad = stencil.outside | not_finite<T>(trouble.stress + v[0] + v[1] + v[2]);
  }
  const auto real = b.volume > typename LaneTraits<T>::Real{};
  if (any(trouble.bad | trouble.inverted)) {
    report(b, trouble, n, fault);
    stress.kirchhoff = choose(real, stress.kirchhoff, Symmetric3<typename LaneTraits<T>::Real>{});
  }
  if constexpr (Scatter) scatter_momentum(b, tile, stencil, stress.kirchhoff, n);
  if (!Scatter || n.look) b.store_motion();
  return select(real, stress.sound_speed_squared, typename LaneTraits<T>::Real{});
}

// The two phases of one block. Returns the squared sound speeds.
template <bool Gather, bool Scatter, class T>
typename LaneTraits<T>::Real step_block(ParticleSet<T>& set, const MaterialTable<T>& materials,
                                        int i, const BlockIndex& block, const T* around, T* tile,
                                        const PassNumbers<T>& n, GatheredBlock<T>& gathered,
                                        FaultRecord& fault) {
  const int first = set.first_bundle(i);
  const int bundles = set.first_bundle(i + 1) - first;
  auto place_of = [&](int bundle) { return std::size_t(first + bundle) * Bundle<T>::kWidth; };
  if constexpr (Gather) {
    for (int k = 0; k < bundles; ++k)
      gather_bundle(set, materials, place_of(k), block, around, n, k, gathered);
    gathered.average(set, i, bundles);
  }
  typename LaneTraits<T>::Real fastest{};
  for (int k = 0; k < bundles; ++k) {
    Bundle<T> b(set, place_of(k), materials);
    // In this order a speed that is not a number leaves the others as they are.
    fastest = maximum(step_bundle<Gather, Scatter>(b, block, k, gathered, tile, n, fault), fastest);
  }
  return fastest;
}

}  // namespace

template <class T>
template <bool Gather, bool Scatter>
void MpmSolver<T>::particle_pass(PassTimes times) {
  using Real = typename LaneTraits<T>::Real;
  PassNumbers<T> n{T(1 / settings_.grid_spacing),
                   T(settings_.grid_spacing),
                   T(times.step),
                   T(times.travel),
                   T(times.next_step),
                   T(dither_of_step(steps_)),
                   {},
                   {},
                   nodes_keep_,
                   looking_ || (!nodes_keep_ && sharpens()),
                   false};
  for (int a = 0; a < 3; ++a) {
    n.lower[a] = T(settings_.domain_lower[a]);
    n.upper[a] = T(settings_.domain_upper[a]);
  }
  T fastest = 0;
#pragma omp parallel reduction(max : fastest)
  {
    AlignedVector<T> around(kTileValues);
    std::memset(around.data(), 0, kTileValues * sizeof(T));
    GatheredBlock<T> gathered(Gather ? particles_.largest_block() : 0);
    Real fastest_lane{};
#pragma omp for schedule(dynamic, 4)
    for (int i = 0; i < grid_.occupied(); ++i) {
      if constexpr (Gather) grid_.load_tile(i, around.data());
      if constexpr (Scatter) std::memset(grid_.tile(i), 0, kTileValues * sizeof(T));
      fastest_lane =
          maximum(step_block<Gather, Scatter>(particles_, materials_, i, grid_.block(i),
                                              around.data(), grid_.tile(i), n, gathered, fault_),
                  fastest_lane);
    }
    for (int lane = 0; lane < Bundle<T>::kWidth; ++lane)
      fastest = std::max(fastest, fastest_lane[lane]);
  }
  if (Gather) sound_speed_ = std::sqrt(double(fastest));
}

// The second half of a passage: what the nodes have not taken of the particles' motion, and the
// impulses of the stress.
template <class T>
void MpmSolver<T>::scatter_rest(double next_step) {
  PassNumbers<T> n{};
  n.cells_per_metre = T(1 / settings_.grid_spacing);
  n.grid_spacing = T(settings_.grid_spacing);
  n.next_dt = T(next_step);
  n.nodes_keep = n.rest = true;
#pragma omp parallel
  {
    AlignedVector<T> around(kTileValues);
    std::memset(around.data(), 0, kTileValues * sizeof(T));
#pragma omp for schedule(dynamic, 4)
    for (int i = 0; i < grid_.occupied(); ++i) {
      grid_.load_tile(i, around.data());
      std::memset(grid_.tile(i), 0, kTileValues * sizeof(T));
      for (int k = particles_.first_bundle(i); k < particles_.first_bundle(i + 1); ++k) {
        Bundle<T> b(particles_, std::size_t(k) * Bundle<T>::kWidth, materials_);
        b.load_motion();
        Stencil<T> stencil;
        place(b.x, grid_.block(i), n, stencil);
        b.subtract_motion(gather_motion(around.data(), stencil, n));
        scatter_momentum(b, grid_.tile(i), stencil, resting_kirchhoff(b.material, b.point), n);
      }
    }
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

template void MpmSolver<float>::scatter_rest(double);
template void MpmSolver<double>::scatter_rest(double);
template void MpmSolver<float>::particle_pass<false, true>(PassTimes);
template void MpmSolver<float>::particle_pass<true, false>(PassTimes);
template void MpmSolver<float>::particle_pass<true, true>(PassTimes);
template void MpmSolver<double>::particle_pass<false, true>(PassTimes);
template void MpmSolver<double>::particle_pass<true, false>(PassTimes);
template void MpmSolver<double>::particle_pass<true, true>(PassTimes);
template Totals MpmSolver<float>::particle_totals() const;
template Totals MpmSolver<double>::particle_totals() const;
template Totals MpmSolver<float>::grid_totals() const;
template Totals MpmSolver<double>::grid_totals() const;

}  // namespace vulnus::injury
