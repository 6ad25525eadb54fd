// What happens on the grid between scatter and gather: tiles are summed, momentum becomes velocity,
// and bodies and boundaries have their say.
#include <algorithm>
#include <cmath>

#include "injury/mpm_solver.hpp"

namespace vulnus::injury {

template <class T>
double MpmSolver<T>::update_grid(double dt) {
  double largest = 0;
#pragma omp parallel for schedule(dynamic, 8) reduction(max : largest)
  for (int i = 0; i < grid_.active(); ++i) largest = std::max(largest, update_block(i, dt));
  return std::sqrt(largest);
}

// Momentum to velocity, gravity (equation 1), then the held ends and the projectile; returns the
// largest squared speed.
template <class T>
double MpmSolver<T>::update_block(int i, double dt) {
  grid_.reduce(i);
  T* node = grid_.nodes(i);
  const T kick[3] = {T(dt * settings_.gravity[0]), T(dt * settings_.gravity[1]),
                     T(dt * settings_.gravity[2])};
  for (int n = 0; n < kBlockNodes; ++n) {
    T* value = node + n * kComponents;
    const T inverse = value[0] > T(0) ? T(1) / value[0] : T(0);
    const T loaded = value[0] > T(0) ? T(1) : T(0);
    for (int a = 0; a < 3; ++a) value[1 + a] = value[1 + a] * inverse + loaded * kick[a];
  }
  collide_block(i);
  T largest = 0;
  for (int n = 0; n < kBlockNodes; ++n) {
    const T* v = node + n * kComponents + 1;
    largest = std::max(largest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return largest;
}

template <class T>
void MpmSolver<T>::collide_block(int i) {
  const double dx = settings_.grid_spacing;
  const BlockIndex b = grid_.block(i);
  const double corner[3] = {b.x * kBlockEdge * dx, b.y * kBlockEdge * dx, b.z * kBlockEdge * dx};
  const double* axis = settings_.held_axis;
  const Sphere& sphere = settings_.sphere;
  double centre[3], along = 0, apart = 0;
  for (int a = 0; a < 3; ++a) {
    const double middle = corner[a] + 1.5 * dx;
    along += axis[a] * middle;
    centre[a] = sphere.centre[a] + sphere.velocity[a] * time_;
    apart += (middle - centre[a]) * (middle - centre[a]);
  }
  const double reach = 2.6 * dx;  // half of a block's diagonal: sqrt(3) 1.5 dx
  const bool hit = sphere.radius > 0 && std::sqrt(apart) < sphere.radius + reach;
  const bool held = along - reach < settings_.held_below || along + reach > settings_.held_above;
  if (!hit && !held) return;
  for (int n = 0; n < kBlockNodes; ++n) {
    const int index[3] = {n >> 4, n >> 2 & 3, n & 3};
    T* value = grid_.nodes(i) + n * kComponents;
    if (!(value[0] > T(0))) continue;
    T offset[3], v[3];
    double height = 0;
    for (int a = 0; a < 3; ++a) {
      const double x = corner[a] + index[a] * dx;
      height += axis[a] * x;
      offset[a] = T(x - centre[a]);
      v[a] = value[1 + a];
    }
    if (hit) contact_sphere(sphere, offset, v);
    const T free = height < settings_.held_below || height > settings_.held_above ? T(0) : T(1);
    for (int a = 0; a < 3; ++a) value[1 + a] = free * v[a];
  }
}

template double MpmSolver<float>::update_grid(double);
template double MpmSolver<double>::update_grid(double);
template double MpmSolver<float>::update_block(int, double);
template double MpmSolver<double>::update_block(int, double);
template void MpmSolver<float>::collide_block(int);
template void MpmSolver<double>::collide_block(int);

}  // namespace vulnus::injury
