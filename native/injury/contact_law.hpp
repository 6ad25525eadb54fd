// Contact of a node with a rigid surface that moves: the law that bodies and walls share.
#pragma once

#include <cmath>

#include "core/host_device.hpp"

namespace vulnus::injury {

// A node's velocity v after contact with a surface of velocity u and outward normal n: the part
// that approaches is lost, Coulomb friction brakes the sliding part, separation is free. Returns
// the part of the sliding that friction took, or a negative number where there is no contact.
template <class T>
VULNUS_HD T contact_velocity(const T (&u)[3], const T (&n)[3], T friction, T (&v)[3]) {
  const T relative[3] = {v[0] - u[0], v[1] - u[1], v[2] - u[2]};
  const T normal_speed = relative[0] * n[0] + relative[1] * n[1] + relative[2] * n[2];
  if (!(normal_speed < T(0))) return T(-1);
  T slide[3], slip = 0;
  for (int a = 0; a < 3; ++a) {
    slide[a] = relative[a] - normal_speed * n[a];
    slip += slide[a] * slide[a];
  }
  slip = std::sqrt(slip);
  const T braking = -friction * normal_speed;
  const T kept = slip > braking ? (slip - braking) / slip : T(0);
  for (int a = 0; a < 3; ++a) v[a] = u[a] + kept * slide[a];
  return T(1) - kept;
}

}  // namespace vulnus::injury
