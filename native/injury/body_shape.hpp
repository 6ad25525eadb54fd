// The shape of a rigid body in its own frame, whose origin is the centre of mass: a sphere, or a
// signed distance sampled on a dense grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace vulnus::injury {

// Signed distance [m], negative inside, at points lower + spacing * (i, j, k); k runs fastest.
struct DistanceGrid {
  int count[3] = {0, 0, 0};
  double lower[3] = {0, 0, 0};
  double spacing = 1;
  std::vector<float> value;

  // Trilinear; beyond the grid the distance to it is added.
  double at(const double (&p)[3]) const {
    int first[3];
    double part[3], beyond = 0;
    for (int a = 0; a < 3; ++a) {
      const double cell = (p[a] - lower[a]) / spacing;
      const double inside = std::min(std::max(cell, 0.0), double(count[a] - 1));
      first[a] = std::min(static_cast<int>(inside), count[a] - 2);
      part[a] = inside - first[a];
      beyond += (cell - inside) * (cell - inside);
    }
    double sum = 0;
    for (int n = 0; n < 8; ++n) {
      const int x = n >> 2, y = n >> 1 & 1, z = n & 1;
      const std::size_t index =
          (std::size_t(first[0] + x) * count[1] + first[1] + y) * count[2] + first[2] + z;
      sum += (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) *
             (z ? part[2] : 1 - part[2]) * value[index];
    }
    return sum + spacing * std::sqrt(beyond);
  }
};

// Slope below which a point lies on the ridge between two faces.
constexpr double kRidge = 0.5;

struct BodyShape {
  double radius = 0;           // of a sphere; 0: the grid counts
  double expansion_speed = 0;  // growth of the sphere's radius [m/s]
  DistanceGrid grid;
  double lower[3] = {0, 0, 0};  // box around the shape at time 0
  double upper[3] = {0, 0, 0};
  double inner_radius = 0;  // largest depth inside [m]

  bool is_sphere() const { return radius > 0; }
  double growth(double time) const { return expansion_speed * time; }

  double distance(const double (&p)[3], double time) const {
    if (is_sphere())
      return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - radius - growth(time);
    return grid.at(p);
  }

  // Outward unit normal at p, zero where there is none (the centre of a sphere). Returns whether p
  // lies on the ridge between two faces, where the opposite is as good a normal.
  bool normal(const double (&p)[3], double (&n)[3]) const {
    bool ridge = false;
    if (is_sphere()) {
      for (int a = 0; a < 3; ++a) n[a] = p[a];
    } else {
      gradient(p, grid.spacing, n);
      ridge = n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < kRidge * kRidge;
      if (ridge) gradient(p, 0, n);
    }
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int a = 0; a < 3; ++a) n[a] = length > 0 ? n[a] / length : 0;
    return ridge;
  }

 private:
  // Difference quotients over the grid's spacing and `back` behind; with back = 0 they see one side
  // of a ridge, such as the middle plane of a plate.
  void gradient(const double (&p)[3], double back, double (&n)[3]) const {
    for (int a = 0; a < 3; ++a) {
      double above[3] = {p[0], p[1], p[2]}, below[3] = {p[0], p[1], p[2]};
      above[a] += grid.spacing;
      below[a] -= back;
      n[a] = (grid.at(above) - grid.at(below)) / (grid.spacing + back);
    }
  }
};

}  // namespace vulnus::injury
