// Contact of one rigid body with the nodes that lie inside it.
#pragma once

#include <vector>

#include "injury/contact_law.hpp"
#include "injury/rigid_body.hpp"

namespace vulnus::injury {

// A node inside a body.
struct ContactNode {
  int block, node;
  double mass;
  double arm[3];     // from the body's centre
  double normal[3];  // outward
  double velocity[3];
};

// Linear and angular velocity of a body.
struct Twist {
  double value[6];
  bool settled = true;  // whether the iteration that gave it came to an end

  // Velocity of the body's surface at a node; `growth` is that of its radius.
  void surface_velocity(const ContactNode& c, double growth, double (&u)[3]) const;
};

// That of a body now.
Twist twist_of(const RigidBody& body);

// The velocity that the body has after an inelastic contact with these nodes, friction included.
// The nodes alone would give a light body more than it takes to stop the approach, so both sides
// are solved together: M (U - U0) = sum A^T j(U), with j the impulse that a node gives the body.
// Momentum closes also where `iterations` are too few to settle it.
Twist solve_contact(const RigidBody& body, const std::vector<ContactNode>& contacts,
                    int iterations);

}  // namespace vulnus::injury
