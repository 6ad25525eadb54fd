#include "injury/mpm_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vulnus::injury {

namespace {

constexpr int kStepsPerEpoch = 64;    // at most; bounds the work lost with a checkpoint
constexpr double kDriftLimit = 0.95;  // of a cell; the tile's halo is one cell

}  // namespace

template <class T>
MpmSolver<T>::MpmSolver(const SolverSettings& settings, const MaterialTable<T>& materials)
    : settings_(settings), materials_(materials) {
  for (int i = 0; i < kMaterialCapacity; ++i) {
    const double c2 =
        (materials.column[kBulkModulus][i] + 4.0 / 3.0 * materials.column[kShearModulus][i]) /
        materials.column[kDensity][i];
    sound_speed_ = std::max(sound_speed_, std::sqrt(c2));
  }
}

template <class T>
void MpmSolver<T>::restore(double time, std::int64_t steps, double sound_speed) {
  time_ = time;
  steps_ = steps;
  sound_speed_ = sound_speed;
  grid_ready_ = false;
}

// dt = C dx / (c + |v|), and |v| dt < 0.3 dx (PHYSICS 1.5).
template <class T>
double MpmSolver<T>::stable_step(double speed) const {
  const double dx = settings_.grid_spacing;
  double dt =
      std::min(settings_.largest_step, settings_.courant_number * dx / (sound_speed_ + speed));
  if (speed > 0) dt = std::min(dt, 0.3 * dx / speed);
  return dt;
}

// The last two steps before the stop share what is left, so that none is tiny.
template <class T>
double MpmSolver<T>::clipped_step(double speed, double stop_time) const {
  const double dt = stable_step(speed);
  const double left = stop_time - time_;
  if (left <= dt) return left;
  return left < 2 * dt ? 0.5 * left : dt;
}

template <class T>
double MpmSolver<T>::largest_particle_speed() const {
  const auto& v = particles_.field;
  T largest = 0;
#pragma omp parallel for schedule(static) reduction(max : largest)
  for (int p = 0; p < particles_.places(); ++p) {
    const T x = v[kVelocity][p], y = v[kVelocity + 1][p], z = v[kVelocity + 2][p];
    largest = std::max(largest, x * x + y * y + z * z);
  }
  return std::sqrt(double(largest));
}

template <class T>
void MpmSolver<T>::begin_epoch(double stop_time) {
  particles_.sort(T(1 / settings_.grid_spacing), grid_);
  const double* u = settings_.sphere.velocity;
  const double projectile = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  step_ = clipped_step(std::max(largest_particle_speed(), projectile), stop_time);
  drift_ = 0;
  particle_pass<false, true>(0, step_);
  grid_ready_ = true;
}

template <class T>
int MpmSolver<T>::advance(int max_steps, double stop_time) {
  int done = 0;
  int in_epoch = 0;
  while (done < max_steps && time_ < stop_time && fault_.bits() == kNoFault) {
    if (!grid_ready_) begin_epoch(stop_time);
    if (fault_.bits() != kNoFault) break;
    const double speed = update_grid(step_);
    move_tracers(step_);
    const double dt = step_;
    time_ = stop_time - time_ <= dt ? stop_time : time_ + dt;
    drift_ += speed * dt;
    ++steps_;
    ++done;
    in_epoch = static_cast<int>(steps_ % kStepsPerEpoch);
    const double* u = settings_.sphere.velocity;
    const double fastest = std::max(speed, std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]));
    const double next = clipped_step(fastest, stop_time);
    const bool epoch_ends = time_ >= stop_time || in_epoch == 0 ||
                            drift_ + 2 * fastest * next > kDriftLimit * settings_.grid_spacing;
    if (epoch_ends) {
      particle_pass<true, false>(dt, 0);
      grid_ready_ = false;
    } else {
      particle_pass<true, true>(dt, next);
      step_ = next;
    }
  }
  return done;
}

