// The material point method for rho Dv/Dt = div sigma + rho g (Equation: Chong2017 (1)): MLS-MPM
// with APIC transfers on a sparse blocked grid.
//
// Steps come in epochs. An epoch starts by sorting the particles; then, until a particle may have
// drifted by a cell, each step is one fused pass over the particles: gather from the old nodes,
// update strain and stress, scatter to the tiles for the next step. At the end of an epoch
// (`synchronized()`) the particles hold the whole state, and only there may it be saved. Between
// epochs' ends a run may stop for a look: the particles then tell their velocities, and the run
// goes on as if nobody had looked, but for the length of the steps before.
//
// Momentum passes from the nodes to the particles and back only when tissue or bodies may have
// moved by a part of a cell. In between, the nodes keep their velocity, the particles their place
// in the grid, and a step adds only the impulses of the stress. Each passage smooths the velocity
// over some cells; done at every step, in time with the sound, it is a viscosity that doubles the
// drag of a slow projectile. `passage_steps` = 1 asks for that: it damps what only the grid knows.
// With more, passages are of the second order: what one loses is scattered once more.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/fault.hpp"
#include "injury/block_grid.hpp"
#include "injury/body_contact.hpp"
#include "injury/boundary.hpp"
#include "injury/material.hpp"
#include "injury/mirror.hpp"
#include "injury/particle_set.hpp"
#include "injury/rigid_body.hpp"

namespace vulnus::injury {

struct SolverSettings {
  double grid_spacing = 0;
  double courant_number = 0.4;
  double gravity[3] = {0, 0, 0};
  double domain_lower[3] = {0, 0, 0};  // local frame
  double domain_upper[3] = {0, 0, 0};
  double largest_step = 1e30;
  int passage_steps = 1;        // whole ones between two passages of momentum, at most
  int contact_iterations = 60;  // of a body's velocity in contact, at most
};

// A massless point that moves with the grid's velocity: a station of an artery's centre-line.
struct Tracer {
  double position[3];
  double smallest_gap;  // distance to the nearest body's surface, smallest so far [m]
};

struct Totals {
  double mass;
  double momentum[3];
  double angular_momentum[3];  // about the local origin, with APIC's affine part
  double kinetic_energy;
};

// The times of a pass over the particles.
struct PassTimes {
  double step;       // that ends: strains
  double next_step;  // that begins: impulses of the stress
  double travel;     // for which the particles move
};

// Where steps end: at the first stop, for a look where a later one follows, and at that.
struct Stops {
  double first, second;

  // Of the epoch, as far as is known.
  double end() const { return second > first ? std::numeric_limits<double>::infinity() : first; }
};

enum class EpochStage : int {
  kOver,    // the particles hold the whole state
  kSorted,  // they stand in the order of the new grid
  kRunning  // and the tiles hold what they scatter
};

template <class T>
class MpmSolver {
 public:
  MpmSolver(const SolverSettings& settings, const MaterialTable<T>& materials);

  ParticleSet<T>& particles() { return particles_; }
  std::vector<Tracer>& tracers() { return tracers_; }
  std::vector<RigidBody>& bodies() { return bodies_; }
  std::vector<HalfSpace>& boundaries() { return boundaries_; }
  SolverSettings& settings() { return settings_; }
  // New constants for the next step; the largest wave speed goes with them.
  void set_materials(const MaterialTable<T>& materials, double sound_speed);

  // Takes at most max_steps steps, not past stop_time; returns how many. Where the start of an
  // epoch takes long it is a call of its own, so that no call is much longer than the others. The
  // epoch ends at stop_time, unless the run will go on to a later next_stop: then stop_time is for
  // a look only.
  int advance(int max_steps, double stop_time, double next_stop);
  // Ends the epoch at a look.
  void settle();

