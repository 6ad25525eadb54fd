// Everything that happens at a neighbour search: strays leave, particles are sorted, fields of the
// limb are sampled, candidates are listed.
#include <algorithm>
#include <cmath>

#include "hemorrhage/wcsph_solver.hpp"

namespace vulnus::hemorrhage {
namespace {

constexpr double kCellEdge = 0.8;  // of the cells over h; chosen by timing
// Margin of candidate lists: what the fastest particle and another need for so many steps, between
// shares of h; chosen by timing.
constexpr double kStepsPerSearch = 12.0, kLeastMargin = 0.06, kLargestMargin = 0.3;
constexpr double kLimbBand = 0.5;  // half width of the hysteresis at the limb's surface over dx

template <class Real>
void apply_order(std::vector<Real>& values, const std::vector<std::int32_t>& order) {
  std::vector<Real> sorted(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) sorted[i] = values[order[i]];
  values.swap(sorted);
}

}  // namespace

template <class Real>
void WcsphSolver<Real>::set_barrier(std::vector<Real> x, std::vector<Real> y, std::vector<Real> z) {
  barrier_.x = std::move(x), barrier_.y = std::move(y), barrier_.z = std::move(z);
  const std::size_t n = barrier_.size();
  barrier_order_.frame(barrier_.x.data(), barrier_.y.data(), barrier_.z.data(), n,
                       Real(settings.smoothing));
  std::vector<std::uint64_t> keys(n);
  std::vector<std::int32_t> order;
  for (std::size_t b = 0; b < n; ++b) {
    keys[b] = barrier_order_.key(barrier_.x[b], barrier_.y[b], barrier_.z[b]);
  }
  radix_order(keys, order, n ? barrier_order_.key_limit() : 0);
  for (auto* a : {&barrier_.x, &barrier_.y, &barrier_.z}) apply_order(*a, order);
  barrier_order_.index(keys);
  barrier_.cell.resize(n);
  for (std::size_t c = 0; c < barrier_order_.cell_count(); ++c) {
    std::fill(barrier_.cell.begin() + barrier_order_.cell_start(c),
              barrier_.cell.begin() + barrier_order_.cell_start(c + 1),
              static_cast<std::int32_t>(c));
  }
  if (settings.kernels == KernelSet::kMueller2003)
    weigh_barrier(mueller_);
  else
    weigh_barrier(wendland_);
  stale = true;
}

// Volume of a barrier particle, 1 / sum_b' W_bb' (Akinci 2012), at most a blood particle's: walls
// of several layers lack neighbours only where no blood is. `weight` = rho0 V_b / (rho0 dx^3).
template <class Real>
template <class Kernels>
void WcsphSolver<Real>::weigh_barrier(const Kernels& kernels) {
  const std::size_t n = barrier_.size();
  const double dx3 = settings.spacing * settings.spacing * settings.spacing;
  const Real factor = Real(dx3 * settings.density_scale) * kernels.density_factor;
  const Real h = kernels.h;
  barrier_.weight.resize(n);
  barrier_.pressure.assign(n, 0);
  barrier_.place.resize(4 * n);
  barrier_.motion.assign(4 * n, 0);
  barrier_.inverse_density.assign(n, Real(1.0 / settings.density));
  for (std::size_t b = 0; b < n; ++b) {
    const Real x = barrier_.x[b], y = barrier_.y[b], z = barrier_.z[b];
    Real sum = 0;
    const Box<Real> box{{x - h, y - h, z - h}, {x + h, y + h, z + h}};
    barrier_order_.visit_rows(box, [&](std::int32_t first, std::int32_t last) {
      for (std::int32_t j = first; j < last; ++j) {
        const Real dx = x - barrier_.x[j], dy = y - barrier_.y[j], dz = z - barrier_.z[j];
        sum += kernels.density(dx * dx + dy * dy + dz * dz);
      }
    });
    barrier_.weight[b] = std::min(Real(1), Real(1) / (sum * factor));
    const Real values[4] = {x, y, z, barrier_.weight[b]};
    std::copy(values, values + 4, barrier_.place.begin() + static_cast<std::ptrdiff_t>(4 * b));
  }
}

// Particles taken back by the source (weight < 0) and those outside the domain leave; the latter
// are booked. Whether a particle counts as inside the limb has hysteresis.
template <class Real>
void WcsphSolver<Real>::drop_strays() {
  permutation_.clear();
  const Real band = Real(kLimbBand * settings.spacing);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (particles.weight[i] < Real(0)) continue;
    const std::array<Real, 3> point{particles.x[i], particles.y[i], particles.z[i]};
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      inside = inside && point[a] >= Real(domain_lower[a]) && point[a] <= Real(domain_upper[a]);
    }
    if (!inside) {
      ++removed;
      continue;
    }
    permutation_.push_back(static_cast<std::int32_t>(i));
    if (limb_distance.empty()) continue;
    const Real distance = limb_distance.sample(point[0], point[1], point[2]);
    if (distance > band) particles.in_limb[i] = 0;
    if (distance < -band) particles.in_limb[i] = 1;
  }
  if (permutation_.size() < particles.size()) particles.permute(permutation_);
}

