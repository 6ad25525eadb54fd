#include "geometry/cube_cases.hpp"

#include <cstdlib>

namespace vulnus::geometry {

namespace {

constexpr int kLongestPolygon = 7;  // over all 256 cases

bool is_inside(int signs, int corner) { return signs >> corner & 1; }

}  // namespace

const CubeCases& CubeCases::table() {
  static const CubeCases cases;
  return cases;
}

int CubeCases::edge_between(int a, int b) const {
  for (int e = 0; e < 12; ++e) {
    const CubeEdge& edge = edges_[static_cast<std::size_t>(e)];
    if ((edge.start == a && edge.end == b) || (edge.start == b && edge.end == a)) return e;
  }
  std::abort();  // a and b are not neighbours: cannot happen for corners of one face
}

bool CubeCases::share_face(int e, int f) const {
  const CubeEdge& p = edges_[static_cast<std::size_t>(e)];
  const CubeEdge& q = edges_[static_cast<std::size_t>(f)];
  const int all_set = p.start & p.end & q.start & q.end;
  const int all_clear = ~(p.start | p.end | q.start | q.end) & 7;
  return all_set != 0 || all_clear != 0;
}

// Cuts ears whose diagonal leaves the cube's faces until a triangle is left.
void CubeCases::add_polygon(CubeCase& out, const int* polygon, int count) const {
  std::array<int, kLongestPolygon> rest{};
  for (int v = 0; v < count; ++v) rest[static_cast<std::size_t>(v)] = polygon[v];
  auto at = [&](int v) { return rest[static_cast<std::size_t>(v % count)]; };
  auto add = [&](int a, int b, int c) {
    const std::size_t base = static_cast<std::size_t>(3 * out.triangle_count++);
    out.edge[base] = static_cast<std::int8_t>(a);
    out.edge[base + 1] = static_cast<std::int8_t>(b);
    out.edge[base + 2] = static_cast<std::int8_t>(c);
  };
  while (count > 3) {
    int ear = 0;
    while (ear < count && share_face(at(ear), at(ear + 2))) ++ear;
    if (ear == count) std::abort();  // does not happen in any case
    add(at(ear), at(ear + 1), at(ear + 2));
    for (int v = (ear + 1) % count; v + 1 < count; ++v) {
      rest[static_cast<std::size_t>(v)] = rest[static_cast<std::size_t>(v) + 1];
    }
    --count;
  }
  add(at(0), at(1), at(2));
}

CubeCases::CubeCases() {
  int next_edge = 0, next_face = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int bit = 4 >> axis, u = 4 >> (axis + 1) % 3, v = 4 >> (axis + 2) % 3;
    for (int corner = 0; corner < 8; ++corner) {
      if (corner & bit) continue;
      edges_[static_cast<std::size_t>(next_edge++)] = {static_cast<std::int8_t>(corner),
                                                       static_cast<std::int8_t>(corner | bit),
                                                       static_cast<std::int8_t>(axis)};
    }
    faces_[static_cast<std::size_t>(next_face++)] = {v, u | v, u, 0};
    faces_[static_cast<std::size_t>(next_face++)] = {bit, bit | u, bit | u | v, bit | v};
  }
  for (int signs = 0; signs < 256; ++signs) {
    std::array<int, 12> successor;
    successor.fill(-1);
    for (const auto& face : faces_) {
      for (int i = 0; i < 4; ++i) {
        auto corner = [&](int c) { return face[static_cast<std::size_t>(c & 3)]; };
        if (!is_inside(signs, corner(i)) || is_inside(signs, corner(i + 1))) continue;
        int j = i;  // back to where this run of inside corners begins
        while (is_inside(signs, corner(j))) j += 3;
        successor[static_cast<std::size_t>(edge_between(corner(j), corner(j + 1)))] =
            edge_between(corner(i), corner(i + 1));
      }
    }
    for (int e = 0; e < 12; ++e) {
      std::array<int, kLongestPolygon> polygon{};
      int count = 0;
      for (int f = e; successor[static_cast<std::size_t>(f)] >= 0;) {
        polygon[static_cast<std::size_t>(count++)] = f;
        const int following = successor[static_cast<std::size_t>(f)];
        successor[static_cast<std::size_t>(f)] = -1;
        f = following;
      }
      if (count) add_polygon(cases_[static_cast<std::size_t>(signs)], polygon.data(), count);
    }
  }
}

}  // namespace vulnus::geometry
