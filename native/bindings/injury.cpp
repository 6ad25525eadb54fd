// Python face of the material point solver, for float32 (runs) and float64 (validation).
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "bindings/injury_bodies.hpp"
#include "injury/mpm_solver.hpp"
#include "injury/particle_readings.hpp"

namespace nb = nanobind;
using namespace vulnus;
using namespace vulnus::injury;

namespace {

template <class T>
using Array1 = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
template <class T>
using Array2 = nb::ndarray<const T, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
template <class T>
using Result = nb::ndarray<nb::numpy, T>;

template <class T>
Result<T> new_array(std::initializer_list<std::size_t> shape) {
  std::size_t size = 1;
  for (std::size_t s : shape) size *= s;
  T* data = new T[size]();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return Result<T>(data, shape, owner);
}

template <class T>
MaterialTable<T> make_table(Array2<double> rows) {
  if (rows.shape(0) < 1 || rows.shape(0) > kMaterialCapacity || rows.shape(1) != kMaterialColumns)
    throw std::invalid_argument("the material table needs 1 to 16 rows of 20 columns");
  MaterialTable<T> table;
  for (int c = 0; c < kMaterialColumns; ++c)
    for (int r = 0; r < kMaterialCapacity; ++r)
      table.column[c][r] = T(rows(std::min<std::size_t>(r, rows.shape(0) - 1), c));
  return table;
}

SolverSettings make_settings(double grid_spacing, double courant_number, Vec3 gravity,
                             Vec3 domain_lower, Vec3 domain_upper, double largest_step,
                             int passage_steps) {
  SolverSettings s;
  s.grid_spacing = grid_spacing;
  s.courant_number = courant_number;
  s.largest_step = largest_step;
  s.passage_steps = passage_steps;
  for (int a = 0; a < 3; ++a) {
    s.gravity[a] = gravity[a];
    s.domain_lower[a] = domain_lower[a];
    s.domain_upper[a] = domain_upper[a];
  }
  return s;
}

template <class T>
class Solver {
 public:
  Solver(Array2<double> materials, const SolverSettings& settings)
      : solver_(settings, make_table<T>(materials)), table_(make_table<double>(materials)) {}

  // Cauchy stress as xx yy zz xy yz zx [Pa] and volume ratio, in the particles' original order.
  Result<T> stress() {
    const auto& set = solver_.particles();
    auto out = new_array<T>({std::size_t(set.count()), kReadings});
    nb::gil_scoped_release release;
    read_stress(set, table_, out.data());
    return out;
  }
  std::array<double, 2> energies() {
    nb::gil_scoped_release release;
    const Energies e = sum_energies(solver_.particles(), table_);
    return {e.kinetic, e.elastic};
  }

  // New constants; `rescale` keeps the stress as it is, otherwise the strains stay (of a saved
  // run). Returns the elastic energy that the change has made [J].
  double set_materials(Array2<double> rows, bool rescale) {
    const MaterialTable<double> table = make_table<double>(rows);
    const MaterialTable<T> own = make_table<T>(rows);
    nb::gil_scoped_release release;
    auto& set = solver_.particles();
    double speed = solver_.largest_sound_speed(), made = 0;
    if (rescale) {
      made -= sum_energies(set, table_).elastic;
      speed = exchange_materials(set, table_, table);
      made += sum_energies(set, table).elastic;
    }
    solver_.set_materials(own, speed);
    table_ = table;
    return made;
  }

  // The largest principal strain that `set_materials` would leave.
  double largest_strain_with(Array2<double> rows) {
    const MaterialTable<double> table = make_table<double>(rows);
    nb::gil_scoped_release release;
    return largest_exchanged_strain(solver_.particles(), table_, table);
  }

  void make_particles(std::size_t n) { solver_.particles().reset(static_cast<int>(n)); }

  // The particles from number `first` on; in pieces, so that no whole copy stands in between.
  void set_particles(std::size_t first, Array2<double> position, Array2<double> velocity,
                     Array1<double> volume, Array1<std::uint8_t> material) {
    const std::size_t n = position.shape(0);
    auto& set = solver_.particles();
    if (velocity.shape(0) != n || volume.shape(0) != n || material.shape(0) != n ||
        position.shape(1) != 3 || velocity.shape(1) != 3 || first + n > set.id.size())
      throw std::invalid_argument("the particle arrays differ in length");
    for (std::size_t p = 0; p < n; ++p) {
      for (int a = 0; a < 3; ++a) {
        set.field[kPosition + a][first + p] = T(position(p, a));
        set.field[kVelocity + a][first + p] = T(velocity(p, a));
      }
      set.field[kVolume][first + p] = T(volume(p));
      set.material[first + p] = std::min<std::uint8_t>(material(p), kMaterialCapacity - 1);
    }
  }

