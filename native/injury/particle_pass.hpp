// What the bundles of particles of a block do in a step, on a tile: gather, average the volume
// rate, move, strain, stress, scatter.
#pragma once

#include "core/fault.hpp"
#include "injury/mpm_solver.hpp"
#include "injury/stress_update.hpp"
#include "injury/transfer.hpp"
#include "injury/volume_averaging.hpp"

namespace vulnus::injury {

// The numbers that are the same for all particles of a pass.
template <class T>
struct PassNumbers {
  T cells_per_metre;
  T grid_spacing;
  T dt;       // of the step that ends: strains
  T travel;   // time for which the particles move
  T next_dt;  // of the step that begins: the impulse of the stress
  T dither;   // of the places' rounding, below half of their last digit
  T lower[3], upper[3];
  bool nodes_keep;  // their momentum in the step that begins: particles stay in their places
  bool look;        // particles also keep the motion of the step that ends
  bool rest;        // scatters motion that the nodes have not taken, without mass
};

// Velocity and its gradient.
template <class R>
struct Motion {
  R v[3];
  Matrix3<R> c;
};

// What the first phase of a pass leaves to the second: motion, volume rate and its weight of the
// bundles of one block. One a thread.
template <class T>
class GatheredBlock {
 public:
  using Real = typename LaneTraits<T>::Real;
  static constexpr int kWidth = LaneTraits<T>::kWidth;

  explicit GatheredBlock(int bundles)
      : motion_(std::size_t(bundles) * kMotion * kWidth),
        rate_(std::size_t(bundles) * kWidth),
        weight_(std::size_t(bundles) * kWidth) {}

  VULNUS_HD void put(int bundle, const Motion<Real>& m, Real weight) {
    Real* to = reinterpret_cast<Real*>(motion_.data()) + std::size_t(bundle) * kMotion;
    for (int i = 0; i < 3; ++i) {
      to[i] = m.v[i];
      for (int j = 0; j < 3; ++j) to[3 + 3 * i + j] = m.c.m[i][j];
    }
    reinterpret_cast<Real*>(rate_.data())[bundle] = m.c.m[0][0] + m.c.m[1][1] + m.c.m[2][2];
    reinterpret_cast<Real*>(weight_.data())[bundle] = weight;
  }
  VULNUS_HD void take(int bundle, Motion<Real>& m) const {
    const Real* from =
        reinterpret_cast<const Real*>(motion_.data()) + std::size_t(bundle) * kMotion;
    for (int i = 0; i < 3; ++i) {
      m.v[i] = from[i];
      for (int j = 0; j < 3; ++j) m.c.m[i][j] = from[3 + 3 * i + j];
    }
  }
  // What the averaging adds to each diagonal entry of a bundle's gradient.
  VULNUS_HD Real correction(int bundle) const {
    return reinterpret_cast<const Real*>(rate_.data())[bundle];
  }
  void average(const ParticleSet<T>& set, int block, int bundles) {
    const int begin = set.first_bundle(block) * kWidth;
    average_volume_rate(set.cell_ends(block), begin, begin + bundles * kWidth,
                        set.material.data() + begin, weight_.data(), rate_.data());
  }

 private:
  static constexpr int kMotion = 12;
  AlignedVector<T> motion_, rate_, weight_;
};

template <class T>
struct Bundle {
  using Real = typename LaneTraits<T>::Real;
  using Row = typename LaneTraits<T>::Row;
  using Integer = typename LaneTraits<T>::Integer;
  static constexpr int kWidth = LaneTraits<T>::kWidth;

  ParticleSet<T>& set;
  std::size_t first;
  Real x[3];
  Motion<Real> motion;
  PointState<Real> point;
  Real volume;
  Material<Real> material;

