#include "injury/body_contact.hpp"

#include <algorithm>
#include <cmath>

namespace vulnus::injury {

namespace {

constexpr int kFullSteps = 12;       // Newton needs 2 to 5; what goes to and fro takes half steps
constexpr double kTolerance = 1e-9;  // of the body's speed; momentum closes whatever it is
// Of the body's speed: what a step may be wrong by. Chosen: grids of these cells are 1 % off.
constexpr double kSettled = 1e-3;

using Vector6 = double[6];
using Matrix6 = double[6][6];

void cross(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

// x <- A^-1 x for a symmetric positive definite A, by Cholesky.
void solve6(Matrix6& a, Vector6& x) {
  for (int j = 0; j < 6; ++j) {
    for (int k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
    a[j][j] = std::sqrt(a[j][j]);
    for (int i = j + 1; i < 6; ++i) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] /= a[j][j];
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= a[i][k] * x[k];
    x[i] /= a[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) x[i] -= a[k][i] * x[k];
    x[i] /= a[i][i];
  }
}

void generalised_mass(const RigidBody& body, Matrix6& m) {
  double inertia[3][3];
  body.world_inertia(inertia);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      m[i][j] = i < 3 || j < 3 ? (i == j ? body.mass : 0) : inertia[i - 3][j - 3];
}

// Adds a node's impulse on the body to `force`, and how it falls as the body gives way to
// `hessian`.
void add_contact(const ContactNode& c, const Twist& twist, double growth, double friction,
                 Vector6& force, Matrix6& hessian) {
  double u[3], v[3] = {c.velocity[0], c.velocity[1], c.velocity[2]};
  twist.surface_velocity(c, growth, u);
  const double braked = contact_velocity(u, c.normal, friction, v);
  if (braked < 0) return;
  double j[3], torque[3];
  for (int a = 0; a < 3; ++a) j[a] = c.mass * (c.velocity[a] - v[a]);
  cross(c.arm, j, torque);
  for (int a = 0; a < 3; ++a) {
    force[a] += j[a];
    force[3 + a] += torque[a];
  }
  for (int a = 0; a < 3; ++a) {  // m (n n^T + braked (1 - n n^T)) as three directions
    const double* n = c.normal;
    double row[3], turn[3];
    for (int b = 0; b < 3; ++b) row[b] = (1 - braked) * n[a] * n[b] + (a == b ? braked : 0);
    double lever[3][3];
    for (int b = 0; b < 3; ++b) {
      double axis[3] = {0, 0, 0};
      axis[b] = 1;
      cross(c.arm, axis, lever[b]);
    }
    for (int b = 0; b < 3; ++b)
      turn[b] = row[0] * lever[0][b] + row[1] * lever[1][b] + row[2] * lever[2][b];
    for (int b = 0; b < 3; ++b) {
      hessian[a][b] += c.mass * row[b];
      hessian[3 + b][a] += c.mass * turn[b];
      for (int d = 0; d < 3; ++d) hessian[3 + d][3 + b] += c.mass * lever[a][d] * turn[b];
    }
  }
}

}  // namespace

void Twist::surface_velocity(const ContactNode& c, double growth, double (&u)[3]) const {
  cross(value + 3, c.arm, u);
  for (int a = 0; a < 3; ++a) u[a] += value[a] + growth * c.normal[a];
}

Twist twist_of(const RigidBody& body) {
  const BodyState& s = body.state();
  Twist twist;
  for (int a = 0; a < 3; ++a) {
    twist.value[a] = s.velocity[a];
    twist.value[3 + a] = s.angular_velocity[a];
  }
  return twist;
}

namespace {

// Newton's step of a body that moves only along its rail, in place of that of a free one.
void solve_on_rail(const RigidBody& body, const Matrix6& hessian, Vector6& step) {
  double force = 0, mass = 0;
  for (int a = 0; a < 3; ++a) {
    force += body.rail[a] * step[a];
    for (int b = 0; b < 3; ++b) mass += body.rail[a] * hessian[a][b] * body.rail[b];
  }
  for (int a = 0; a < 6; ++a) step[a] = a < 3 ? body.rail[a] * force / mass : 0;
}

}  // namespace

Twist solve_contact(const RigidBody& body, const std::vector<ContactNode>& contacts,
                    int iterations) {
  const Twist start = twist_of(body);
  if (body.motion != BodyMotion::kDynamic || contacts.empty()) return start;
  Matrix6 inertia;
  generalised_mass(body, inertia);
  Twist twist = start;
  for (int n = 0; n < iterations; ++n) {
    Matrix6 hessian;
    Vector6 force{};
    std::copy(&inertia[0][0], &inertia[0][0] + 36, &hessian[0][0]);
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) force[a] -= inertia[a][b] * (twist.value[b] - start.value[b]);
    for (const ContactNode& c : contacts)
      add_contact(c, twist, body.shape.expansion_speed, body.friction, force, hessian);
    if (body.on_rail)
      solve_on_rail(body, hessian, force);
    else
      solve6(hessian, force);
    double change = 0, speed = 0;
    for (int a = 0; a < 6; ++a) {
      const double lever = a < 3 ? 1 : body.shape.inner_radius;
      twist.value[a] += (n < kFullSteps ? 1 : 0.5) * force[a];
      change = std::max(change, std::abs(force[a]) * lever);
      speed = std::max(speed, std::abs(twist.value[a]) * lever);
    }
    twist.settled = change <= kSettled * speed;
    if (change <= kTolerance * speed) break;
  }
  return twist;
}

}  // namespace vulnus::injury