template <class Real>
void WcsphSolver<Real>::order_particles() {
  const std::size_t n = particles.size();
  std::vector<Real>* axes[3] = {&particles.x, &particles.y, &particles.z};
  for (int a = 0; a < 3; ++a) {
    const Real length = periodicity.length[a], lower = periodicity.lower[a];
    if (length <= Real(0)) continue;
    for (Real& value : *axes[a]) value -= length * std::floor((value - lower) / length);
  }
  order_.frame(particles.x.data(), particles.y.data(), particles.z.data(), n,
               Real(kCellEdge * settings.smoothing));
  keys_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    keys_[i] = order_.key(particles.x[i], particles.y[i], particles.z[i]);
  }
  radix_order(keys_, permutation_, n ? order_.key_limit() : 0);
  particles.permute(permutation_);
  particles.pack_all();
  particles.built_x = particles.x;
  particles.built_y = particles.y;
  particles.built_z = particles.z;
}

template <class Real>
void WcsphSolver<Real>::index_cells() {
  const std::size_t n = particles.size();
  order_.frame(particles.built_x.data(), particles.built_y.data(), particles.built_z.data(), n,
               Real(kCellEdge * settings.smoothing));
  keys_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    keys_[i] = order_.key(particles.built_x[i], particles.built_y[i], particles.built_z[i]);
  }
  order_.index(keys_);
  const double h = settings.smoothing;
  neighbours_.search(particles, order_, barrier_, barrier_order_, periodicity,
                     Real(h + list_margin), Real(h + 0.5 * list_margin), useful_threads());
  source.list_near(particles, list_margin);
}

template <class Real>
void WcsphSolver<Real>::sample_fields() {
  const auto n = static_cast<std::int64_t>(particles.size());
  const int team = useful_threads();
#pragma omp parallel for schedule(static) num_threads(team) if (team > 1)
  for (std::int64_t i = 0; i < n; ++i) {
    const Real x = particles.built_x[i], y = particles.built_y[i], z = particles.built_z[i];
    tissue.sample(x, y, z, particles.porosity[i], particles.drag[i]);
    particles.clearance[i] = std::min(barrier_distance.sample(x, y, z), platform.distance(x, y, z));
  }
}

template <class Real>
void WcsphSolver<Real>::search() {
  const double h = settings.smoothing;
  list_margin = std::clamp(kStepsPerSearch * 2.0 * next_step() * largest_speed, kLeastMargin * h,
                           kLargestMargin * h);
  drop_strays();
  order_particles();
  index_cells();
  for (const std::int32_t c : neighbours_.dried_cells()) {
    std::fill(barrier_.pressure.begin() + barrier_order_.cell_start(c),
              barrier_.pressure.begin() + barrier_order_.cell_start(c + 1), Real(0));
  }
  sample_fields();
  largest_move_ = 0;
  stale = false;
  ++searches;
}

template <class Real>
void WcsphSolver<Real>::resume() {
  particles.resize_derived();
  if (stale) return;
  particles.pack_all();
  index_cells();
  sample_fields();
  Real moved2 = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    moved2 = std::max(moved2, particles.moved_squared(i));
  }
  largest_move_ = std::sqrt(static_cast<double>(moved2));
}

template <class Real>
std::size_t WcsphSolver<Real>::memory_bytes() {
  return particles.memory_bytes() + neighbours_.memory_bytes() + order_.memory_bytes() +
         keys_.capacity() * sizeof(std::uint64_t) + permutation_.capacity() * sizeof(std::int32_t);
}

template class WcsphSolver<float>;
template class WcsphSolver<double>;

}  // namespace vulnus::hemorrhage