template <class T>
double MpmSolver<T>::update_grid(double dt) {
  double largest = 0;
#pragma omp parallel for schedule(dynamic, 8) reduction(max : largest)
  for (int i = 0; i < grid_.active(); ++i) largest = std::max(largest, update_block(i, dt));
  return std::sqrt(largest);
}

// Momentum to velocity, gravity (equation 1), then the held ends and the projectile; returns the
// largest squared speed.
template <class T>
double MpmSolver<T>::update_block(int i, double dt) {
  grid_.reduce(i);
  T* node = grid_.nodes(i);
  const T kick[3] = {T(dt * settings_.gravity[0]), T(dt * settings_.gravity[1]),
                     T(dt * settings_.gravity[2])};
  for (int n = 0; n < kBlockNodes; ++n) {
    T* value = node + n * kComponents;
    const T inverse = value[0] > T(0) ? T(1) / value[0] : T(0);
    const T loaded = value[0] > T(0) ? T(1) : T(0);
    for (int a = 0; a < 3; ++a) value[1 + a] = value[1 + a] * inverse + loaded * kick[a];
  }
  collide_block(i);
  T largest = 0;
  for (int n = 0; n < kBlockNodes; ++n) {
    const T* v = node + n * kComponents + 1;
    largest = std::max(largest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return largest;
}

template <class T>
void MpmSolver<T>::collide_block(int i) {
  const double dx = settings_.grid_spacing;
  const BlockIndex b = grid_.block(i);
  const double corner[3] = {b.x * kBlockEdge * dx, b.y * kBlockEdge * dx, b.z * kBlockEdge * dx};
  const double* axis = settings_.held_axis;
  const Sphere& sphere = settings_.sphere;
  double centre[3], along = 0, apart = 0;
  for (int a = 0; a < 3; ++a) {
    const double middle = corner[a] + 1.5 * dx;
    along += axis[a] * middle;
    centre[a] = sphere.centre[a] + sphere.velocity[a] * time_;
    apart += (middle - centre[a]) * (middle - centre[a]);
  }
  const double reach = 2.6 * dx;  // half of a block's diagonal: sqrt(3) 1.5 dx
  const bool hit = sphere.radius > 0 && std::sqrt(apart) < sphere.radius + reach;
  const bool held = along - reach < settings_.held_below || along + reach > settings_.held_above;
  if (!hit && !held) return;
  for (int n = 0; n < kBlockNodes; ++n) {
    const int index[3] = {n >> 4, n >> 2 & 3, n & 3};
    T* value = grid_.nodes(i) + n * kComponents;
    if (!(value[0] > T(0))) continue;
    T offset[3], v[3];
    double height = 0;
    for (int a = 0; a < 3; ++a) {
      const double x = corner[a] + index[a] * dx;
      height += axis[a] * x;
      offset[a] = T(x - centre[a]);
      v[a] = value[1 + a];
    }
    if (hit) contact_sphere(sphere, offset, v);
    const T free = height < settings_.held_below || height > settings_.held_above ? T(0) : T(1);
    for (int a = 0; a < 3; ++a) value[1 + a] = free * v[a];
  }
}

template <class T>
std::size_t MpmSolver<T>::memory_bytes() const {
  return particles_.memory_bytes() + grid_.memory_bytes() + tracers_.capacity() * sizeof(Tracer);
}

template <class T>
void MpmSolver<T>::scatter_only(double dt) {
  particles_.sort(T(1 / settings_.grid_spacing), grid_);
  particle_pass<false, true>(0, dt);
  for (int i = 0; i < grid_.active(); ++i) grid_.reduce(i);
}

template <class T>
void MpmSolver<T>::gather_only(double dt) {
  update_grid(dt);
  particle_pass<true, false>(dt, 0);
}

template class MpmSolver<float>;
template class MpmSolver<double>;

}  // namespace vulnus::injury
