// Python's view of the level set, marching cubes and Poisson-disk sampling. Arrays arrive checked
// (shape, type, contiguity) from vulnus.geometry; every call releases the GIL.

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"  // in nanobind's own headers
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#pragma GCC diagnostic pop
#include <omp.h>

#include <algorithm>

#include "geometry/level_set.hpp"
#include "geometry/marching_cubes.hpp"
#include "geometry/poisson_disk.hpp"
#include "geometry/shapes.hpp"

namespace nb = nanobind;
using namespace vulnus::geometry;

namespace {

using Vectors = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Scalars = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Floats = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Grid = nb::ndarray<const float, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::shape<3, 4>, nb::c_contig, nb::device::cpu>;
using Triple = std::tuple<double, double, double>;

Point to_point(const Triple& t) { return {std::get<0>(t), std::get<1>(t), std::get<2>(t)}; }

// Hands a vector's memory to NumPy, `columns` wide (0: one-dimensional).
template <typename T>
nb::ndarray<nb::numpy, T> give(std::vector<T>&& values, std::size_t columns) {
  auto* kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  if (columns == 0) return nb::ndarray<nb::numpy, T>(kept->data(), {kept->size()}, owner);
  return nb::ndarray<nb::numpy, T>(kept->data(), {kept->size() / columns, columns}, owner);
}

auto sample(const LevelSet& set, const Vectors& points) {
  std::vector<float> out(points.shape(0));
  {
    nb::gil_scoped_release release;
    const double* p = points.data();
#pragma omp parallel for schedule(static)
    for (std::int64_t n = 0; n < static_cast<std::int64_t>(out.size()); ++n) {
      out[static_cast<std::size_t>(n)] = set.sample({p[3 * n], p[3 * n + 1], p[3 * n + 2]});
    }
  }
  return give(std::move(out), 0);
}

auto gradient(const LevelSet& set, const Vectors& points) {
  std::vector<double> out(3 * points.shape(0));
  {
    nb::gil_scoped_release release;
    const double* p = points.data();
#pragma omp parallel for schedule(static)
    for (std::int64_t n = 0; n < static_cast<std::int64_t>(points.shape(0)); ++n) {
      const Point g = set.gradient({p[3 * n], p[3 * n + 1], p[3 * n + 2]});
      double* o = &out[static_cast<std::size_t>(3 * n)];
      o[0] = g.x, o[1] = g.y, o[2] = g.z;
    }
  }
  return give(std::move(out), 3);
}

auto surface(const LevelSet& set) {
  Mesh mesh;
  {
    nb::gil_scoped_release release;
    mesh = marching_cubes(set);
  }
  return std::make_tuple(give(std::move(mesh.vertices), 3), give(std::move(mesh.triangles), 3));
}

LevelSet from_field(const Grid& field, const Matrix& to_index, double voxel, double half_width,
                    const Triple& low, const Triple& high) {
  DenseField dense{field.data(),
                   static_cast<std::int64_t>(field.shape(0)),
                   static_cast<std::int64_t>(field.shape(1)),
                   static_cast<std::int64_t>(field.shape(2)),
                   {}};
  std::copy_n(to_index.data(), 12, dense.to_index);
  nb::gil_scoped_release release;
  return resample(dense, voxel, half_width, to_point(low), to_point(high));
}

auto weights(const Vectors& centres, double reach, double full) {
  std::vector<float> out(centres.shape(0));
  {
    nb::gil_scoped_release release;
    neighbour_weights(centres.data(), static_cast<std::int64_t>(centres.shape(0)), reach, full,
                      out.data());
  }
  return give(std::move(out), 0);
}

// Index bounds of the voxels of all blocks and tiles: low (3), high (3), inclusive.
std::vector<std::int64_t> index_bounds(const LevelSet& set) {
  std::vector<std::int64_t> box{INT32_MAX, INT32_MAX, INT32_MAX, INT32_MIN, INT32_MIN, INT32_MIN};
  set.map.for_each([&](const BlockCoordinate& b, std::int32_t) {
    const std::int64_t at[3] = {b.x, b.y, b.z};
    for (std::size_t a = 0; a < 3; ++a) {
      box[a] = std::min(box[a], at[a] * kSide);
      box[a + 3] = std::max(box[a + 3], at[a] * kSide + kSide - 1);
    }
  });
  return box;
}

auto block_arrays(const LevelSet& set) {
  std::vector<std::int32_t> at;
  for (const BlockCoordinate& b : set.blocks) at.insert(at.end(), {b.x, b.y, b.z});
  std::vector<float> values = set.values;
  return std::make_tuple(give(std::move(at), 3), give(std::move(values), kBlock));
}

}  // namespace

