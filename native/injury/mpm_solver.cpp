#include "injury/mpm_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vulnus::injury {

namespace {

constexpr int kStepsPerEpoch = 64;   // at most; bounds the work lost with a checkpoint
constexpr double kDriftLimit = 0.8;  // of a cell; the tile's halo is one cell, and particles go
                                     // ahead by half of the next
// Cells between two passages of momentum. Chosen: from 0.25 on the drag of a sphere of 5 cells in a
// liquid is within 10 % of what it becomes; a particle's weights are true to the same part.
constexpr double kPassageDrift = 0.25;

}  // namespace

template <class T>
MpmSolver<T>::MpmSolver(const SolverSettings& settings, const MaterialTable<T>& materials)
    : settings_(settings), materials_(materials) {
  for (int i = 0; i < kMaterialCapacity; ++i) {
    const double shear =
        double(materials.column[kShearModulus][i]) + materials.column[kNetworkModulus][i];
    const double c2 =
        (materials.column[kBulkModulus][i] + 4.0 / 3.0 * shear) / materials.column[kDensity][i];
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
double MpmSolver<T>::largest_body_speed() const {
  double largest = 0;
  for (const RigidBody& body : bodies_) largest = std::max(largest, body.surface_speed());
  return largest;
}

template <class T>
void MpmSolver<T>::move_bodies(double dt) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    bodies_[k].end_step(time_, dt);
    if (faulty_body_ < 0 && !bodies_[k].finite()) faulty_body_ = static_cast<int>(k);
  }
}

template <class T>
void MpmSolver<T>::begin_epoch(double stop_time) {
  particles_.sort(T(1 / settings_.grid_spacing), grid_);
  step_ = clipped_step(std::max(largest_particle_speed(), largest_body_speed()), stop_time);
  drift_ = 0;
  begin_passage(largest_particle_speed(), stop_time);
  particle_pass<false, true>({0, step_, ahead_});
  grid_ready_ = true;
}

// The particles go ahead to where they will be in the middle of the steps that the nodes will keep
// their momentum for, so that weights and places are right to the second order in time. Particles
// move along the velocity that they carry, so that no angular momentum is lost.
template <class T>
void MpmSolver<T>::begin_passage(double speed, double stop_time) {
  const double cells = kPassageDrift * settings_.grid_spacing;
  const double left_in_epoch = kStepsPerEpoch - static_cast<double>(steps_ % kStepsPerEpoch);
  double steps = std::min<double>(left_in_epoch, settings_.passage_steps);
  if (steps * speed * step_ > cells) steps = std::max(1.0, std::floor(cells / (speed * step_)));
  ahead_ = 0.5 * (std::min(steps * step_, stop_time - time_) - step_);
  since_passage_ = 0;
  kept_steps_ = 0;
  passage_drift_ = 0;
  nodes_keep_ = false;
}

template <class T>
int MpmSolver<T>::advance(int max_steps, double stop_time) {
  int done = 0;
  int in_epoch = 0;
  while (done < max_steps && time_ < stop_time && fault_.bits() == kNoFault && faulty_body_ < 0) {
    if (!grid_ready_) begin_epoch(stop_time);
    if (fault_.bits() != kNoFault) break;
    cut_tissue();
    const double speed = update_grid(step_);
    move_bodies(step_);
    move_tracers(step_);
    const double dt = step_;
    // A step that was not cut for this stop (it was begun before another one) goes past it.
    time_ = std::abs(stop_time - time_ - dt) <= 1e-9 * dt ? stop_time : time_ + dt;
    drift_ += speed * dt;
    ++steps_;
    ++done;
    in_epoch = static_cast<int>(steps_ % kStepsPerEpoch);
    const double fastest = std::max(speed, largest_body_speed());
    const double next = clipped_step(fastest, stop_time);
    const bool epoch_ends = time_ >= stop_time || in_epoch == 0 ||
                            drift_ + 2 * fastest * next > kDriftLimit * settings_.grid_spacing;
    if (!epoch_ends) step_ = next;
    since_passage_ += dt;
    passage_drift_ += fastest * dt;
    nodes_keep_ = !epoch_ends && ++kept_steps_ < settings_.passage_steps &&
                  passage_drift_ + fastest * next <= kPassageDrift * settings_.grid_spacing;
    if (epoch_ends) {
      particle_pass<true, false>({dt, 0, since_passage_ - ahead_});
      grid_ready_ = false;
    } else if (nodes_keep_) {
      particle_pass<true, true>({dt, next, 0});
    } else {
      const double late = since_passage_ - ahead_;
      begin_passage(fastest, stop_time);
      particle_pass<true, true>({dt, next, late + ahead_});
    }
  }
  return done;
}

template <class T>
std::size_t MpmSolver<T>::memory_bytes() const {
  return particles_.memory_bytes() + grid_.memory_bytes() + tracers_.capacity() * sizeof(Tracer);
}

template <class T>
void MpmSolver<T>::scatter_only(double dt) {
  particles_.sort(T(1 / settings_.grid_spacing), grid_);
  particle_pass<false, true>({0, dt, 0});
  for (int i = 0; i < grid_.active(); ++i) grid_.reduce(i, false);
}

template <class T>
void MpmSolver<T>::gather_only(double dt) {
  update_grid(dt);
  particle_pass<true, false>({dt, 0, dt});
}

template class MpmSolver<float>;
template class MpmSolver<double>;

}  // namespace vulnus::injury
