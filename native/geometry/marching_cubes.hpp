// Marching cubes (Lorensen & Cline 1987) on the zero level of a sparse level set.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/level_set.hpp"

namespace vulnus::geometry {

struct Mesh {
  std::vector<float> vertices;          // 3 a vertex [m]
  std::vector<std::int32_t> triangles;  // 3 a triangle, counter-clockwise seen from outside
};

// One vertex on each grid edge that changes sign, shared by all its triangles: the mesh is closed
// and every edge belongs to exactly two triangles. Vertices come in the order of blocks.
Mesh marching_cubes(const LevelSet& set);

}  // namespace vulnus::geometry
