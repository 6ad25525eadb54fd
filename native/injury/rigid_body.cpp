#include "injury/rigid_body.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vulnus::injury {

namespace {

double norm(const double (&v)[3]) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

void RigidBody::set_state(const BodyState& state) {
  state_ = state;
  update_rotation();
}

double RigidBody::surface_speed() const {
  double spin = 0;
  const double* w = state_.angular_velocity;
  for (int n = 0; n < 8; ++n) {
    const double corner[3] = {n & 1 ? shape.upper[0] : shape.lower[0],
                              n & 2 ? shape.upper[1] : shape.lower[1],
                              n & 4 ? shape.upper[2] : shape.lower[2]};
    double r[3];
    to_world(corner, r);
    const double u[3] = {w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2],
                         w[0] * r[1] - w[1] * r[0]};
    spin = std::max(spin, norm(u));
  }
  double speed = norm(state_.velocity);
  for (std::size_t k = 0; k + 1 < path_time.size(); ++k) {
    double step[3];
    for (int a = 0; a < 3; ++a) step[a] = path_position[3 * k + 3 + a] - path_position[3 * k + a];
    speed = std::max(speed, norm(step) / (path_time[k + 1] - path_time[k]));
  }
  return speed + spin + std::abs(shape.expansion_speed);
}

double RigidBody::bounding_radius(double time) const {
  if (shape.is_sphere()) return shape.radius + shape.growth(time);
  double corner[3];
  for (int a = 0; a < 3; ++a) corner[a] = std::max(-shape.lower[a], shape.upper[a]);
  return norm(corner);
}

bool RigidBody::near(const double (&point)[3], double reach, double time) const {
  double apart[3], local[3];
  for (int a = 0; a < 3; ++a) apart[a] = point[a] - state_.position[a];
  const double limit = bounding_radius(time) + reach;
  if (!(norm(apart) < limit)) return false;
  if (shape.is_sphere()) return true;
  to_body(point, local);
  for (int a = 0; a < 3; ++a)
    apart[a] = std::max({shape.lower[a] - local[a], 0.0, local[a] - shape.upper[a]});
  return norm(apart) < reach;
}

void RigidBody::to_body(const double (&world)[3], double (&local)[3]) const {
  double r[3];
  for (int a = 0; a < 3; ++a) r[a] = world[a] - state_.position[a];
  for (int a = 0; a < 3; ++a)
    local[a] = rotation_[0][a] * r[0] + rotation_[1][a] * r[1] + rotation_[2][a] * r[2];
}

void RigidBody::to_world(const double (&local)[3], double (&direction)[3]) const {
  for (int a = 0; a < 3; ++a)
    direction[a] =
        rotation_[a][0] * local[0] + rotation_[a][1] * local[1] + rotation_[a][2] * local[2];
}

double RigidBody::distance(const double (&point)[3], double time) const {
  double local[3];
  to_body(point, local);
  return shape.distance(local, time);
}

void RigidBody::world_inertia(double (&out)[3][3]) const {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      out[i][j] = 0;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) out[i][j] += rotation_[i][k] * inertia[k][l] * rotation_[j][l];
    }
}

void RigidBody::begin_step(double time, double dt, const double (&gravity)[3]) {
  if (motion == BodyMotion::kDynamic) {
    const double along = rail[0] * gravity[0] + rail[1] * gravity[1] + rail[2] * gravity[2];
    for (int a = 0; a < 3; ++a) state_.velocity[a] += dt * (on_rail ? along * rail[a] : gravity[a]);
  }
  if (motion != BodyMotion::kGuided) return;
  double from[3], to[3];
  path_at(time, from);
  path_at(time + dt, to);
  for (int a = 0; a < 3; ++a) state_.velocity[a] = (to[a] - from[a]) / dt;
}

// The work is that of the mean of the velocities before and after, so that a dynamic body loses
// exactly this kinetic energy.
void RigidBody::receive(const ContactSum& contact) {
  BodyState before = state_;
  if (motion == BodyMotion::kDynamic) {
    double along = 0;  // the rail bears the rest
    for (int a = 0; a < 3; ++a) along += rail[a] * contact.impulse[a];
    for (int a = 0; a < 3; ++a) {
      state_.velocity[a] += (on_rail ? along * rail[a] : contact.impulse[a]) / mass;
      if (!on_rail) state_.angular_momentum[a] += contact.angular_impulse[a];
    }
    update_angular_velocity();
  }
  for (int a = 0; a < 3; ++a) {
    state_.impulse[a] += contact.impulse[a];
    state_.angular_impulse[a] += contact.angular_impulse[a];
    state_.work -= 0.5 * contact.impulse[a] * (before.velocity[a] + state_.velocity[a]);
    state_.work -= 0.5 * contact.angular_impulse[a] *
                   (before.angular_velocity[a] + state_.angular_velocity[a]);
  }
  state_.normal_impulse += contact.normal_impulse;
  state_.work += shape.expansion_speed * contact.normal_impulse;
}

