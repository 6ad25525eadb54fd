#include "hemorrhage/wcsph_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "hemorrhage/porous.hpp"

namespace vulnus::hemorrhage {
namespace {

constexpr std::size_t kParticlesPerThread = 1000;  // fewer are not worth another thread
constexpr double kForceLimit = 0.25;               // dt <= 0.25 sqrt(h/|a|) (Monaghan 1992)
constexpr double kViscousLimit = 0.125;            // dt <= 0.125 h^2/nu (Morris 1997)
constexpr double kSpeedLimit = 4.0;                // over c0; faster is a fault
constexpr double kSwelling = 10.0;                 // newcomers swell within 10 h/c0; chosen
constexpr double kWallSlack = 0.3;                 // margin of the wall check over h

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
    p.pack(i);
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
  if (stale || 2.0 * largest_move_ > list_margin) search();
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