  // Positions (count, 3) [m] in the particles' original order.
  Result<T> positions() {
    auto out = values(kPosition, 3);
    const T ahead = T(solver_.shown_ahead());
    const auto& set = solver_.particles();
    for (int p = 0; ahead != T(0) && p < set.places(); ++p)
      if (set.id[p] >= 0)
        for (int a = 0; a < 3; ++a)
          out.data()[std::size_t(set.id[p]) * 3 + a] -= ahead * set.field[kVelocity + a][p];
    return out;
  }

  // Values of consecutive fields in the particles' original order.
  Result<T> values(int first, int count) {
    const auto& set = solver_.particles();
    auto out = new_array<T>({std::size_t(set.count()), std::size_t(count)});
    for (int p = 0; p < set.places(); ++p)
      if (set.id[p] >= 0)
        for (int f = 0; f < count; ++f)
          out.data()[std::size_t(set.id[p]) * count + f] = set.field[first + f][p];
    return out;
  }
  void set_values(int first, Array2<double> in) {
    auto& set = solver_.particles();
    if (int(in.shape(0)) != set.count() || first + int(in.shape(1)) > kParticleFields)
      throw std::invalid_argument("the values do not fit the particles");
    for (int p = 0; p < set.places(); ++p)
      if (set.id[p] >= 0)
        for (std::size_t f = 0; f < in.shape(1); ++f) set.field[first + f][p] = T(in(set.id[p], f));
  }

  void set_tracers(Array2<double> position) {
    solver_.tracers().clear();
    for (std::size_t p = 0; p < position.shape(0); ++p)
      solver_.tracers().push_back({{position(p, 0), position(p, 1), position(p, 2)}, 1e30});
  }
  Result<double> tracer_state() {
    const auto& tracers = solver_.tracers();
    auto out = new_array<double>({tracers.size(), 4});
    for (std::size_t p = 0; p < tracers.size(); ++p) {
      for (int a = 0; a < 3; ++a) out.data()[4 * p + a] = tracers[p].position[a];
      out.data()[4 * p + 3] = tracers[p].smallest_gap;
    }
    return out;
  }

  Result<double> body_state() {
    const auto& bodies = solver_.bodies();
    auto out = new_array<double>({bodies.size(), kBodyValues});
    for (std::size_t k = 0; k < bodies.size(); ++k)
      std::memcpy(out.data() + k * kBodyValues, &bodies[k].state(), sizeof(BodyState));
    return out;
  }
  void set_body_state(Array2<double> rows) {
    auto& bodies = solver_.bodies();
    if (rows.shape(0) != bodies.size() || rows.shape(1) != kBodyValues)
      throw std::invalid_argument("the saved bodies do not fit this solver");
    for (std::size_t k = 0; k < bodies.size(); ++k)
      bodies[k].set_state(body_state_of(rows.data() + k * kBodyValues));
  }

  Result<T> state_fields() {
    const auto& set = solver_.particles();
    auto out = new_array<T>({kParticleFields, std::size_t(set.places())});
    for (int f = 0; f < kParticleFields; ++f)
      std::copy(set.field[f].begin(), set.field[f].end(),
                out.data() + std::size_t(f) * set.places());
    return out;
  }
  Result<std::int32_t> state_id() { return copy(solver_.particles().id); }
  Result<std::uint8_t> state_material() { return copy(solver_.particles().material); }

  void restore(Array2<T> fields, Array1<std::int32_t> id, Array1<std::uint8_t> material,
               Array2<double> tracers, double time, std::int64_t steps, double sound_speed) {
    const std::size_t places = id.shape(0);
    if (fields.shape(0) != kParticleFields || fields.shape(1) != places ||
        material.shape(0) != places || tracers.shape(1) != 4)
      throw std::invalid_argument("the saved state does not fit this solver");
    auto& set = solver_.particles();
    set.restore(places, fields.data(), id.data(), material.data());
    set_tracers(tracers);
    for (std::size_t p = 0; p < tracers.shape(0); ++p)
      solver_.tracers()[p].smallest_gap = tracers(p, 3);
    solver_.restore(time, steps, sound_speed);
  }