void RigidBody::end_step(double time, double dt) {
  if (motion == BodyMotion::kGuided) {
    path_at(time + dt, state_.position);
    return;
  }
  for (int a = 0; a < 3; ++a) state_.position[a] += dt * state_.velocity[a];
  double turn[3];
  if (motion ==
      BodyMotion::kDynamic) {  // midpoint rule: the angular momentum stays, the rest turns
    const BodyState start = state_;
    for (int a = 0; a < 3; ++a) turn[a] = 0.5 * dt * state_.angular_velocity[a];
    rotate(turn);
    update_angular_velocity();
    for (int a = 0; a < 3; ++a) turn[a] = dt * state_.angular_velocity[a];
    std::copy(start.orientation, start.orientation + 4, state_.orientation);
    rotate(turn);
    update_angular_velocity();
  } else {
    for (int a = 0; a < 3; ++a) turn[a] = dt * state_.angular_velocity[a];
    rotate(turn);
  }
}

bool RigidBody::finite() const {
  double value[kBodyValues];
  std::memcpy(value, &state_, sizeof(value));
  return std::all_of(value, value + kBodyValues, [](double v) { return std::isfinite(v); });
}

// Linear between the path's points; before the first and after the last it stands.
void RigidBody::path_at(double time, double (&position)[3]) const {
  const std::size_t last = path_time.size() - 1;
  const auto above = std::upper_bound(path_time.begin(), path_time.end(), time);
  const std::size_t k = above - path_time.begin();
  for (int a = 0; a < 3; ++a) {
    if (k == 0 || k > last) {
      position[a] = path_position[3 * std::min(k, last) + a];
      continue;
    }
    const double part = (time - path_time[k - 1]) / (path_time[k] - path_time[k - 1]);
    const double from = path_position[3 * (k - 1) + a];
    position[a] = from + part * (path_position[3 * k + a] - from);
  }
}

// Turns the orientation by the rotation vector `turn` [rad] of the world frame.
void RigidBody::rotate(const double (&turn)[3]) {
  const double angle = norm(turn);
  if (angle == 0) return;
  const double s = std::sin(0.5 * angle) / angle, w = std::cos(0.5 * angle);
  const double x = s * turn[0], y = s * turn[1], z = s * turn[2];
  const double* q = state_.orientation;
  const double product[4] = {
      w * q[0] - x * q[1] - y * q[2] - z * q[3], w * q[1] + x * q[0] + y * q[3] - z * q[2],
      w * q[2] - x * q[3] + y * q[0] + z * q[1], w * q[3] + x * q[2] - y * q[1] + z * q[0]};
  const double length = std::sqrt(product[0] * product[0] + product[1] * product[1] +
                                  product[2] * product[2] + product[3] * product[3]);
  for (int a = 0; a < 4; ++a) state_.orientation[a] = product[a] / length;
  update_rotation();
}

// omega = R I^-1 R^T L.
void RigidBody::update_angular_velocity() {
  double momentum[3], spin[3];
  for (int a = 0; a < 3; ++a) {
    momentum[a] = 0;
    for (int b = 0; b < 3; ++b) momentum[a] += rotation_[b][a] * state_.angular_momentum[b];
  }
  for (int a = 0; a < 3; ++a)
    spin[a] = inverse_inertia[a][0] * momentum[0] + inverse_inertia[a][1] * momentum[1] +
              inverse_inertia[a][2] * momentum[2];
  to_world(spin, state_.angular_velocity);
}

void RigidBody::update_rotation() {
  const double w = state_.orientation[0], x = state_.orientation[1];
  const double y = state_.orientation[2], z = state_.orientation[3];
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  for (int a = 0; a < 3; ++a) std::copy(r[a], r[a] + 3, rotation_[a]);
}

}  // namespace vulnus::injury
