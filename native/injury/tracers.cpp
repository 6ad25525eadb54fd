// Massless points that move with the material: the stations of the arteries' centre-lines.
#include <algorithm>
#include <cmath>

#include "injury/mpm_solver.hpp"
#include "injury/shape_function.hpp"

namespace vulnus::injury {

// Tracers move with the velocity of the nodes around them that have mass; where none has, they
// stand. Nodes behind a mirror are read at their images, where the mass is. The bodies are already
// at the end of the step.
template <class T>
void MpmSolver<T>::move_tracers(double dt) {
  const double dx = settings_.grid_spacing;
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < tracers_.size(); ++p) {
    Tracer& tracer = tracers_[p];
    std::int32_t base[3];
    double weight[3][3], velocity[3] = {0, 0, 0}, loaded = 0;
    for (int a = 0; a < 3; ++a) {
      const double cell = tracer.position[a] / dx;
      base[a] = static_cast<std::int32_t>(std::floor(cell - 0.5));
      quadratic_weights(cell - base[a], weight[a]);
    }
    for (int n = 0; n < 27; ++n) {
      std::int32_t x[3] = {base[0] + n / 9, base[1] + n / 3 % 3, base[2] + n % 3};
      double sign[3] = {1, 1, 1};
      for (const Mirror& mirror : mirrors_) {
        std::int32_t& along = x[mirror.axis];
        if ((along - mirror.node) * mirror.free_side >= 0) continue;
        along = 2 * mirror.node - along;
        sign[mirror.axis] = -1;
      }
      const int block = grid_.find(morton_key({x[0] >> 2, x[1] >> 2, x[2] >> 2}));
      if (block < 0) continue;
      const T* value =
          grid_.nodes(block) + ((x[0] & 3) << 4 | (x[1] & 3) << 2 | (x[2] & 3)) * kComponents;
      if (!(value[0] > T(0))) continue;
      const double w = weight[0][n / 9] * weight[1][n / 3 % 3] * weight[2][n % 3];
      loaded += w;
      for (int a = 0; a < 3; ++a) velocity[a] += w * sign[a] * value[1 + a];
    }
    if (loaded > 0)
      for (int a = 0; a < 3; ++a) tracer.position[a] += dt * velocity[a] / loaded;
    for (const RigidBody& body : bodies_)
      tracer.smallest_gap =
          std::min(tracer.smallest_gap, body.distance(tracer.position, time_ + dt));
  }
}

template void MpmSolver<float>::move_tracers(double);
template void MpmSolver<double>::move_tracers(double);

}  // namespace vulnus::injury