  nb::dict totals(bool grid) {
    const Totals t = grid ? solver_.grid_totals() : solver_.particle_totals();
    nb::dict d;
    d["mass"] = t.mass;
    d["momentum"] = nb::make_tuple(t.momentum[0], t.momentum[1], t.momentum[2]);
    d["angular_momentum"] =
        nb::make_tuple(t.angular_momentum[0], t.angular_momentum[1], t.angular_momentum[2]);
    d["kinetic_energy"] = t.kinetic_energy;
    return d;
  }

  MpmSolver<T>& native() { return solver_; }

 private:
  template <class V>
  Result<typename V::value_type> copy(const V& v) {
    auto out = new_array<typename V::value_type>({v.size()});
    std::copy(v.begin(), v.end(), out.data());
    return out;
  }

  MpmSolver<T> solver_;
  MaterialTable<double> table_;
};

template <class T>
void bind_solver(nb::module_& m, const char* name) {
  using S = Solver<T>;
  nb::class_<S>(m, name)
      .def(
          "__init__",
          [](S* self, Array2<double> materials, double grid_spacing, double courant_number,
             Vec3 gravity, Vec3 domain_lower, Vec3 domain_upper, double largest_step,
             int passage_steps) {
            new (self)
                S(materials, make_settings(grid_spacing, courant_number, gravity, domain_lower,
                                           domain_upper, largest_step, passage_steps));
          },
          nb::kw_only(), nb::arg("materials"), nb::arg("grid_spacing"), nb::arg("courant_number"),
          nb::arg("gravity"), nb::arg("domain_lower"), nb::arg("domain_upper"),
          nb::arg("largest_step"), nb::arg("passage_steps"))
      .def(
          "add_body",
          [](S& s, const BodyShape& shape, const RigidBody& body, Array1<double> state) {
            if (state.shape(0) != kBodyValues)
              throw std::invalid_argument("a body's state has another length");
            RigidBody added = body;
            added.shape = shape;
            added.set_state(body_state_of(state.data()));
            s.native().bodies().push_back(added);
          },
          nb::arg("shape"), nb::arg("body"), nb::arg("state"))
      .def(
          "add_boundary",
          [](S& s, int kind, Vec3 normal, double height, Vec3 velocity, double friction,
             double thickness, double rate, double exponent) {
            s.native().boundaries().push_back(make_half_space(kind, normal, height, velocity,
                                                              friction, thickness, rate, exponent));
          },
          nb::kw_only(), nb::arg("kind"), nb::arg("normal"), nb::arg("height"), nb::arg("velocity"),
          nb::arg("friction"), nb::arg("thickness"), nb::arg("rate"), nb::arg("exponent"))
      .def("clear_boundaries", [](S& s) { s.native().boundaries().clear(); })
      .def("body_state", &S::body_state)
      .def("set_body_state", &S::set_body_state)
      .def("make_particles", &S::make_particles)
      .def("set_particles", &S::set_particles)
      .def("values", &S::values)
      .def("set_values", &S::set_values)
      .def("set_tracers", &S::set_tracers)
      .def("tracer_state", &S::tracer_state)
      .def("state_fields", &S::state_fields)
      .def("state_id", &S::state_id)
      .def("state_material", &S::state_material)
      .def("restore", &S::restore)
      .def("positions", &S::positions)
      .def("stress", &S::stress)
      .def("energies", &S::energies)
      .def("set_materials", &S::set_materials, nb::arg("rows"), nb::kw_only(), nb::arg("rescale"))
      .def("largest_strain_with", &S::largest_strain_with)
      .def("totals", &S::totals, nb::kw_only(), nb::arg("grid"))
      .def("advance",
           [](S& s, int max_steps, double stop_time, double next_stop) {
             nb::gil_scoped_release release;
             return s.native().advance(max_steps, stop_time, next_stop);
           })
      .def("settle", [](S& s) { s.native().settle(); })
      .def("scatter_only", [](S& s, double dt) { s.native().scatter_only(dt); })
      .def("gather_only", [](S& s, double dt) { s.native().gather_only(dt); })
      .def_prop_ro("synchronized", [](S& s) { return s.native().synchronized(); })
      .def_prop_ro("time", [](S& s) { return s.native().time(); })
      .def_prop_ro("steps", [](S& s) { return s.native().steps(); })
      .def_prop_ro("step_size", [](S& s) { return s.native().step_size(); })
      .def_prop_ro("sound_speed", [](S& s) { return s.native().largest_sound_speed(); })
      .def_prop_ro("memory_bytes", [](S& s) { return s.native().memory_bytes(); })
      .def_prop_rw(
          "contact_iterations", [](S& s) { return s.native().settings().contact_iterations; },
          [](S& s, int most) { s.native().settings().contact_iterations = most; })
      .def_prop_ro("fault_bits", [](S& s) { return s.native().fault().bits(); })
      .def_prop_ro("fault_particle", [](S& s) { return s.native().fault().particle(); })
      .def_prop_ro("fault_body", [](S& s) { return s.native().faulty_body(); });
}

void bind_bodies(nb::module_& m) {
  nb::class_<BodyShape>(m, "BodyShape")
      .def_static("make", &make_shape, nb::kw_only(), nb::arg("radius"), nb::arg("expansion_speed"),
                  nb::arg("distance"), nb::arg("distance_lower"), nb::arg("distance_spacing"),
                  nb::arg("lower"), nb::arg("upper"), nb::arg("inner_radius"));
  nb::class_<RigidBody>(m, "RigidBody")
      .def_static("make", &make_body, nb::kw_only(), nb::arg("motion"), nb::arg("mass"),
                  nb::arg("inertia"), nb::arg("inverse_inertia"), nb::arg("friction"),
                  nb::arg("margin"), nb::arg("cutting"), nb::arg("rail"), nb::arg("path"));
}

constexpr std::size_t kPointValues = 15;  // of a material point, as `return_map` takes them

template <class R>
PointState<R> point_of(const R (&s)[kPointValues]) {
  return {{s[0], s[1], s[2], s[3], s[4], s[5]},
          {s[9], s[10], s[11], s[12], s[13], s[14]},
          s[6],
          s[7],
          s[8]};
}

// Runs the return map on points without a grid: rows of strain b_e - I (xx yy zz xy yz zx), plastic
// strain, opening, damage and network strain b - I in; the same after the return, the Kirchhoff
// stress and the square of the wave speed out.
template <class T>
Result<double> return_map(Array2<double> table, Array1<std::uint8_t> material, Array2<double> state,
                          Array1<double> rate) {
  using Real = typename LaneTraits<T>::Real;
  constexpr std::size_t width = LaneTraits<T>::kWidth, columns = kPointValues + 7;
  if (state.shape(1) != kPointValues || material.shape(0) != state.shape(0) ||
      rate.shape(0) != state.shape(0))
    throw std::invalid_argument("the points need 15 values, a material and a rate each");
  const MaterialTable<T> materials = make_table<T>(table);
  const std::size_t n = state.shape(0);
  auto out = new_array<double>({n, columns});
  for (std::size_t first = 0; first < n; first += width) {
    Real s[kPointValues], r;
    typename LaneTraits<T>::Integer index;
    for (std::size_t i = 0; i < width; ++i) {
      const std::size_t p = std::min(first + i, n - 1);
      for (std::size_t a = 0; a < kPointValues; ++a) s[a][i] = T(state(p, a));
      index[i] = std::min<std::uint8_t>(material(p), kMaterialCapacity - 1);
      r[i] = T(rate(p));
    }
    PointState<Real> point = point_of(s);
    const auto stress = update_stress(look_up_material(materials, index), r, point);
    const auto &e = point.strain, &b = point.network, &t = stress.kirchhoff;
    const Real column[columns] = {e.xx,
                                  e.yy,
                                  e.zz,
                                  e.xy,
                                  e.yz,
                                  e.zx,
                                  point.plastic_strain,
                                  point.opening,
                                  point.damage,
                                  b.xx,
                                  b.yy,
                                  b.zz,
                                  b.xy,
                                  b.yz,
                                  b.zx,
                                  t.xx,
                                  t.yy,
                                  t.zz,
                                  t.xy,
                                  t.yz,
                                  t.zx,
                                  stress.sound_speed_squared};
    for (std::size_t i = 0; i < width && first + i < n; ++i)
      for (std::size_t a = 0; a < columns; ++a)
        out.data()[(first + i) * columns + a] = column[a][i];
  }
  return out;
}

}  // namespace

NB_MODULE(_native, m) {
  bind_bodies(m);
  bind_solver<float>(m, "Solver32");
  bind_solver<double>(m, "Solver64");
  m.def("return_map32", &return_map<float>);
  m.def("return_map64", &return_map<double>);
  m.def("set_num_threads", [](int n) { omp_set_num_threads(n > 0 ? n : omp_get_num_procs()); });
}
