#include "hemorrhage/wcsph_solver.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "hemorrhage/equation_of_state.hpp"
#include "hemorrhage/forces.hpp"
#include "hemorrhage/porous.hpp"

namespace vulnus::hemorrhage {
namespace {

constexpr std::size_t kRange = 512;               // particles that one thread integrates at a time
constexpr std::size_t kParticlesPerThread = 384;  // fewer are not worth another thread
constexpr double kForceLimit = 0.25;              // dt <= 0.25 sqrt(h/|a|) (Monaghan 1992)
constexpr double kViscousLimit = 0.125;           // dt <= 0.125 h^2/nu (Morris 1997)
constexpr double kSpeedLimit = 4.0;               // over c0; faster is a fault
constexpr double kSwelling = 10.0;                // newcomers swell within 10 h/c0; chosen
constexpr double kDensityFloor = 0.05;            // of rest density, where a lone particle has none
constexpr double kWallAnswer = 100.0;  // walls follow the pressure within this many h/c0; chosen
constexpr double kWallSlack = 0.3;     // margin of the wall check over h

}  // namespace

template <class Real>
WcsphSolver<Real>::WcsphSolver(const FluidSettings& s)
    : settings(s), mueller_(s.smoothing), wendland_(s.smoothing), buffers_(1) {
  source.particle_volume = s.spacing * s.spacing * s.spacing;
  source.spacing = s.spacing;
  source.smoothing = s.smoothing;
}

template <class Real>
int WcsphSolver<Real>::useful_threads() const {
  const auto worth = static_cast<int>(particles.size() / kParticlesPerThread);
  return std::max(1, std::min(threads, worth));
}

template <class Real>
void WcsphSolver<Real>::fetch_blood(const CellBatch& batch, std::int32_t cell,
                                    CandidateBuffer<Real>& b, std::size_t n,
                                    bool with_motion) const {
  const Particles<Real>& p = particles;
  const std::uint32_t* list = batch.blood.data() + batch.blood_start[cell - batch.first_cell];
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t j = list[k] & kIndexMask;
    b.x[k] = p.x[j], b.y[k] = p.y[j], b.z[k] = p.z[j];
    b.weight[k] = p.weight[j];
  }
  if (periodicity.any()) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::array<Real, 3> shift = periodicity.shift(list[k] >> kImageShift);
      b.x[k] += shift[0], b.y[k] += shift[1], b.z[k] += shift[2];
    }
  }
  if (with_motion) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t j = list[k] & kIndexMask;
      b.vx[k] = p.vx[j], b.vy[k] = p.vy[j], b.vz[k] = p.vz[j];
      b.p_over_rho2[k] = p.p_over_rho2[j];
      b.inverse_density[k] = p.inverse_density[j];
    }
  }
  b.pad(n);
}

template <class Real>
void WcsphSolver<Real>::fetch_barrier(const CellBatch& batch, std::int32_t cell,
                                      CandidateBuffer<Real>& b, std::size_t offset,
                                      std::size_t n) const {
  CandidateBuffer<Real> part = b.from(offset);
  const std::uint32_t* list = batch.barrier.data() + batch.barrier_start[cell - batch.first_cell];
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t j = list[k] & kIndexMask;
    const std::array<Real, 3> shift = periodicity.shift(list[k] >> kImageShift);
    part.x[k] = barrier_.x[j] + shift[0];
    part.y[k] = barrier_.y[j] + shift[1];
    part.z[k] = barrier_.z[j] + shift[2];
    part.weight[k] = barrier_.weight[j];
    part.p_over_rho2[k] = barrier_.p_over_rho2[j];
    part.inverse_density[k] = barrier_.inverse_density[j];
  }
  part.pad(n);
}