  bool synchronized() const { return stage_ == EpochStage::kOver; }
  // The time by which the particles' places are ahead of where they are, at a look.
  double shown_ahead() const { return looking_ ? ahead_ - since_passage_ : 0; }
  double time() const { return time_; }
  std::int64_t steps() const { return steps_; }
  double step_size() const { return step_; }
  double largest_sound_speed() const { return sound_speed_; }
  void restore(double time, std::int64_t steps, double sound_speed);

  FaultRecord& fault() { return fault_; }
  int faulty_body() const { return faulty_body_; }  // that is no longer finite, or -1
  std::size_t memory_bytes() const;
  Totals particle_totals() const;
  Totals grid_totals() const;

  // One scatter onto the grid with step size dt, for tests of the transfer: sorts, scatters and
  // reduces, and leaves momentum on the nodes.
  void scatter_only(double dt);
  // The counterpart: turns momentum into velocity and gathers.
  void gather_only(double dt);

 private:
  bool start_epoch(const Stops& stops, double call_began);
  void scatter_epoch(const Stops& stops);
  void begin_passage(double speed, double epoch_end);
  double passage_span(double speed) const;
  double stable_step(double speed) const;
  double clipped_step(double speed, double stop_time) const;
  double largest_particle_speed() const;
  double largest_rigid_speed() const;
  bool step_collapses(double speed, double stop_time) const;
  void report_collapse(double speed);
  void take_step(const Stops& stops);
  double update_grid(double dt);
  void sum_tiles(int i);
  void sum_all_tiles();
  void find_mirrors();
  void fold_mirrors();
  void reflect_mirrors();
  template <class Visit>
  void for_image_pairs(const Mirror& mirror, const Visit& visit);
  void load_velocity(int i, double dt);
  double finish_block(int i, double dt);
  void constrain_block(const HalfSpace& wall, int i, double dt);
  void block_corner(int i, double (&corner)[3]) const;
  bool block_is_near(const RigidBody& body, int i) const;
  bool block_is_near_a_body(int i) const;
  void find_contacts(const RigidBody& body, int i, std::vector<ContactNode>& out) const;
  void collide(RigidBody& body);
  void cut_tissue();
  void cut_tissue(const RigidBody& body);
  void move_bodies(double dt);
  void move_tracers(double dt);
  template <bool Gather, bool Scatter>
  void particle_pass(PassTimes times);
  template <bool Gather>
  void pass_momentum(PassTimes times);
  void scatter_rest(double next_step);
  // Whether passages are of the second order.
  bool sharpens() const { return settings_.passage_steps > 1; }

  SolverSettings settings_;
  MaterialTable<T> materials_;
  ParticleSet<T> particles_;
  BlockGrid<T> grid_;
  std::vector<Tracer> tracers_;
  std::vector<RigidBody> bodies_;
  std::vector<HalfSpace> boundaries_;
  std::vector<Mirror> mirrors_;
  std::vector<std::uint8_t> near_body_;  // a flag for every block
  std::vector<int> near_blocks_;
  std::vector<std::vector<ContactNode>> block_contacts_;
  std::vector<ContactNode> contacts_;
  FaultRecord fault_;
  int faulty_body_ = -1;
  double time_ = 0;
  double step_ = 0;
  double drift_ = 0;          // how far a particle may have moved since the sort [m]
  double passage_drift_ = 0;  // how far anything may have since momentum last passed [m]
  double since_passage_ = 0;  // [s]
  double ahead_ = 0;          // of the particles, at the last passage [s]
  double sound_speed_ = 0;
  double resting_speed_ = 0;  // of waves in the fastest material at rest
  std::int64_t steps_ = 0;
  EpochStage stage_ = EpochStage::kOver;
  bool nodes_keep_ = false;  // nodes hold velocities, tiles impulses
  bool looking_ = false;     // particles hold the velocities of this moment too
};

extern template class MpmSolver<float>;
extern template class MpmSolver<double>;

}  // namespace vulnus::injury
