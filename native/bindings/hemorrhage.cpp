// vulnus.hemorrhage._native: the bleeding solver in single and double precision, the grids of the
// injured limb, and the laws one by one for the tests.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <omp.h>

#include <algorithm>
#include <memory>

#include "hemorrhage/equation_of_state.hpp"
#include "hemorrhage/limb_grids.hpp"
#include "hemorrhage/porous.hpp"
#include "hemorrhage/wcsph_solver.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace vulnus;
using namespace vulnus::hemorrhage;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using FloatPoints = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Scalars = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using FloatScalars = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using FloatGrid = nb::ndarray<const float, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Vector = std::array<double, 3>;

template <class T>
nb::ndarray<nb::numpy, T> to_numpy(std::vector<T> values, std::vector<std::size_t> shape) {
  auto* owner = new std::vector<T>(std::move(values));
  nb::capsule release(owner, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::ndarray<nb::numpy, T>(owner->data(), shape.size(), shape.data(), release);
}

template <class Real>
std::vector<Real> component(const Points& points, int axis) {
  std::vector<Real> values(points.shape(0));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Real>(points(i, axis));
  return values;
}

template <class Real>
auto interleave(const std::vector<Real>& x, const std::vector<Real>& y,
                const std::vector<Real>& z) {
  std::vector<Real> values(3 * x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    values[3 * i] = x[i], values[3 * i + 1] = y[i], values[3 * i + 2] = z[i];
  }
  return to_numpy(std::move(values), {x.size(), 3});
}

template <class Real>
GridFrame<Real> frame_of(const Vector& origin, double cell, const FloatGrid& values) {
  GridFrame<Real> frame;
  for (int a = 0; a < 3; ++a) {
    frame.origin[a] = static_cast<Real>(origin[a]);
    frame.shape[a] = static_cast<std::int64_t>(values.shape(a));
  }
  frame.inverse_cell = static_cast<Real>(1.0 / cell);
  return frame;
}

template <class Real>
void set_distance(DistanceField<Real>& field, const Vector& origin, double cell,
                  const FloatGrid& values) {
  field.frame = frame_of<Real>(origin, cell, values);
  field.value.assign(values.data(), values.data() + values.size());
}

template <class Real>
void add_particles(WcsphSolver<Real>& s, const Points& position, const Points& velocity) {
  for (std::size_t i = 0; i < position.shape(0); ++i) {
    s.particles.append(Real(position(i, 0)), Real(position(i, 1)), Real(position(i, 2)),
                       Real(velocity(i, 0)), Real(velocity(i, 1)), Real(velocity(i, 2)), Real(1),
                       s.source.next_id++);
  }
  s.stale = true;
}

template <class Real>
bool advance(WcsphSolver<Real>& s, double until, const Scalars& times, const Scalars& values,
             std::int64_t step_limit, double wall_limit) {
  const FlowSeries flow{times.data(), values.data(), std::min(times.size(), values.size())};
  nb::gil_scoped_release release;
  return s.advance(until, flow, step_limit, wall_limit);
}

// Names of the kept arrays, in the order of Particles::each_kept.
constexpr const char* kKeptNames[] = {
    "x",      "y",       "z",       "residue_x", "residue_y", "residue_z", "vx", "vy",     "vz",
    "weight", "built_x", "built_y", "built_z",   "density",   "pressure",  "id", "in_limb"};

// Everything that cannot be derived, by name.
template <class Real>
nb::dict kept_arrays(WcsphSolver<Real>& s) {
  nb::dict out;
  int k = 0;
  s.particles.each_kept([&](auto& a) {
    using T = typename std::remove_reference_t<decltype(a)>::value_type;
    out[kKeptNames[k++]] = nb::cast(to_numpy<T>(a, {a.size()}));
  });
  out["barrier_pressure"] =
      nb::cast(to_numpy(std::vector<Real>(s.barrier().pressure), {s.barrier().pressure.size()}));
  return out;
}

template <class Real>
void restore_arrays(WcsphSolver<Real>& s, const nb::dict& kept) {
  int k = 0;
  s.particles.each_kept([&](auto& a) {
    using T = typename std::remove_reference_t<decltype(a)>::value_type;
    auto values = nb::cast<nb::ndarray<const T, nb::ndim<1>, nb::c_contig>>(kept[kKeptNames[k++]]);
    a.assign(values.data(), values.data() + values.size());
  });
  using Kept = nb::ndarray<const Real, nb::ndim<1>, nb::c_contig>;
  const auto pressure = nb::cast<Kept>(kept["barrier_pressure"]);
  if (pressure.size() != s.barrier().size()) throw nb::value_error("another barrier");
  std::copy(pressure.data(), pressure.data() + pressure.size(), s.barrier().pressure.begin());
  s.resume();
}

template <class Real>
void bind_scene(nb::class_<WcsphSolver<Real>>& c) {
  using S = WcsphSolver<Real>;
  c.def("add_particles", &add_particles<Real>, "position"_a, "velocity"_a)
      .def("set_barrier",
           [](S& s, const Points& p) {
             s.set_barrier(component<Real>(p, 0), component<Real>(p, 1), component<Real>(p, 2));
           })
      .def("set_barrier_distance",
           [](S& s, Vector origin, double cell, const FloatGrid& values) {
             set_distance(s.barrier_distance, origin, cell, values);
             s.stale = true;
           })
      .def("set_limb_distance",
           [](S& s, Vector origin, double cell, const FloatGrid& values) {
             set_distance(s.limb_distance, origin, cell, values);
             s.stale = true;
           })
      .def("set_tissue",
           [](S& s, Vector origin, double cell, const FloatGrid& porosity,
              const FloatGrid& log_rate) {
             s.tissue.frame = frame_of<Real>(origin, cell, porosity);
             s.tissue.porosity.assign(porosity.data(), porosity.data() + porosity.size());
             s.tissue.log_rate.assign(log_rate.data(), log_rate.data() + log_rate.size());
             s.stale = true;
           })
      .def("set_platform",
           [](S& s, Vector point, Vector normal, Vector along, Vector across, double half_extent,
              double thickness) {
             const auto real = [](const Vector& v) {
               return std::array<Real, 3>{Real(v[0]), Real(v[1]), Real(v[2])};
             };
             s.platform = {true,         real(point),       real(normal),   real(along),
                           real(across), Real(half_extent), Real(thickness)};
             s.stale = true;
           })
      .def("set_periodic",
           [](S& s, int axis, double lower, double length) {
             s.periodicity.lower[axis] = Real(lower);
             s.periodicity.length[axis] = Real(length);
             s.stale = true;
           })
      .def("set_source",
           [](S& s, Vector center, double radius, double sensor_volume, std::uint64_t seed) {
             s.source.settings.enabled = true;
             s.source.settings.center = center;
             s.source.settings.radius = radius;
             s.source.settings.sensor_volume = sensor_volume;
             s.source.settings.seed = seed;
           })
      .def("set_domain",
           [](S& s, Vector lower, Vector upper) {
             s.domain_lower = lower;
             s.domain_upper = upper;
           })
      .def_rw("gravity", &S::gravity)
      .def_rw("threads", &S::threads);
}

template <class Real>
void bind_state(nb::class_<WcsphSolver<Real>>& c) {
  using S = WcsphSolver<Real>;
  const auto counted = [](std::vector<Real> v) {
    const std::size_t n = v.size();
    return to_numpy(std::move(v), {n});
  };
  c.def_prop_ro("count", [](S& s) { return s.particles.size(); })
      .def_prop_ro(
          "position", [](S& s) { return interleave(s.particles.x, s.particles.y, s.particles.z); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "velocity",
          [](S& s) { return interleave(s.particles.vx, s.particles.vy, s.particles.vz); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "acceleration",
          [](S& s) { return interleave(s.particles.ax, s.particles.ay, s.particles.az); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "density", [counted](S& s) { return counted(s.particles.density); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "pressure", [counted](S& s) { return counted(s.particles.pressure); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "weight", [counted](S& s) { return counted(s.particles.weight); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "porosity", [counted](S& s) { return counted(s.particles.porosity); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "drag_rate", [counted](S& s) { return counted(s.particles.drag); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "id",
          [](S& s) {
            return to_numpy(std::vector<std::int32_t>(s.particles.id), {s.particles.size()});
          },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "in_limb",
          [](S& s) {
            return to_numpy(std::vector<std::uint8_t>(s.particles.in_limb), {s.particles.size()});
          },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "barrier_position",
          [](S& s) { return interleave(s.barrier().x, s.barrier().y, s.barrier().z); },
          nb::rv_policy::automatic)
      .def_prop_ro(
          "barrier_weight", [counted](S& s) { return counted(s.barrier().weight); },
          nb::rv_policy::automatic)
      .def_prop_ro("memory_bytes", &S::memory_bytes)
      .def_prop_ro("next_step", &S::next_step)
      .def("kept_arrays", &kept_arrays<Real>)
      .def("restore_arrays", &restore_arrays<Real>);
}

template <class Real>
void bind_counters(nb::class_<WcsphSolver<Real>>& c) {
  using S = WcsphSolver<Real>;
  c.def_rw("time", &S::time)
      .def_rw("largest_speed", &S::largest_speed)
      .def_rw("largest_acceleration", &S::largest_acceleration)
      .def_rw("steps", &S::steps)
      .def_rw("particle_steps", &S::particle_steps)
      .def_rw("removed", &S::removed)
      .def_rw("crossings", &S::crossings)
      .def_rw("pushed", &S::pushed)
      .def_rw("searches", &S::searches)
      .def_rw("stale", &S::stale)
      .def_rw("list_margin", &S::list_margin)
      .def_prop_rw(
          "injected", [](S& s) { return s.source.injected; },
          [](S& s, double v) { s.source.injected = v; })
      .def_prop_rw(
          "pending", [](S& s) { return s.source.pending; },
          [](S& s, double v) { s.source.pending = v; })
      .def_prop_rw(
          "draws", [](S& s) { return s.source.draws; },
          [](S& s, std::int64_t v) { s.source.draws = v; })
      .def_prop_rw(
          "next_id", [](S& s) { return s.source.next_id; },
          [](S& s, std::int32_t v) { s.source.next_id = v; })
      .def_prop_rw(
          "pressure_time", [](S& s) { return s.source.pressure_time; },
          [](S& s, double v) { s.source.pressure_time = v; })
      .def_prop_rw(
          "sampled_time", [](S& s) { return s.source.sampled_time; },
          [](S& s, double v) { s.source.sampled_time = v; })
      .def_prop_ro("fault", [](S& s) { return s.fault.bits(); })
      .def_ro("fault_id", &S::fault_id)
      .def_ro("fault_position", &S::fault_position);
}

template <class Real>
void bind_solver(nb::module_& m, const char* name) {
  using S = WcsphSolver<Real>;
  nb::class_<S> c(m, name);
  c.def("__init__", [](S* self, const FluidSettings& settings) { new (self) S(settings); })
      .def("advance", &advance<Real>, "until"_a, "times"_a, "values"_a, "step_limit"_a,
           "wall_limit"_a)
      .def("evaluate", &S::evaluate, nb::call_guard<nb::gil_scoped_release>());
  bind_scene<Real>(c);
  bind_state<Real>(c);
  bind_counters<Real>(c);
}

void bind_settings(nb::module_& m) {
  using F = FluidSettings;
  nb::enum_<KernelSet>(m, "KernelSet")
      .value("MUELLER2003", KernelSet::kMueller2003)
      .value("WENDLAND_C2", KernelSet::kWendlandC2);
  nb::class_<F>(m, "FluidSettings")
      .def(nb::init<>())
      .def_rw("kernels", &F::kernels)
      .def_rw("spacing", &F::spacing)
      .def_rw("smoothing", &F::smoothing)
      .def_rw("sound_speed", &F::sound_speed)
      .def_rw("density", &F::density)
      .def_rw("viscosity", &F::viscosity)
      .def_rw("courant", &F::courant)
      .def_rw("fixed_step", &F::fixed_step)
      .def_rw("dissipation", &F::dissipation)
      .def_rw("clamped", &F::clamped)
      .def_rw("as_printed", &F::as_printed)
      .def_rw("density_scale", &F::density_scale)
      .def_rw("gradient_scale", &F::gradient_scale)
      .def_rw("laplacian_scale", &F::laplacian_scale)
      .def_rw("rest_density", &F::rest_density);
}

template <class Kernels>
Vector kernel_values(double r, double h) {
  const Kernels k(h);
  return {k.density(r * r) * k.density_factor,
          k.gradient_over_r(r, 1.0 / r) * k.gradient_factor * r,
          k.laplacian(r) * k.laplacian_factor};
}

template <class Kernels>
std::array<double, 4> lattice_values(double h, double dx) {
  const LatticeSums s = lattice_sums<Kernels>(h, dx);
  return {s.density, s.density_without_self, s.gradient, s.laplacian};
}

void bind_laws(nb::module_& m) {
  m.def("kernels_mueller2003", &kernel_values<MuellerKernels<double>>, "r"_a, "h"_a);
  m.def("kernels_wendland_c2", &kernel_values<WendlandKernels<double>>, "r"_a, "h"_a);
  m.def("lattice_sums_mueller2003", &lattice_values<MuellerKernels<double>>, "h"_a, "dx"_a);
  m.def("lattice_sums_wendland_c2", &lattice_values<WendlandKernels<double>>, "h"_a, "dx"_a);
  m.def("pressure_linear", &pressure_linear<double>);
  m.def("grain_diameter", &grain_diameter);
  m.def("drag_rate", &drag_rate<double>);
  m.def("brinkman_velocity", &brinkman_velocity<double>);
  m.attr("FREE_LOG_RATE") = TissueField<float>::kFree;
}

NodeGrid node_grid(const Vector& origin, double cell, const std::array<std::int64_t, 3>& shape) {
  return {origin, cell, shape};
}

std::vector<std::size_t> shape_of(const NodeGrid& g) {
  return {static_cast<std::size_t>(g.shape[0]), static_cast<std::size_t>(g.shape[1]),
          static_cast<std::size_t>(g.shape[2])};
}

void bind_grids(nb::module_& m) {
  m.def("nearest_distance", [](const FloatPoints& points, Vector origin, double cell,
                               std::array<std::int64_t, 3> shape, double reach) {
    const NodeGrid grid = node_grid(origin, cell, shape);
    std::vector<float> out(grid.count());
    {
      nb::gil_scoped_release release;
      nearest_distance(points.data(), points.shape(0), grid, reach, out.data());
    }
    return to_numpy(std::move(out), shape_of(grid));
  });
  m.def("tissue_fraction",
        [](const FloatPoints& points, const FloatScalars& volume, const FloatScalars& damage,
           Vector origin, double cell, std::array<std::int64_t, 3> shape, double reach) {
          const NodeGrid grid = node_grid(origin, cell, shape);
          std::vector<float> fraction(grid.count()), mean(grid.count());
          {
            nb::gil_scoped_release release;
            tissue_fraction(points.data(), volume.data(), damage.data(), points.shape(0), grid,
                            reach, fraction.data(), mean.data());
          }
          return nb::make_tuple(to_numpy(std::move(fraction), shape_of(grid)),
                                to_numpy(std::move(mean), shape_of(grid)));
        });
  m.def("sample_distance", [](const Points& points, Vector origin, double cell,
                              const FloatGrid& values) {
    DistanceField<double> field;
    set_distance(field, origin, cell, values);
    const std::size_t n = points.shape(0);
    std::vector<double> distance(n), normal(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
      distance[i] = field.sample(points(i, 0), points(i, 1), points(i, 2));
      const auto g = field.normal(points(i, 0), points(i, 1), points(i, 2));
      std::copy(g.begin(), g.end(), normal.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
    return nb::make_tuple(to_numpy(std::move(distance), {n}), to_numpy(std::move(normal), {n, 3}));
  });
  m.def("thin_points", [](const Points& points, double distance) {
    std::vector<std::int64_t> kept = thin_points(points.data(), points.shape(0), distance);
    const std::size_t n = kept.size();
    return to_numpy(std::move(kept), {n});
  });
}

}  // namespace

NB_MODULE(_native, m) {
  bind_settings(m);
  bind_solver<float>(m, "BleedingSolver32");
  bind_solver<double>(m, "BleedingSolver64");
  bind_laws(m);
  bind_grids(m);
  m.def("available_threads", []() { return omp_get_max_threads(); });
}