template <class Real>
void WcsphSolver<Real>::density_of(std::int32_t i, Real sum, Real own_share, Real factor) {
  if (settings.as_printed) sum -= density_share(particles.weight[i], own_share);
  const Real rest = Real(settings.rest_density);
  const Real rho = std::max(sum * factor, Real(kDensityFloor) * rest);
  const Real c2 = Real(settings.sound_speed * settings.sound_speed);
  Real p = pressure_linear(rho, rest, c2);
  if (settings.clamped) p = pressure_clamped(p);
  particles.density[i] = rho;
  particles.pressure[i] = p;
  particles.inverse_density[i] = Real(1) / rho;
  particles.p_over_rho2[i] = p * particles.inverse_density[i] * particles.inverse_density[i];
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
    if (walls > 0) fetch_barrier(batch, c, buffer, padded(blood), walls);
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
  const Real rest = Real(settings.rest_density);
  const Real k2 = Real(settings.sound_speed * settings.sound_speed);
  for (std::int32_t place = wet.first_cell; place < wet.last_cell; ++place) {
    const std::int32_t k = place - wet.first_cell;
    const std::int32_t c = neighbours_.wet_cell(place);
    const std::size_t n = wet.blood_start[k + 1] - wet.blood_start[k];
    buffer.reserve(n);
    fetch_blood(wet, place, buffer, n, false);
    const std::uint32_t* list = wet.blood.data() + wet.blood_start[k];
    for (std::size_t j = 0; j < n; ++j) {
      buffer.p_over_rho2[j] = particles.pressure[list[j] & kIndexMask];
    }
    for (std::int32_t b = barrier_order_.cell_start(c); b < barrier_order_.cell_start(c + 1); ++b) {
      Real weight, pressure;
      mirror_sums(kernels, buffer, padded(n), barrier_.x[b], barrier_.y[b], barrier_.z[b],
                  constants, weight, pressure);
      const Real mirrored = weight > Real(0) ? pressure_clamped(pressure / weight) : Real(0);
      const Real p = barrier_.pressure[b] + share * (mirrored - barrier_.pressure[b]);
      const Real rho = rest + p / k2;
      barrier_.pressure[b] = p;
      barrier_.inverse_density[b] = Real(1) / rho;
      barrier_.p_over_rho2[b] = p / (rho * rho);
    }
  }
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
    if (walls > 0) fetch_barrier(batch, c, buffer, padded(blood), walls);
    const CandidateBuffer<Real> wall_part = buffer.from(padded(blood));
    for (std::int32_t i = order_.cell_start(c); i < order_.cell_start(c + 1); ++i) {
      const Probe<Real> probe{p.x[i],  p.y[i],  p.z[i],           p.vx[i],
                              p.vy[i], p.vz[i], p.p_over_rho2[i], p.inverse_density[i]};
      PairForces<Real> forces;
      blood_forces(kernels, buffer, padded(blood), probe, constants, forces);
      if (walls > 0) {
        barrier_forces(kernels, wall_part, padded(walls), probe, constants, forces);
      }
      acceleration_of(i, forces, push, drag);
    }
  }
}

// The safety net: a particle that got into a wall is put back onto its surface and loses the speed
// into it. Half a spacing deep counts as a crossing; pressure keeps particles from getting there.
template <class Real>
void WcsphSolver<Real>::push_out(std::size_t i, Real distance, const std::array<Real, 3>& n,
                                 Largest& largest) {
  Particles<Real>& p = particles;
  ++largest.pushed;
  if (distance < Real(-0.5 * settings.spacing)) ++largest.crossings;
  p.x[i] -= distance * n[0], p.y[i] -= distance * n[1], p.z[i] -= distance * n[2];
  const Real inward = std::min(p.vx[i] * n[0] + p.vy[i] * n[1] + p.vz[i] * n[2], Real(0));
  p.vx[i] -= inward * n[0], p.vy[i] -= inward * n[1], p.vz[i] -= inward * n[2];
}

template <class Real>
void WcsphSolver<Real>::keep_out_of_walls(std::size_t i, Largest& largest) {
  const Real x = particles.x[i], y = particles.y[i], z = particles.z[i];
  const Real distance = barrier_distance.sample(x, y, z);
  if (distance < Real(0)) push_out(i, distance, barrier_distance.normal(x, y, z), largest);
  const Real height = platform.distance(x, y, z);
  if (height < Real(0)) push_out(i, height, platform.normal, largest);
}

// x += dt v with the rounding error carried over to the next step (Kahan 1965).
template <class Real>
inline void add_compensated(Real& x, Real& residue, Real step) {
  const Real y = step + residue;
  const Real sum = x + y;
  residue = y - (sum - x);
  x = sum;
}

