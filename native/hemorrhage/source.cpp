#include "hemorrhage/source.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hemorrhage/forces.hpp"

namespace vulnus::hemorrhage {
namespace {

constexpr int kDirections = 64;            // PHYSICS 4.5
constexpr double kRoom = 0.8;              // nearest neighbour of a newcomer over dx (PHYSICS 4.5)
constexpr double kTightRoom = 0.5;         // while a whole layer waits; chosen
constexpr double kBarrierClearance = 0.4;  // of a newcomer from a wall over dx; chosen

// Counter-based random numbers (splitmix64, Steele 2014): the n-th draw needs no earlier one.
double uniform(std::uint64_t seed, std::uint64_t counter) {
  std::uint64_t z = seed * 0x9E3779B97F4A7C15ull + (counter + 1) * 0xD1B54A32D192ED03ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

using Quaternion = std::array<double, 4>;

// A uniformly random rotation (Shoemake 1992).
Quaternion random_rotation(std::uint64_t seed, std::uint64_t draw) {
  const double u = uniform(seed, 3 * draw);
  const double a = 2.0 * std::numbers::pi * uniform(seed, 3 * draw + 1);
  const double b = 2.0 * std::numbers::pi * uniform(seed, 3 * draw + 2);
  const double p = std::sqrt(1.0 - u), q = std::sqrt(u);
  return {q * std::cos(b), p * std::sin(a), p * std::cos(a), q * std::sin(b)};
}

std::array<double, 3> rotate(const Quaternion& q, const std::array<double, 3>& v) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const std::array<double, 3> t{2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]),
                                2 * (x * v[1] - y * v[0])};
  return {v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
          v[2] + w * t[2] + x * t[1] - y * t[0]};
}

std::array<double, 3> fibonacci_direction(int k) {
  const double z = 1.0 - (2.0 * k + 1.0) / kDirections;
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0)) * k;
  const double s = std::sqrt(1.0 - z * z);
  return {s * std::cos(turn), s * std::sin(turn), z};
}

}  // namespace

double FlowSeries::at(double t) const {
  if (count == 0) return 0.0;
  if (t <= time[0]) return value[0];
  if (t >= time[count - 1]) return value[count - 1];
  const std::size_t k = static_cast<std::size_t>(std::upper_bound(time, time + count, t) - time);
  const double share = (t - time[k - 1]) / (time[k] - time[k - 1]);
  return value[k - 1] + share * (value[k] - value[k - 1]);
}

template <class Real>
double ShellSource<Real>::distance_to_center(const Particles<Real>& p, std::int32_t i) const {
  const double dx = p.x[i] - settings.center[0], dy = p.y[i] - settings.center[1];
  const double dz = p.z[i] - settings.center[2];
  return std::sqrt(dx * dx + dy * dy + dz * dz);
}

template <class Real>
void ShellSource<Real>::list_near(const Particles<Real>& p, double margin) {
  near_.clear();
  if (!settings.enabled) return;
  const double reach = settings.radius + smoothing + margin;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(p.size()); ++i) {
    const double dx = p.built_x[i] - settings.center[0], dy = p.built_y[i] - settings.center[1];
    const double dz = p.built_z[i] - settings.center[2];
    if (dx * dx + dy * dy + dz * dz < reach * reach) near_.push_back(i);
  }
}

template <class Real>
double ShellSource<Real>::nearest(const Particles<Real>& p,
                                  const std::array<double, 3>& point) const {
  double best = 1e30;
  for (const std::int32_t i : near_) {
    const double dx = p.x[i] - point[0], dy = p.y[i] - point[1], dz = p.z[i] - point[2];
    best = std::min(best, dx * dx + dy * dy + dz * dz);
  }
  return std::sqrt(best);
}

