// Rigid bodies and boundaries of the material point solver, from Python's arrays and back.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "injury/boundary.hpp"
#include "injury/rigid_body.hpp"

namespace vulnus::injury {

using Vec3 = std::array<double, 3>;
using RowsOfDouble =
    nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>;
using DistanceValues =
    nanobind::ndarray<const float, nanobind::ndim<3>, nanobind::c_contig, nanobind::device::cpu>;

// A sphere of `radius`, or with radius 0 the grid `distance` with its first point and spacing.
inline BodyShape make_shape(double radius, double expansion_speed, DistanceValues distance,
                            Vec3 distance_lower, double distance_spacing, Vec3 lower, Vec3 upper,
                            double inner_radius) {
  BodyShape shape;
  shape.radius = radius;
  shape.expansion_speed = expansion_speed;
  shape.inner_radius = inner_radius;
  std::copy(lower.begin(), lower.end(), shape.lower);
  std::copy(upper.begin(), upper.end(), shape.upper);
  if (shape.is_sphere()) return shape;
  for (int a = 0; a < 3; ++a) {
    if (distance.shape(a) < 2)
      throw std::invalid_argument("a distance grid needs 2 points an axis");
    shape.grid.count[a] = static_cast<int>(distance.shape(a));
    shape.grid.lower[a] = distance_lower[a];
  }
  shape.grid.spacing = distance_spacing;
  shape.grid.value.assign(distance.data(), distance.data() + distance.size());
  return shape;
}

inline void copy_matrix(RowsOfDouble in, double (&out)[3][3]) {
  if (in.shape(0) != 3 || in.shape(1) != 3) throw std::invalid_argument("an inertia is 3 by 3");
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[i][j] = in(i, j);
}

// What a body is apart from its shape and its state.
inline RigidBody make_body(int motion, double mass, RowsOfDouble inertia,
                           RowsOfDouble inverse_inertia, double friction, double margin,
                           bool cutting, Vec3 rail, RowsOfDouble path) {
  RigidBody body;
  body.motion = static_cast<BodyMotion>(motion);
  body.mass = mass;
  copy_matrix(inertia, body.inertia);
  copy_matrix(inverse_inertia, body.inverse_inertia);
  body.friction = friction;
  body.margin = margin;
  body.cutting = cutting;
  for (int a = 0; a < 3; ++a) body.on_rail = body.on_rail || rail[a] != 0;
  if (body.on_rail) std::copy(rail.begin(), rail.end(), body.rail);
  if (path.shape(1) != 4) throw std::invalid_argument("a path has rows of time and place");
  for (std::size_t k = 0; k < path.shape(0); ++k) {
    body.path_time.push_back(path(k, 0));
    for (int a = 0; a < 3; ++a) body.path_position.push_back(path(k, 1 + a));
  }
  return body;
}

inline BodyState body_state_of(const double* row) {
  BodyState state;
  std::memcpy(static_cast<void*>(&state), row, sizeof(state));
  return state;
}

inline HalfSpace make_half_space(int kind, Vec3 normal, double height, Vec3 velocity,
                                 double friction, double thickness, double rate, double exponent) {
  HalfSpace wall;
  wall.kind = static_cast<BoundaryKind>(kind);
  wall.height = height;
  wall.friction = friction;
  wall.thickness = thickness;
  wall.rate = rate;
  wall.exponent = exponent;
  std::copy(normal.begin(), normal.end(), wall.normal);
  std::copy(velocity.begin(), velocity.end(), wall.velocity);
  return wall;
}

}  // namespace vulnus::injury
