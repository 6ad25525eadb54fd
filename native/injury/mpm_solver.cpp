#include "injury/mpm_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "injury/particle_readings.hpp"

namespace vulnus::injury {

namespace {

constexpr int kStepsPerEpoch = 64;   // at most; bounds the work lost with a checkpoint
constexpr double kDriftLimit = 0.8;  // of a cell; the tile's halo is one cell, and particles go
                                     // ahead by half of the next
// Cells between two passages of momentum. Chosen: from 0.25 on the drag of a sphere of 5 cells in a
// liquid is within 10 % of what it becomes; a particle's weights are true to the same part.
constexpr double kPassageDrift = 0.25;
// Of the step that the same speeds allow at rest; below this a run would not end. Chosen: water is
// squeezed to a seventh of its volume there, under 300 TPa.
constexpr double kCollapsedStep = 1e-3;
constexpr double kBoundlessSpeed = 1e6;  // times waves at rest [chosen: no tissue moves so]
constexpr double kLongCall = 0.05;       // [s] after which an epoch's start waits for the next call

template <class T>
double largest_resting_speed(const MaterialTable<T>& materials) {
  double largest = 0;
  for (int i = 0; i < kMaterialCapacity; ++i) {
    const double shear =
        double(materials.column[kShearModulus][i]) + materials.column[kNetworkModulus][i];
    const double c2 =
        (materials.column[kBulkModulus][i] + 4.0 / 3.0 * shear) / materials.column[kDensity][i];
    largest = std::max(largest, std::sqrt(c2));
  }
  return largest;
}

double wall_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

template <class T>
MpmSolver<T>::MpmSolver(const SolverSettings& settings, const MaterialTable<T>& materials)
    : settings_(settings), materials_(materials) {
  sound_speed_ = resting_speed_ = largest_resting_speed(materials);
}

template <class T>
void MpmSolver<T>::set_materials(const MaterialTable<T>& materials, double sound_speed) {
  materials_ = materials;
  sound_speed_ = sound_speed;
  resting_speed_ = largest_resting_speed(materials);
}

template <class T>
void MpmSolver<T>::restore(double time, std::int64_t steps, double sound_speed) {
  time_ = time;
  steps_ = steps;
  sound_speed_ = sound_speed;
  stage_ = EpochStage::kOver;
  looking_ = false;
  fault_.clear();
  faulty_body_ = -1;
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

// Of bodies and walls, which move nodes without a particle's doing.
template <class T>
double MpmSolver<T>::largest_rigid_speed() const {
  double largest = 0;
  for (const RigidBody& body : bodies_) largest = std::max(largest, body.surface_speed());
  for (const HalfSpace& wall : boundaries_)
    largest = std::max(largest, std::hypot(wall.velocity[0], wall.velocity[1], wall.velocity[2]));
  return largest;
}

// Whether the next step is so small that the run would not end.
template <class T>
bool MpmSolver<T>::step_collapses(double speed, double stop_time) const {
  const double calm = resting_speed_ + speed;
  const bool stiff = !(calm >= kCollapsedStep * (sound_speed_ + speed));
  const bool fast = !(speed < kBoundlessSpeed * resting_speed_);
  return time_ < stop_time && (stiff || fast || !(time_ + clipped_step(speed, stop_time) > time_));
}

// Names what sets the step: a body, or the particle that is stiffest or fastest.
template <class T>
void MpmSolver<T>::report_collapse(double speed) {
  for (std::size_t k = 0; k < bodies_.size() && sound_speed_ < speed; ++k)
    if (bodies_[k].surface_speed() >= speed) faulty_body_ = static_cast<int>(k);
  const int place =
      sound_speed_ < speed ? fastest_point(particles_) : stiffest_point(particles_, materials_);
  fault_.raise(kStepTooSmall, place < 0 ? 0 : particles_.id[place]);
}

template <class T>
void MpmSolver<T>::move_bodies(double dt) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    bodies_[k].end_step(time_, dt);
    if (faulty_body_ < 0 && !bodies_[k].finite()) faulty_body_ = static_cast<int>(k);
  }
}

// Sorts and scatters; whether that is done. What takes long is left to the next call.
template <class T>
bool MpmSolver<T>::start_epoch(const Stops& stops, double call_began) {
  auto late = [&] { return wall_clock() - call_began > kLongCall; };
  if (stage_ == EpochStage::kOver) {
    if (late()) return false;
    particles_.sort(T(1 / settings_.grid_spacing), grid_);
    stage_ = EpochStage::kSorted;
  }
  if (late()) return false;
  scatter_epoch(stops);
  return !late();
}

template <class T>
void MpmSolver<T>::scatter_epoch(const Stops& stops) {
  const double fastest = std::max(largest_particle_speed(), largest_rigid_speed());
  if (step_collapses(fastest, stops.first)) report_collapse(fastest);
  step_ = clipped_step(fastest, stops.first);
  drift_ = 0;
  begin_passage(fastest, stops.end());
  pass_momentum<false>({0, step_, ahead_});
  stage_ = EpochStage::kRunning;
}

// Longest time between two passages: of whole steps, and a little, also where looks cut them short.
template <class T>
double MpmSolver<T>::passage_span(double speed) const {
  return (settings_.passage_steps + 1e-6) * stable_step(speed);
}

// The particles go ahead to where they will be in the middle of the steps that the nodes will keep
// their momentum for, so that weights and places are right to the second order in time. Particles
// move along the velocity that they carry, so that no angular momentum is lost. Where a passage
// ends early, because speeds grew, they are too far ahead and step back.
template <class T>
void MpmSolver<T>::begin_passage(double speed, double epoch_end) {
  const double left_in_epoch = kStepsPerEpoch - static_cast<double>(steps_ % kStepsPerEpoch);
  double span = passage_span(speed);
  if (speed > 0) span = std::min(span, kPassageDrift * settings_.grid_spacing / speed);
  const double steps = std::clamp(std::floor(span / step_), 1.0, left_in_epoch);
  ahead_ = std::max(0.0, 0.5 * (std::min(steps * step_, epoch_end - time_) - step_));
  since_passage_ = 0;
  passage_drift_ = 0;
  nodes_keep_ = false;
}

// From the particles to the nodes. What interpolation to nodes and back smooths away of the motion,
// G S of the v of the particles, is scattered once more: v_i = S v + S (v - G S v), the second
// order of Hammerquist and Nairn's extended PIC, here with APIC's S and G (gradients included), so
// that momentum and angular momentum are kept. Without it half of the work of a ball five cells
// across is lost in the smoothed flow around it.
template <class T>
template <bool Gather>
void MpmSolver<T>::pass_momentum(PassTimes times) {
  if (!sharpens()) return particle_pass<Gather, true>(times);
  particle_pass<Gather, true>({times.step, 0, times.travel});
  find_mirrors();
  if (!mirrors_.empty()) sum_all_tiles();
#pragma omp parallel for schedule(dynamic, 8)
  for (int i = 0; i < grid_.active(); ++i) load_velocity(i, 0);
  reflect_mirrors();
  nodes_keep_ = true;
  scatter_rest(times.next_step);
}

template <class T>
int MpmSolver<T>::advance(int max_steps, double stop_time, double next_stop) {
  const double call_began = wall_clock();
  const Stops stops{stop_time, std::max(stop_time, next_stop)};
  int done = 0;
  while (done < max_steps && time_ < stop_time && fault_.bits() == kNoFault && faulty_body_ < 0) {
    if (stage_ != EpochStage::kRunning && !start_epoch(stops, call_began)) break;
    if (fault_.bits() != kNoFault) break;
    take_step(stops);
    ++done;
  }
  return done;
}

template <class T>
void MpmSolver<T>::take_step(const Stops& stops) {
  cut_tissue();
  const double speed = update_grid(step_);
  move_bodies(step_);
  move_tracers(step_);
  const double dt = step_;
  // A step that was not cut for this stop (it was begun before another one) goes past it.
  time_ = std::abs(stops.first - time_ - dt) <= 1e-9 * dt ? stops.first : time_ + dt;
  drift_ += speed * dt;
  ++steps_;
  const int in_epoch = static_cast<int>(steps_ % kStepsPerEpoch);
  const double fastest = std::max(speed, largest_rigid_speed());
  const double next_stop = time_ < stops.first ? stops.first : stops.second;
  const double next = clipped_step(fastest, next_stop);
  const bool epoch_ends = time_ >= next_stop || in_epoch == 0 ||
                          drift_ + 2 * fastest * next > kDriftLimit * settings_.grid_spacing;
  if (!epoch_ends) step_ = next;
  since_passage_ += dt;
  passage_drift_ += fastest * dt;
  nodes_keep_ = !epoch_ends && since_passage_ + next <= passage_span(fastest) &&
                passage_drift_ + fastest * next <= kPassageDrift * settings_.grid_spacing;
  looking_ = !epoch_ends && time_ >= stops.first;
  if (epoch_ends) {
    particle_pass<true, false>({dt, 0, since_passage_ - ahead_});
    stage_ = EpochStage::kOver;
  } else if (nodes_keep_) {
    particle_pass<true, true>({dt, next, 0});
  } else {
    const double late = since_passage_ - ahead_;
    begin_passage(fastest, stops.end());
    pass_momentum<true>({dt, next, late + ahead_});
  }
  if (fault_.bits() == kNoFault && step_collapses(fastest, next_stop)) report_collapse(fastest);
}

template <class T>
void MpmSolver<T>::settle() {
  if (!looking_) return;
  const T ahead = T(shown_ahead());
#pragma omp parallel for schedule(static)
  for (int p = 0; p < particles_.places(); ++p)
    for (int a = 0; a < 3; ++a)
      particles_.field[kPosition + a][p] -= ahead * particles_.field[kVelocity + a][p];
  looking_ = false;
  stage_ = EpochStage::kOver;
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