// Sites inside walls are out of the question; sites in tissue tight as a wall only count where
// there is no other.
template <class Real>
typename ShellSource<Real>::Site ShellSource<Real>::freest_site(const Particles<Real>& p,
                                                                const DistanceField<Real>& barrier,
                                                                const TissueField<Real>& tissue) {
  const Quaternion turn = random_rotation(settings.seed, static_cast<std::uint64_t>(draws++));
  Site open, tight;
  for (int k = 0; k < kDirections; ++k) {
    Site site;
    site.direction = rotate(turn, fibonacci_direction(k));
    std::array<double, 3> point;
    for (int a = 0; a < 3; ++a) {
      point[a] = settings.center[a] + settings.radius * site.direction[a];
    }
    const Real x = Real(point[0]), y = Real(point[1]), z = Real(point[2]);
    if (barrier.sample(x, y, z) < Real(kBarrierClearance * spacing)) continue;
    Real eps, rate;
    tissue.sample(x, y, z, eps, rate);
    site.porosity = eps;
    site.clearance = nearest(p, point);
    Site& best = rate < Real(settings.wall_rate) ? open : tight;
    if (site.clearance > best.clearance) best = site;
  }
  return open.clearance >= 0.0 ? open : tight;
}

template <class Real>
bool ShellSource<Real>::emit(Particles<Real>& p, double flow_rate,
                             const DistanceField<Real>& barrier, const TissueField<Real>& tissue) {
  const Site site = freest_site(p, barrier, tissue);
  const double layer =
      4.0 * std::numbers::pi * settings.radius * settings.radius / (spacing * spacing);
  const double waiting = std::min(1.0, (pending / particle_volume - 1.0) / layer);
  const double room = kRoom + (kTightRoom - kRoom) * waiting;
  if (site.clearance < room * spacing) return false;
  const double r = settings.radius;
  const double speed = flow_rate / (4.0 * std::numbers::pi * r * r * site.porosity);
  const auto& d = site.direction;
  p.append(Real(settings.center[0] + r * d[0]), Real(settings.center[1] + r * d[1]),
           Real(settings.center[2] + r * d[2]), Real(speed * d[0]), Real(speed * d[1]),
           Real(speed * d[2]), newcomer_weight, next_id++);
  near_.push_back(static_cast<std::int32_t>(p.size() - 1));
  pending -= particle_volume;
  return true;
}

template <class Real>
bool ShellSource<Real>::take_back(Particles<Real>& p) {
  std::int32_t best = -1;
  double best_gap = smoothing;
  for (const std::int32_t i : near_) {
    if (p.weight[i] < Real(0)) continue;
    const double gap = std::abs(distance_to_center(p, i) - settings.radius);
    const bool nearer = gap < best_gap || (best >= 0 && gap == best_gap && p.id[i] < p.id[best]);
    if (nearer) best = i, best_gap = gap;
  }
  if (best < 0) return false;
  p.weight[best] = Real(-1);
  pending += particle_volume;
  return true;
}

template <class Real>
bool ShellSource<Real>::flow(Particles<Real>& p, double flow_rate, double dt,
                             const DistanceField<Real>& barrier, const TissueField<Real>& tissue) {
  injected += flow_rate * dt;
  pending += flow_rate * dt;
  bool changed = false;
  while (pending >= particle_volume && emit(p, flow_rate, barrier, tissue)) changed = true;
  while (pending <= -particle_volume && take_back(p)) changed = true;
  return changed;
}

template <class Real>
double ShellSource<Real>::pressure_around(const Particles<Real>& p) const {
  const double outer = settings.radius + smoothing;
  double sum = 0.0, weight = 0.0;
  for (const std::int32_t i : near_) {
    const double r = distance_to_center(p, i);
    if (r < settings.radius || r > outer) continue;
    const double mass_over_density = p.weight[i] * particle_volume;
    sum += interpolation_share(static_cast<double>(p.pressure[i]), mass_over_density, 1.0);
    weight += interpolation_share(1.0, mass_over_density, 1.0);
  }
  const double whole =
      4.0 / 3.0 * std::numbers::pi *
      (outer * outer * outer - settings.radius * settings.radius * settings.radius);
  const double volume = settings.sensor_volume > 0.0 ? settings.sensor_volume : whole;
  return weight < 0.5 * volume ? 0.0 : sum / weight;
}

template <class Real>
void ShellSource<Real>::sample_pressure(const Particles<Real>& p, double dt) {
  if (!settings.enabled) return;
  pressure_time += pressure_around(p) * dt;
  sampled_time += dt;
}

template class ShellSource<float>;
template class ShellSource<double>;

}  // namespace vulnus::hemorrhage