  VULNUS_HD Real load(int field) const {
    return *reinterpret_cast<const Real*>(set.field[field].data() + first);
  }
  VULNUS_HD void store(int field, Real value) {
    *reinterpret_cast<Real*>(set.field[field].data() + first) = value;
  }
  VULNUS_HD Symmetric3<Real> load_tensor(int f) const {
    return {load(f), load(f + 1), load(f + 2), load(f + 3), load(f + 4), load(f + 5)};
  }
  VULNUS_HD void store_tensor(int first_field, const Symmetric3<Real>& s) {
    const Real value[6] = {s.xx, s.yy, s.zz, s.xy, s.yz, s.zx};
    for (int a = 0; a < 6; ++a) store(first_field + a, value[a]);
  }

  VULNUS_HD Bundle(ParticleSet<T>& particles, std::size_t place, const MaterialTable<T>& materials)
      : set(particles), first(place) {
    for (int a = 0; a < 3; ++a) x[a] = load(kPosition + a);
    point.strain = load_tensor(kStrain);
    point.network = load_tensor(kNetworkStrain);
    point.plastic_strain = load(kPlasticStrain);
    point.opening = load(kOpening);
    point.damage = load(kDamage);
    volume = load(kVolume);
    Integer index{};
    for (int i = 0; i < kWidth; ++i) index[i] = set.material[first + i];
    material = look_up_material(materials, index);
  }

