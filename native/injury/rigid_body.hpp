// A rigid body among the nodes: moved at will (kinematic), along a path (guided), or by what the
// tissue does to it (dynamic, six degrees of freedom).
#pragma once

#include <vector>

#include "injury/body_shape.hpp"

namespace vulnus::injury {

enum class BodyMotion : int { kKinematic = 0, kDynamic = 1, kGuided = 2 };

// What changes in a step; all that a checkpoint has to keep of a body. World frame.
struct BodyState {
  double position[3] = {0, 0, 0};  // of the centre of mass, in the solver's local frame
  double velocity[3] = {0, 0, 0};
  double orientation[4] = {1, 0, 0, 0};  // unit quaternion w x y z, body to world
  double angular_velocity[3] = {0, 0, 0};
  double angular_momentum[3] = {0, 0, 0};  // about the centre; dynamic bodies
  double impulse[3] = {0, 0, 0};           // that the tissue gave the body so far [N s]
  double angular_impulse[3] = {0, 0, 0};   // about the centre [N m s]
  double normal_impulse = 0;               // sum of the sizes of the normal impulses [N s]
  double work = 0;                         // that the body did on the tissue [J]
};
constexpr int kBodyValues = sizeof(BodyState) / sizeof(double);

// Impulse, torque about the body's centre and normal impulse of one step's contact.
struct ContactSum {
  double impulse[3] = {0, 0, 0};
  double angular_impulse[3] = {0, 0, 0};
  double normal_impulse = 0;
};

class RigidBody {
 public:
  BodyShape shape;
  BodyMotion motion = BodyMotion::kKinematic;
  double mass = 0;
  double inertia[3][3] = {};          // body frame, about the centre [kg m^2]
  double inverse_inertia[3][3] = {};  // its inverse
  double friction = 0;
  double margin = 0;  // nodes touch where the signed distance is below this [m]
  bool cutting = false;
  bool on_rail = false;           // dynamic, but only along `rail` and without turning
  double rail[3] = {1, 0, 0};     // unit
  std::vector<double> path_time;  // guided bodies
  std::vector<double> path_position;

  const BodyState& state() const { return state_; }
  // Takes a state; what is derived from it is computed anew.
  void set_state(const BodyState& state);

  // The largest speed of its surface, now and along the path [m/s].
  double surface_speed() const;
  // Radius of a ball around the centre that holds the body at `time`.
  double bounding_radius(double time) const;
  // Whether the body may touch a ball of radius `reach` around a world point.
  bool near(const double (&point)[3], double reach, double time) const;

  void to_body(const double (&world)[3], double (&local)[3]) const;
  void to_world(const double (&local)[3], double (&direction)[3]) const;
  double distance(const double (&point)[3], double time) const;
  // Inertia about the centre in the world frame, as it lies now.
  void world_inertia(double (&out)[3][3]) const;

  // The velocity that it has in the step [time, time + dt] before contact.
  void begin_step(double time, double dt, const double (&gravity)[3]);
  // Books the contact of a step.
  void receive(const ContactSum& contact);
  // Moves it to the end of the step.
  void end_step(double time, double dt);
  bool finite() const;

 private:
  void path_at(double time, double (&position)[3]) const;
  void rotate(const double (&turn)[3]);
  void update_angular_velocity();
  void update_rotation();

  BodyState state_;
  double rotation_[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // from the orientation
};

}  // namespace vulnus::injury