NB_MODULE(_native, m) {
  m.doc() = "Native sparse level sets, marching cubes and Poisson-disk sampling.";
  using namespace nb::literals;
  const auto quietly = nb::call_guard<nb::gil_scoped_release>();

  nb::class_<LevelSet>(m, "LevelSet")
      .def_static(
          "union_of_spheres",
          [](const Vectors& centres, const Scalars& radii, const Floats& weight, double voxel,
             double half_width) {
            return union_of_spheres(centres.data(), radii.data(),
                                    static_cast<std::int64_t>(centres.shape(0)),
                                    weight.shape(0) ? weight.data() : nullptr, voxel, half_width);
          },
          "centres"_a, "radii"_a, "weights"_a, "voxel"_a, "half_width"_a, quietly)
      .def_static(
          "tube",
          [](const Vectors& points, const Scalars& radii, double voxel, double half_width) {
            return tube(points.data(), radii.data(), static_cast<std::int64_t>(points.shape(0)),
                        voxel, half_width);
          },
          "points"_a, "radii"_a, "voxel"_a, "half_width"_a, quietly)
      .def_static("from_field", &from_field, "field"_a, "to_index"_a, "voxel"_a, "half_width"_a,
                  "low"_a, "high"_a)
      .def(
          "copy", [](const LevelSet& set) { return LevelSet(set); }, quietly)
      .def("prune", &LevelSet::prune, quietly)
      .def(
          "offset",
          [](LevelSet& set, float distance) {
            for (float& phi : set.values) {
              phi = std::clamp(phi - distance, -set.background, set.background);
            }
            set.prune();
          },
          "distance"_a, quietly)
      .def(
          "united",
          [](const LevelSet& a, const LevelSet& b) { return combine(a, b, Combination::kUnion); },
          quietly)
      .def(
          "intersected",
          [](const LevelSet& a, const LevelSet& b) {
            return combine(a, b, Combination::kIntersection);
          },
          quietly)
      .def(
          "without",
          [](const LevelSet& a, const LevelSet& b) {
            return combine(a, b, Combination::kDifference);
          },
          quietly)
      .def("limited", &limited, "reference"_a, "limit"_a, quietly)
      .def(
          "cut",
          [](const LevelSet& set, const Triple& normal, double offset) {
            return cut(set, to_point(normal), offset);
          },
          "normal"_a, "offset"_a, quietly)
      .def("sample", &sample, "points"_a)
      .def("gradient", &gradient, "points"_a)
      .def("surface", &surface)
      .def("volume", &LevelSet::volume, quietly)
      .def("index_bounds", &index_bounds)
      .def("block_arrays", &block_arrays)
      .def_prop_ro("voxel", [](const LevelSet& set) { return set.voxel; })
      .def_prop_ro("background", [](const LevelSet& set) { return set.background; })
      .def_prop_ro("block_count", &LevelSet::block_count)
      .def_prop_ro("memory_bytes", &LevelSet::memory_bytes);

  nb::class_<BandFlow>(m, "BandFlow")
      .def(nb::init<LevelSet&>(), "level_set"_a, nb::keep_alive<1, 2>())
      .def("curvature_step", &BandFlow::curvature_step, quietly)
      .def("redistance_step", &BandFlow::redistance_step, "courant"_a, quietly);

  nb::class_<PoissonDiskSampler>(m, "PoissonDiskSampler")
      .def(
          "__init__",
          [](PoissonDiskSampler* self, const LevelSet& domain, double spacing, std::uint64_t seed,
             const Triple& low, const Triple& high) {
            new (self) PoissonDiskSampler(domain, spacing, seed, to_point(low), to_point(high));
          },
          "domain"_a, "spacing"_a, "seed"_a, "low"_a, "high"_a, nb::keep_alive<1, 2>())
      .def("advance", &PoissonDiskSampler::advance, "parents"_a, quietly)
      .def_prop_ro("count", &PoissonDiskSampler::count)
      .def("points",
           [](const PoissonDiskSampler& s) { return give(std::vector<float>(s.points()), 3); });

  m.def("neighbour_weights", &weights, "centres"_a, "reach"_a, "full"_a);
  m.def("set_thread_count", [](int count) { omp_set_num_threads(count); }, "count"_a);
}
