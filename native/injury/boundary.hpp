// Boundaries: half spaces in which nodes are held, kept from crossing, or calmed.
#pragma once

#include <algorithm>
#include <cmath>

#include "injury/contact_law.hpp"

namespace vulnus::injury {

enum class BoundaryKind : int {
  kFixed = 0,       // nodes have the boundary's velocity
  kSlip = 1,        // their normal velocity is the boundary's
  kSeparating = 2,  // they may leave, not enter; Coulomb friction while they press
  kAbsorbing = 3    // damped, from a layer before the plane on
};

// Acts on nodes with x . normal <= height; the plane moves with its velocity.
struct HalfSpace {
  BoundaryKind kind = BoundaryKind::kFixed;
  double normal[3] = {0, 0, 1};  // unit, towards the free side
  double height = -1e30;         // at time 0 [m], in the solver's local frame
  double velocity[3] = {0, 0, 0};
  double friction = 0;
  double thickness = 0;  // of the damped layer before the plane [m]
  double rate = 0;       // damping at the plane and beyond [1/s]
  double exponent = 0;   // of the depth in the layer

  double height_at(double time) const {
    return height +
           time * (normal[0] * velocity[0] + normal[1] * velocity[1] + normal[2] * velocity[2]);
  }
};

// Velocity of a node `above` [m] the half space's plane after a step.
template <class T>
VULNUS_HD void constrain(const HalfSpace& wall, double above, double dt, T (&v)[3]) {
  if (above > wall.thickness) return;
  if (wall.kind == BoundaryKind::kAbsorbing) {  // rate ~ depth^n, implicit in time
    const double depth = std::min((wall.thickness - above) / wall.thickness, 1.0);
    const T kept = T(1 / (1 + wall.rate * std::pow(depth, wall.exponent) * dt));
    for (int a = 0; a < 3; ++a) v[a] *= kept;
    return;
  }
  const T u[3] = {T(wall.velocity[0]), T(wall.velocity[1]), T(wall.velocity[2])};
  const T n[3] = {T(wall.normal[0]), T(wall.normal[1]), T(wall.normal[2])};
  if (wall.kind == BoundaryKind::kSeparating) {
    contact_velocity(u, n, T(wall.friction), v);
  } else if (wall.kind == BoundaryKind::kSlip) {
    const T approach = (v[0] - u[0]) * n[0] + (v[1] - u[1]) * n[1] + (v[2] - u[2]) * n[2];
    for (int a = 0; a < 3; ++a) v[a] -= approach * n[a];
  } else {
    for (int a = 0; a < 3; ++a) v[a] = u[a];
  }
}

}  // namespace vulnus::injury
