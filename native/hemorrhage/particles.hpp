// Blood and barrier particles as structures of arrays, relative to a local origin.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace vulnus::hemorrhage {

template <class Real>
struct Particles {
  // What cannot be derived. `residue` is what rounding took from the position, so that slow creep
  // adds up; `built` is the position at the last neighbour search; `weight` is the mass over a
  // whole particle's, below 1 while a newcomer swells.
  std::vector<Real> x, y, z, residue_x, residue_y, residue_z, vx, vy, vz, weight;
  std::vector<Real> built_x, built_y, built_z, density, pressure;
  std::vector<std::int32_t> id;
  std::vector<std::uint8_t> in_limb;
  // Derived each step or at each neighbour search.
  std::vector<Real> inverse_density, ax, ay, az;
  std::vector<Real> place, motion;  // x y z weight, vx vy vz p/rho^2 of each, side by side
  std::vector<Real> porosity, drag, clearance;

  std::size_t size() const { return x.size(); }

  // Square of the way since the last neighbour search.
  Real moved_squared(std::size_t i) const {
    const Real dx = x[i] - built_x[i], dy = y[i] - built_y[i], dz = z[i] - built_z[i];
    return dx * dx + dy * dy + dz * dz;
  }

  template <class Visit>
  void each_kept(Visit&& visit) {
    for (auto* a : {&x, &y, &z, &residue_x, &residue_y, &residue_z, &vx, &vy, &vz, &weight,
                    &built_x, &built_y, &built_z, &density, &pressure}) {
      visit(*a);
    }
    visit(id);
    visit(in_limb);
  }

  void resize_derived() {
    for (auto* a : {&inverse_density, &ax, &ay, &az, &porosity, &drag, &clearance}) {
      a->resize(size());
    }
    place.resize(4 * size());
    motion.resize(4 * size());
  }

  void pack(std::size_t i) {
    place[4 * i] = x[i], place[4 * i + 1] = y[i], place[4 * i + 2] = z[i];
    place[4 * i + 3] = weight[i];
    motion[4 * i] = vx[i], motion[4 * i + 1] = vy[i], motion[4 * i + 2] = vz[i];
  }
  void pack_all() {
    for (std::size_t i = 0; i < size(); ++i) pack(i);
  }

  void append(Real px, Real py, Real pz, Real ux, Real uy, Real uz, Real share, std::int32_t name) {
    each_kept([](auto& a) { a.push_back({}); });
    const std::size_t i = size() - 1;
    x[i] = px, y[i] = py, z[i] = pz;
    vx[i] = ux, vy[i] = uy, vz[i] = uz;
    weight[i] = share;
    id[i] = name;
    in_limb[i] = 1;
  }

  // Puts particle order[i] into place i; fewer entries than particles drop the rest.
  void permute(const std::vector<std::int32_t>& order) {
    each_kept([&order](auto& a) {
      std::remove_reference_t<decltype(a)> sorted(order.size());
      for (std::size_t i = 0; i < order.size(); ++i) sorted[i] = a[order[i]];
      a.swap(sorted);
    });
    resize_derived();
  }

  std::size_t memory_bytes() {
    std::size_t bytes = 0;
    each_kept([&bytes](auto& a) { bytes += a.capacity() * sizeof(a[0]); });
    return bytes + 15 * inverse_density.capacity() * sizeof(Real);
  }
};

// Stationary particles of skin, bone, platform or a tank's walls; `weight` is rho0 V_b over a blood
// particle's mass.
template <class Real>
struct BarrierParticles {
  std::vector<Real> x, y, z, weight;
  std::vector<Real> pressure;  // kept from step to step
  // x y z weight, and mirrored vx vy vz p/rho^2, side by side; motion and density are derived each
  // step where blood is near.
  std::vector<Real> place, motion, inverse_density;
  std::vector<std::int32_t> cell;
  std::size_t size() const { return x.size(); }
};

}  // namespace vulnus::hemorrhage
