// The sums of one step: density and pressure of blood, what barriers answer, forces.
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "hemorrhage/candidate_fetch.hpp"
#include "hemorrhage/equation_of_state.hpp"
#include "hemorrhage/forces.hpp"
#include "hemorrhage/wcsph_solver.hpp"

namespace vulnus::hemorrhage {
namespace {

constexpr std::size_t kRange = 512;  // particles that one thread integrates at a time
// Least density over the rest density: enough to divide by where pressure is clamped; where it is
// not, the tension at which blood parts (5 % of rho0 c0^2), else lone particles would draw each
// other in without limit. Chosen.
constexpr double kDensityFloor = 0.05, kPartingDensity = 0.95;
constexpr double kWallAnswer = 100.0;  // walls follow the pressure within this many h/c0; chosen

}  // namespace

template <class Real>
void WcsphSolver<Real>::fetch_blood(const CellBatch& batch, std::int32_t cell,
                                    CandidateBuffer<Real>& b, std::size_t n,
                                    bool with_motion) const {
  const std::uint32_t* list = batch.blood.data() + batch.blood_start[cell - batch.first_cell];
  fetch_quads(particles.place.data(), list, n, b.x, b.y, b.z, b.weight);
  shift_images(periodicity, list, n, b.x, b.y, b.z);
  if (with_motion) {
    fetch_quads(particles.motion.data(), list, n, b.vx, b.vy, b.vz, b.p_over_rho2);
    fetch_single(particles.inverse_density.data(), list, n, b.inverse_density);
  }
  b.pad(n);
}

template <class Real>
void WcsphSolver<Real>::fetch_barrier(const CellBatch& batch, std::int32_t cell,
                                      CandidateBuffer<Real>& buffer, std::size_t offset,
                                      std::size_t n, bool with_motion) const {
  CandidateBuffer<Real> b = buffer.from(offset);
  const std::uint32_t* list = batch.barrier.data() + batch.barrier_start[cell - batch.first_cell];
  fetch_quads(barrier_.place.data(), list, n, b.x, b.y, b.z, b.weight);
  shift_images(periodicity, list, n, b.x, b.y, b.z);
  if (with_motion) {
    fetch_quads(barrier_.motion.data(), list, n, b.vx, b.vy, b.vz, b.p_over_rho2);
    fetch_single(barrier_.inverse_density.data(), list, n, b.inverse_density);
  }
  b.pad(n);
}

template <class Real>
void WcsphSolver<Real>::density_of(std::int32_t i, Real sum, Real own_share, Real factor) {
  if (settings.as_printed) sum -= density_share(particles.weight[i], own_share);
  const Real rest = Real(settings.rest_density);
  const Real least = Real(settings.clamped ? kDensityFloor : kPartingDensity) * rest;
  const Real rho = std::max(sum * factor, least);
  const Real c2 = Real(settings.sound_speed * settings.sound_speed);
  Real p = pressure_linear(rho, rest, c2);
  if (settings.clamped) p = pressure_clamped(p);
  particles.density[i] = rho;
  particles.pressure[i] = p;
  particles.inverse_density[i] = Real(1) / rho;
  particles.motion[4 * std::size_t(i) + 3] =
      p * particles.inverse_density[i] * particles.inverse_density[i];
}

template <class Real>
template <class Kernels>
void WcsphSolver<Real>::density_pass(const Kernels& kernels, const CellBatch& batch,
                                     CandidateBuffer<Real>& buffer) {
  const double mass = settings.density * source.particle_volume;
  const Real factor = Real(mass * settings.density_scale) * kernels.density_factor;
  const Real own_share = kernels.density(Real(0));
  for (std::int32_t c = batch.first_cell; c < batch.last_cell; ++c) {
    const std::int32_t k = c - batch.first_cell;
    const std::size_t blood = batch.blood_start[k + 1] - batch.blood_start[k];
    const std::size_t walls = batch.barrier_start[k + 1] - batch.barrier_start[k];
    const std::size_t total = padded(blood) + padded(walls);
    buffer.reserve(total);
    fetch_blood(batch, c, buffer, blood, false);
    if (walls > 0) fetch_barrier(batch, c, buffer, padded(blood), walls, false);
    for (std::int32_t i = order_.cell_start(c); i < order_.cell_start(c + 1); ++i) {
      const Real sum =
          density_sum(kernels, buffer, total, particles.x[i], particles.y[i], particles.z[i]);
      density_of(i, sum, own_share, factor);
    }
  }
}

template <class Real>
void WcsphSolver<Real>::acceleration_of(std::int32_t i, const PairForces<Real>& f, Real push,
                                        Real drag) {
  if (settings.as_printed) push *= particles.porosity[i];
  drag *= particles.inverse_density[i];
  particles.ax[i] =
      navier_stokes_acceleration(push * f.pressure_x, drag * f.viscous_x, Real(gravity[0]));
  particles.ay[i] =
      navier_stokes_acceleration(push * f.pressure_y, drag * f.viscous_y, Real(gravity[1]));
  particles.az[i] =
      navier_stokes_acceleration(push * f.pressure_z, drag * f.viscous_z, Real(gravity[2]));
}

template <class Real>
PairConstants<Real> WcsphSolver<Real>::pair_constants() const {
  const double h = settings.smoothing;
  return {Real(1e-12 * h * h),
          Real(settings.dissipation),
          Real(settings.sound_speed),
          Real(settings.density),
          Real(1.0 / settings.density),
          Real(gravity[0]),
          Real(gravity[1]),
          Real(gravity[2])};
}

// Pressure and density of the barrier's particles that blood is near.
template <class Real>
template <class Kernels>
void WcsphSolver<Real>::barrier_pass(const Kernels& kernels, const CellBatch& wet, Real share,
                                     CandidateBuffer<Real>& buffer) {
  const PairConstants<Real> constants = pair_constants();
  for (std::int32_t place = wet.first_cell; place < wet.last_cell; ++place) {
    const std::int32_t k = place - wet.first_cell;
    const std::int32_t c = neighbours_.wet_cell(place);
    const std::size_t n = wet.blood_start[k + 1] - wet.blood_start[k];
    buffer.reserve(n);
    fetch_blood(wet, place, buffer, n, true);
    fetch_single(particles.pressure.data(), wet.blood.data() + wet.blood_start[k], n,
                 buffer.p_over_rho2);
    for (std::int32_t b = barrier_order_.cell_start(c); b < barrier_order_.cell_start(c + 1); ++b) {
      const MirrorSums<Real> sums = mirror_sums(kernels, buffer, padded(n), barrier_.x[b],
                                                barrier_.y[b], barrier_.z[b], constants);
      mirror_at(b, sums, share);
    }
  }
}

// Instant mirroring would pump energy into blood at rest (it answers each squeeze with more
// pressure); a wall that follows over many acoustic times does not.
template <class Real>
void WcsphSolver<Real>::mirror_at(std::int32_t b, const MirrorSums<Real>& sums, Real share) {
  const Real inverse = sums.weight > Real(0) ? Real(1) / sums.weight : Real(0);
  const Real target = pressure_clamped(sums.pressure * inverse);
  const Real p = barrier_.pressure[b] + share * (target - barrier_.pressure[b]);
  const Real k2 = Real(settings.sound_speed * settings.sound_speed);
  const Real rho = Real(settings.rest_density) + p / k2;
  barrier_.pressure[b] = p;
  barrier_.inverse_density[b] = Real(1) / rho;
  const Real values[4] = {-sums.vx * inverse, -sums.vy * inverse, -sums.vz * inverse,
                          p / (rho * rho)};
  std::copy(values, values + 4, barrier_.motion.begin() + 4 * static_cast<std::ptrdiff_t>(b));
}

template <class Real>
template <class Kernels>
void WcsphSolver<Real>::force_pass(const Kernels& kernels, const CellBatch& batch,
                                   CandidateBuffer<Real>& buffer) {
  const Particles<Real>& p = particles;
  const double mass = settings.density * source.particle_volume;
  const Real push = Real(mass * settings.gradient_scale) * kernels.gradient_factor;
  const Real drag =
      Real(settings.viscosity * mass * settings.laplacian_scale) * kernels.laplacian_factor;
  const PairConstants<Real> constants = pair_constants();
  for (std::int32_t c = batch.first_cell; c < batch.last_cell; ++c) {
    const std::int32_t k = c - batch.first_cell;
    const std::size_t blood = batch.blood_start[k + 1] - batch.blood_start[k];
    const std::size_t walls = batch.barrier_start[k + 1] - batch.barrier_start[k];
    buffer.reserve(padded(blood) + padded(walls));
    fetch_blood(batch, c, buffer, blood, true);
    if (walls > 0) fetch_barrier(batch, c, buffer, padded(blood), walls, true);
    const CandidateBuffer<Real> wall_part = buffer.from(padded(blood));
    for (std::int32_t i = order_.cell_start(c); i < order_.cell_start(c + 1); ++i) {
      const Probe<Real> probe{p.x[i],
                              p.y[i],
                              p.z[i],
                              p.vx[i],
                              p.vy[i],
                              p.vz[i],
                              p.motion[4 * std::size_t(i) + 3],
                              p.inverse_density[i]};
      PairForces<Real> forces;
      blood_forces(kernels, buffer, padded(blood), probe, constants, forces);
      if (walls > 0) {
        barrier_forces(kernels, wall_part, padded(walls), probe, constants, forces);
      }
      acceleration_of(i, forces, push, drag);
    }
  }
}

template <class Real>
void WcsphSolver<Real>::sums(double dt, bool integrate) {
  if (settings.kernels == KernelSet::kMueller2003) {
    sums(mueller_, dt, integrate);
  } else {
    sums(wendland_, dt, integrate);
  }
}

template <class Real>
template <class Kernels>
void WcsphSolver<Real>::sums(const Kernels& kernels, double dt, bool integrate) {
  const int team = useful_threads();
  if (static_cast<int>(buffers_.size()) < team) buffers_.resize(static_cast<std::size_t>(team));
  const auto batches = static_cast<std::int64_t>(neighbours_.batch_count());
  const auto wet_batches = static_cast<std::int64_t>(neighbours_.wet_batch_count());
  const std::size_t n = particles.size();
  const auto ranges = static_cast<std::int64_t>((n + kRange - 1) / kRange);
  const double answer = kWallAnswer * settings.smoothing / settings.sound_speed;
  const Real share = integrate ? Real(std::min(1.0, dt / answer)) : Real(1);
  std::vector<Largest> parts(static_cast<std::size_t>(ranges));
#pragma omp parallel num_threads(team) if (team > 1)
  {
    CandidateBuffer<Real>& buffer = buffers_[static_cast<std::size_t>(omp_get_thread_num())];
#pragma omp for schedule(dynamic, 1)
    for (std::int64_t b = 0; b < batches; ++b)
      density_pass(kernels, neighbours_.batches()[b], buffer);
#pragma omp for schedule(dynamic, 1)
    for (std::int64_t b = 0; b < wet_batches; ++b)
      barrier_pass(kernels, neighbours_.wet_batches()[b], share, buffer);
#pragma omp for schedule(dynamic, 1)
    for (std::int64_t b = 0; b < batches; ++b)
      force_pass(kernels, neighbours_.batches()[b], buffer);
    if (integrate) {
#pragma omp for schedule(static)
      for (std::int64_t r = 0; r < ranges; ++r) {
        const std::size_t first = static_cast<std::size_t>(r) * kRange;
        integrate_range(first, std::min(n, first + kRange), Real(dt), parts[r]);
      }
    }
  }
  if (integrate) merge(parts);
}

template class WcsphSolver<float>;
template class WcsphSolver<double>;

}  // namespace vulnus::hemorrhage