  VULNUS_HD void load_motion() {
    for (int a = 0; a < 3; ++a) motion.v[a] = load(kVelocity + a);
    for (int a = 0; a < 9; ++a) motion.c.m[a / 3][a % 3] = load(kGradient + a);
  }
  VULNUS_HD void store_motion() {
    for (int a = 0; a < 3; ++a) store(kVelocity + a, motion.v[a]);
    for (int a = 0; a < 9; ++a) store(kGradient + a, motion.c.m[a / 3][a % 3]);
  }
  VULNUS_HD void subtract_motion(const Motion<Real>& other) {
    for (int a = 0; a < 3; ++a) {
      motion.v[a] -= other.v[a];
      for (int j = 0; j < 3; ++j) motion.c.m[a][j] -= other.c.m[a][j];
    }
  }
  // What floats lose of x += v dt would be the same at every step, up to all of it; a dither that
  // differs from step to step makes it nothing in the mean. What stands stays where it is.
  VULNUS_HD void move(const PassNumbers<T>& n) {
    for (int a = 0; a < 3; ++a) {
      Real way = n.travel * motion.v[a];
      if constexpr (sizeof(T) == 4)
        way += select(way == Real{}, Real{}, n.dither * magnitude(x[a]));
      x[a] += way;
    }
  }
  VULNUS_HD void store_point() {
    for (int a = 0; a < 3; ++a) store(kPosition + a, x[a]);
    store_tensor(kStrain, point.strain);
    store_tensor(kNetworkStrain, point.network);
    store(kPlasticStrain, point.plastic_strain);
    store(kOpening, point.opening);
    store(kDamage, point.damage);
  }
};

// Rows of 16 values a particle to 16 lanes-of-particles a value, and back.
VULNUS_HD void rows_to_lanes(Float16 (&row)[16]) { transpose(row); }
VULNUS_HD void lanes_to_rows(Float16 (&lane)[16]) { transpose(lane); }

VULNUS_HD void rows_to_lanes(const Double16 (&row)[8], Double8 (&lane)[16]) {
  for (int v = 0; v < 16; ++v)
    for (int p = 0; p < 8; ++p) lane[v][p] = row[p][v];
}
VULNUS_HD void lanes_to_rows(const Double8 (&lane)[16], Double16 (&row)[8]) {
  for (int p = 0; p < 8; ++p)
    for (int v = 0; v < 16; ++v) row[p][v] = lane[v][p];
}

template <class T>
VULNUS_HD void gather_rows(const T* tile, const Stencil<T>& s,
                           typename LaneTraits<T>::Real (&value)[16]) {
  if constexpr (sizeof(T) == 4) {
    for (int p = 0; p < 16; ++p) value[p] = gather_moments(tile, s, p);
    rows_to_lanes(value);
  } else {
    typename LaneTraits<T>::Row row[LaneTraits<T>::kWidth] = {};
    for (int p = 0; p < LaneTraits<T>::kWidth; ++p) row[p] = gather_moments(tile, s, p);
    rows_to_lanes(row, value);
  }
}

template <class T>
VULNUS_HD void scatter_rows(T* tile, const Stencil<T>& s,
                            typename LaneTraits<T>::Real (&value)[16]) {
  if constexpr (sizeof(T) == 4) {
    lanes_to_rows(value);
    for (int p = 0; p < 16; ++p) scatter_affine(tile, s, p, value[p]);
  } else {
    typename LaneTraits<T>::Row row[LaneTraits<T>::kWidth] = {};
    lanes_to_rows(value, row);
    for (int p = 0; p < LaneTraits<T>::kWidth; ++p) scatter_affine(tile, s, p, row[p]);
  }
}

// v_p = sum w v_i and C_p = (4/dx^2) sum w v_i (x_i - x_p)^T (PHYSICS 1.4).
template <class T>
VULNUS_HD Motion<typename LaneTraits<T>::Real> gather_motion(const T* tile, const Stencil<T>& s,
                                                             const PassNumbers<T>& n) {
  typename LaneTraits<T>::Real value[16] = {};
  Motion<typename LaneTraits<T>::Real> motion;
  gather_rows(tile, s, value);
  const T factor = T(4) * n.cells_per_metre;
  for (int i = 0; i < 3; ++i) {
    motion.v[i] = value[1 + i];
    for (int j = 0; j < 3; ++j)
      motion.c.m[i][j] = factor * (value[5 + 4 * j + i] - s.fraction[j] * motion.v[i]);
  }
  return motion;
}

// The step's displacement gradient L; `correction` [1/s] is what the averaging of volume adds.
template <class T>
VULNUS_HD Matrix3<typename LaneTraits<T>::Real> increment_of_step(
    const Bundle<T>& b, typename LaneTraits<T>::Real correction, const PassNumbers<T>& n) {
  Matrix3<typename LaneTraits<T>::Real> l;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      l.m[i][j] = n.dt * (i == j ? b.motion.c.m[i][j] + correction : b.motion.c.m[i][j]);
  return l;
}

// Moves and strains the bundle; its stress, returned to the yield surface.
template <class T>
VULNUS_HD StressUpdate<typename LaneTraits<T>::Real> deform(
    Bundle<T>& b, const Matrix3<typename LaneTraits<T>::Real>& increment, const PassNumbers<T>& n) {
  b.move(n);
  b.point.strain = advance_strain(b.point.strain, increment);
  b.point.network = advance_strain(b.point.network, increment);
  return update_stress(b.material, equivalent_strain_rate(b.motion.c), b.point);
}

// (mv)_i = sum w (m v + A (x_i - x_p)) with A = m C - dt (4/dx^2) V0 tau (PHYSICS 1.4); without m
// where the nodes keep their momentum, but for the rest that they have not taken.
template <class T>
VULNUS_HD void scatter_momentum(const Bundle<T>& b, T* tile, const Stencil<T>& s,
                                const Symmetric3<typename LaneTraits<T>::Real>& kirchhoff,
                                const PassNumbers<T>& n) {
  using Real = typename LaneTraits<T>::Real;
  const Real mass = b.material.density * b.volume;
  const Real inertia = mass * n.grid_spacing;
  const Real impulse = b.volume * (T(-4) * n.next_dt * n.cells_per_metre);
  const auto& t = kirchhoff;
  const Real tau[3][3] = {{t.xx, t.xy, t.zx}, {t.xy, t.yy, t.yz}, {t.zx, t.yz, t.zz}};
  Real value[16] = {};
  const bool moving = !n.nodes_keep || n.rest;
  if (!n.nodes_keep) value[0] = mass;
  for (int i = 0; i < 3; ++i) {
    if (moving) value[1 + i] = mass * b.motion.v[i];
    for (int j = 0; j < 3; ++j) {
      Real affine = impulse * tau[i][j];
      if (moving) affine += inertia * b.motion.c.m[i][j];
      value[5 + 4 * j + i] = affine;
      value[1 + i] -= affine * s.fraction[j];
    }
  }
  scatter_rows(tile, s, value);
}

}  // namespace vulnus::injury