template <class Real>
void WcsphSolver<Real>::integrate_range(std::size_t first, std::size_t last, Real dt,
                                        Largest& largest) {
  Particles<Real>& p = particles;
  const Real limit = Real(kSpeedLimit * settings.sound_speed);
  const Real swelling = dt * Real(settings.sound_speed / (kSwelling * settings.smoothing));
  const Real wall_reach = Real(kWallSlack * settings.smoothing);
  for (std::size_t i = first; i < last; ++i) {
    p.vx[i] = brinkman_velocity(p.vx[i], dt, p.ax[i], p.drag[i]);
    p.vy[i] = brinkman_velocity(p.vy[i], dt, p.ay[i], p.drag[i]);
    p.vz[i] = brinkman_velocity(p.vz[i], dt, p.az[i], p.drag[i]);
    add_compensated(p.x[i], p.residue_x[i], dt * p.vx[i]);
    add_compensated(p.y[i], p.residue_y[i], dt * p.vy[i]);
    add_compensated(p.z[i], p.residue_z[i], dt * p.vz[i]);
    if (p.clearance[i] < wall_reach) keep_out_of_walls(i, largest);
    p.weight[i] = std::min(Real(1), p.weight[i] + swelling);
    const Real speed2 = p.vx[i] * p.vx[i] + p.vy[i] * p.vy[i] + p.vz[i] * p.vz[i];
    const Real acceleration2 = p.ax[i] * p.ax[i] + p.ay[i] * p.ay[i] + p.az[i] * p.az[i];
    if (!(speed2 < limit * limit)) fault.raise(kNotFinite, static_cast<std::int64_t>(i));
    largest.speed2 = std::max(largest.speed2, speed2);
    // Drag within the step bounds what an acceleration can do.
    const Real held = Real(1) + dt * p.drag[i];
    largest.acceleration2 = std::max(largest.acceleration2, acceleration2 / (held * held));
    largest.moved2 = std::max(largest.moved2, p.moved_squared(i));
  }
}

template <class Real>
void WcsphSolver<Real>::merge(const std::vector<Largest>& parts) {
  Largest all;
  for (const Largest& part : parts) {
    all.speed2 = std::max(all.speed2, part.speed2);
    all.acceleration2 = std::max(all.acceleration2, part.acceleration2);
    all.moved2 = std::max(all.moved2, part.moved2);
    crossings += part.crossings;
    pushed += part.pushed;
  }
  largest_speed = std::sqrt(static_cast<double>(all.speed2));
  largest_acceleration = std::sqrt(static_cast<double>(all.acceleration2));
  largest_move_ = std::sqrt(static_cast<double>(all.moved2));
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

template <class Real>
double WcsphSolver<Real>::next_step() const {
  if (settings.fixed_step > 0.0) return settings.fixed_step;
  const double h = settings.smoothing;
  const double nu = settings.viscosity / settings.density;
  double dt = settings.courant * 0.65 * h / (settings.sound_speed + largest_speed);
  dt = std::min(dt, kViscousLimit * h * h / nu);
  if (largest_acceleration > 0.0) {
    dt = std::min(dt, kForceLimit * std::sqrt(h / largest_acceleration));
  }
  return dt;
}

template <class Real>
void WcsphSolver<Real>::locate_fault() {
  const auto i = static_cast<std::size_t>(fault.particle());
  fault_id = particles.id[i];
  fault_position = {particles.built_x[i], particles.built_y[i], particles.built_z[i]};
}

template <class Real>
bool WcsphSolver<Real>::step(double dt, const FlowSeries& flow) {
  if (stale || 2.0 * largest_move_ > skin()) search();
  if (source.settings.enabled &&
      source.flow(particles, flow.at(time + 0.5 * dt), dt, barrier_distance, tissue)) {
    search();
  }
  sums(dt, true);
  if (fault.bits() != kNoFault) {
    locate_fault();
    return false;
  }
  source.sample_pressure(particles, dt);
  time += dt;
  ++steps;
  particle_steps += static_cast<std::int64_t>(particles.size());
  return true;
}

template <class Real>
void WcsphSolver<Real>::evaluate() {
  if (stale) search();
  sums(0.0, false);
}

template <class Real>
bool WcsphSolver<Real>::advance(double until, const FlowSeries& flow, std::int64_t step_limit,
                                double wall_limit) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  for (std::int64_t k = 0; k < step_limit && time < until; ++k) {
    double dt = next_step();
    if (!(dt > 1e-10)) {
      fault.raise(kStepTooSmall, 0);
      return false;
    }
    const double rest = until - time;
    const bool last = rest <= dt * (1.0 + 1e-9);
    if (last)
      dt = rest;
    else if (rest < 2.0 * dt && settings.fixed_step <= 0.0)
      dt = 0.5 * rest;
    if (!step(dt, flow)) return false;
    if (last) time = until;
    const std::chrono::duration<double> wall = Clock::now() - start;
    if (wall.count() > wall_limit) break;
  }
  return time >= until;
}

template class WcsphSolver<float>;
template class WcsphSolver<double>;

}  // namespace vulnus::hemorrhage
