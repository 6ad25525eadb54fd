// The 256 sign patterns of a cube's corners and the triangles of each, made by rule, not by hand.
//
// Corner c of the cube lies at (c >> 2, c >> 1 & 1, c & 1). Its bit in the case is set where phi <
// 0. Faces with two inside corners on a diagonal separate them, on both sides of the face alike, so
// there are no holes; polygons are cut along diagonals that do not lie in a face of the cube, so no
// edge gets four triangles (checked for all cases by the constructor's assertion and the tests).
#pragma once

#include <array>
#include <cstdint>

namespace vulnus::geometry {

struct CubeEdge {
  std::int8_t start, end, axis;  // corners (start below end), direction 0-2
};

struct CubeCase {
  std::int8_t triangle_count = 0;
  std::array<std::int8_t, 15> edge{};  // three a triangle
};

class CubeCases {
 public:
  static const CubeCases& table();
  const CubeCase& operator[](int signs) const { return cases_[static_cast<std::size_t>(signs)]; }
  const CubeEdge& edge(int e) const { return edges_[static_cast<std::size_t>(e)]; }

 private:
  CubeCases();
  int edge_between(int a, int b) const;
  bool share_face(int e, int f) const;
  void add_polygon(CubeCase& out, const int* polygon, int count) const;

  std::array<CubeEdge, 12> edges_;
  std::array<std::array<int, 4>, 6> faces_;  // corners counter-clockwise from outside
  std::array<CubeCase, 256> cases_;
};

}  // namespace vulnus::geometry
