// Constructors of level sets: unions of spheres and of tapered tubes, dense fields on oblique
// grids, half-spaces.
#pragma once

#include <cstdint>

#include "geometry/level_set.hpp"

namespace vulnus::geometry {

struct Sphere {
  Point centre;
  double radius;
};

// A piece of a tube: the radius changes linearly from one end to the other.
struct Cone {
  Point start, end;
  double radius_start, radius_end;
};

// `weights` (count) or null: the curvature flow's weight of each sphere.
LevelSet union_of_spheres(const double* centres, const double* radii, std::int64_t count,
                          const float* weights, double voxel, double half_width);

// Chain of `count` points with radii: count - 1 cones, or one sphere.
LevelSet tube(const double* points, const double* radii, std::int64_t count, double voxel,
              double half_width);

// phi [m] on an (nx, ny, nz) grid, z fastest. A point p of the patient frame has the grid index
// `to_index` (3x4, row major) times (p, 1). Beyond the grid the nearest value holds.
struct DenseField {
  const float* phi;
  std::int64_t nx, ny, nz;
  double to_index[12];
};

LevelSet resample(const DenseField& field, double voxel, double half_width, const Point& low,
                  const Point& high);

// `set` cut by the half-space normal . p <= offset (unit normal).
LevelSet cut(const LevelSet& set, const Point& normal, double offset);

// Smooth number of neighbours: 0 for a sphere alone, 1 for one with `full` others within `reach`.
void neighbour_weights(const double* centres, std::int64_t count, double reach, double full,
                       float* weights);

}  // namespace vulnus::geometry
