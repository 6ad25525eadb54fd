// Weakly compressible SPH of blood: density -> pressure -> forces -> velocity with implicit drag ->
// position (Chong 2017, eqs. 2-13, as corrected in PHYSICS 4.1b). Every sum gathers, none scatters,
// so results do not depend on the number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/fault.hpp"
#include "hemorrhage/cell_order.hpp"
#include "hemorrhage/grid_field.hpp"
#include "hemorrhage/neighbours.hpp"
#include "hemorrhage/pair_sums.hpp"
#include "hemorrhage/particles.hpp"
#include "hemorrhage/smoothing_kernel.hpp"
#include "hemorrhage/source.hpp"

namespace vulnus::hemorrhage {

enum class KernelSet : int { kMueller2003 = 0, kWendlandC2 = 1 };

struct FluidSettings {
  KernelSet kernels = KernelSet::kWendlandC2;
  double spacing = 1e-3, smoothing = 2e-3, sound_speed = 30, density = 1060, viscosity = 3.5e-3;
  double courant = 0.25;
  double fixed_step = 0;     // > 0: this step instead of the adaptive one
  double dissipation = 3.0;  // Zhang 2017; 0: none
  bool clamped = true, as_printed = false;
  // Factors that make the discrete sums exact on the rest lattice; 1 in the paper's own form.
  double density_scale = 1, gradient_scale = 1, laplacian_scale = 1, rest_density = 1060;
};

template <class Real>
class WcsphSolver {
 public:
  explicit WcsphSolver(const FluidSettings& settings);

  // Scene.
  FluidSettings settings;
  std::array<double, 3> gravity{0, 0, 0};
  Periodicity<Real> periodicity;
  DistanceField<Real> barrier_distance, limb_distance;
  Slab<Real> platform;
  TissueField<Real> tissue;
  ShellSource<Real> source;
  std::array<double, 3> domain_lower{-1e3, -1e3, -1e3}, domain_upper{1e3, 1e3, 1e3};
  int threads = 1;
  void set_barrier(std::vector<Real> x, std::vector<Real> y, std::vector<Real> z);

  // State, besides the particles' and the source's own.
  Particles<Real> particles;
  double time = 0, largest_speed = 0, largest_acceleration = 0;
  std::int64_t steps = 0, particle_steps = 0, removed = 0, crossings = 0, pushed = 0, searches = 0;
  double list_margin = 0;  // of candidate lists beyond h [m]; half of it is used up by a move
  bool stale = true;       // candidates must be searched before the next sum

  FaultRecord fault;
  std::int64_t fault_id = -1;
  std::array<double, 3> fault_position{};

  // Steps until `until` [s], at most `step_limit` steps and about `wall_limit` seconds of wall time
  // (which decides only where a chunk ends, never what is computed). True when `until` is reached.
  bool advance(double until, const FlowSeries& flow, std::int64_t step_limit, double wall_limit);

  // Sums at the present positions, without a step: density, pressure, accelerations.
  void evaluate();
  // Rebuilds what is derived from kept arrays after they were restored.
  void resume();

  double next_step() const;
  std::size_t memory_bytes();
  double mean_neighbours() const;
  BarrierParticles<Real>& barrier() { return barrier_; }

 private:
  struct Largest {
    Real speed2 = 0, acceleration2 = 0, moved2 = 0;
    std::int64_t crossings = 0, pushed = 0;
  };

  template <class Kernels>
  void weigh_barrier(const Kernels& kernels);
  bool step(double dt, const FlowSeries& flow);
  void search();
  void order_particles();
  void drop_strays();
  void index_cells();
  void sample_fields();
  void sums(double dt, bool integrate);
  template <class Kernels>
  void density_pass(const Kernels& kernels, const CellBatch& batch, CandidateBuffer<Real>& buffer);
  template <class Kernels>
  void barrier_pass(const Kernels& kernels, const CellBatch& wet, Real share,
                    CandidateBuffer<Real>& buffer);
  template <class Kernels>
  void force_pass(const Kernels& kernels, const CellBatch& batch, CandidateBuffer<Real>& buffer);
  template <class Kernels>
  void sums(const Kernels& kernels, double dt, bool integrate);
  void density_of(std::int32_t i, Real sum, Real own_share, Real factor);
  void acceleration_of(std::int32_t i, const PairForces<Real>& forces, Real push, Real drag);
  void integrate_range(std::size_t first, std::size_t last, Real dt, Largest& largest);
  void keep_out_of_walls(std::size_t i, Largest& largest);
  void push_out(std::size_t i, Real distance, const std::array<Real, 3>& normal, Largest& largest);
  void fetch_blood(const CellBatch& batch, std::int32_t cell, CandidateBuffer<Real>& buffer,
                   std::size_t n, bool with_motion) const;
  void fetch_barrier(const CellBatch& batch, std::int32_t cell, CandidateBuffer<Real>& buffer,
                     std::size_t offset, std::size_t n, bool with_motion) const;
  void mirror_at(std::int32_t b, const MirrorSums<Real>& sums, Real share);
  PairConstants<Real> pair_constants() const;
  void merge(const std::vector<Largest>& parts);
  void locate_fault();
  int useful_threads() const;

  MuellerKernels<Real> mueller_;
  WendlandKernels<Real> wendland_;
  BarrierParticles<Real> barrier_;
  CellOrder<Real> order_, barrier_order_;
  Neighbours<Real> neighbours_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::int32_t> permutation_;
  std::vector<CandidateBuffer<Real>> buffers_;
  double largest_move_ = 0;
};

extern template class WcsphSolver<float>;
extern template class WcsphSolver<double>;

}  // namespace vulnus::hemorrhage
