// Contact of grid nodes with a rigid sphere that keeps its velocity (Chong et al. 2017, 2.2).
#pragma once

#include <cmath>

#include "core/host_device.hpp"

namespace vulnus::injury {

struct Sphere {
  double centre[3] = {0, 0, 0};  // at time 0 [m], in the solver's local frame
  double velocity[3] = {0, 0, 0};
  double radius = 0;  // 0: no projectile
  double friction = 0;
};

// Velocity of a node at `offset` from the sphere's centre after contact: nodes inside that approach
// the surface lose the approaching part, and Coulomb friction brakes the sliding part; separation
// is free.
template <class T>
VULNUS_HD void contact_sphere(const Sphere& sphere, const T (&offset)[3], T (&v)[3]) {
  const T distance =
      std::sqrt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
  if (distance >= T(sphere.radius) || distance <= T(0)) return;
  T relative[3], normal_speed = 0;
  for (int a = 0; a < 3; ++a) {
    relative[a] = v[a] - T(sphere.velocity[a]);
    normal_speed += relative[a] * offset[a] / distance;
  }
  if (normal_speed >= T(0)) return;
  T slide[3], slip = 0;
  for (int a = 0; a < 3; ++a) {
    slide[a] = relative[a] - normal_speed * offset[a] / distance;
    slip += slide[a] * slide[a];
  }
  slip = std::sqrt(slip);
  const T braking = -T(sphere.friction) * normal_speed;
  const T kept = slip > braking ? (slip - braking) / slip : T(0);
  for (int a = 0; a < 3; ++a) v[a] = T(sphere.velocity[a]) + kept * slide[a];
}

}  // namespace vulnus::injury
