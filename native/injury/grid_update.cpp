// What happens on the grid between scatter and gather: tiles are summed, momentum becomes velocity,
// and bodies and boundaries have their say.
#include <algorithm>
#include <cmath>

#include "injury/mpm_solver.hpp"

namespace vulnus::injury {

namespace {

// [kg]: with less a node is empty. Particles a last digit beside a layer of nodes leave masses
// there whose inverse no float holds. Chosen: a hundred times the least float with all its digits.
template <class T>
constexpr T kLeastMass = T(1e-36);

constexpr std::size_t kFew = 32;     // blocks that one thread does sooner than two are woken
constexpr double kBlockReach = 2.6;  // cells: half of a block's diagonal, sqrt(3) 1.5

// A node in the middle plane of a plate stands for the tissue on both sides: it touches the face
// that it moves towards.
void face_approach(const RigidBody& body, ContactNode& c) {
  double u[3], leaving = 0;
  twist_of(body).surface_velocity(c, 0, u);
  for (int a = 0; a < 3; ++a) leaving += (c.velocity[a] - u[a]) * c.normal[a];
  if (leaving > 0)
    for (double& n : c.normal) n = -n;
}

}  // namespace

template <class T>
double MpmSolver<T>::update_grid(double dt) {
  for (RigidBody& body : bodies_) body.begin_step(time_, dt, settings_.gravity);
  near_body_.assign(grid_.active(), 0);
  find_mirrors();
  if (!mirrors_.empty()) sum_all_tiles();
  double largest = 0;
#pragma omp parallel for schedule(dynamic, 8) reduction(max : largest)
  for (int i = 0; i < grid_.active(); ++i) {
    load_velocity(i, dt);
    near_body_[i] = block_is_near_a_body(i);
    if (!near_body_[i]) largest = std::max(largest, finish_block(i, dt));
  }
  near_blocks_.clear();
  for (int i = 0; i < grid_.active(); ++i)
    if (near_body_[i]) near_blocks_.push_back(i);
  for (RigidBody& body : bodies_) collide(body);
#pragma omp parallel for schedule(static) reduction(max : largest) if (near_blocks_.size() > kFew)
  for (std::size_t k = 0; k < near_blocks_.size(); ++k)
    largest = std::max(largest, finish_block(near_blocks_[k], dt));
  reflect_mirrors();
  return std::sqrt(largest);
}

// What the tiles hold, on top of the momentum that nodes keep.
template <class T>
void MpmSolver<T>::sum_tiles(int i) {
  T* node = grid_.nodes(i);
  if (nodes_keep_)
    for (int n = 0; n < kBlockNodes; ++n)
      for (int a = 1; a < kComponents; ++a) node[n * kComponents + a] *= node[n * kComponents];
  grid_.reduce(i, nodes_keep_);
}

// Mirrors need the sums of all blocks before any momentum becomes velocity. Nodes behind one keep
// no mass and so no momentum.
template <class T>
void MpmSolver<T>::sum_all_tiles() {
#pragma omp parallel for schedule(dynamic, 8)
  for (int i = 0; i < grid_.active(); ++i) sum_tiles(i);
  fold_mirrors();
}

// Momentum to velocity, and gravity (equation 1).
template <class T>
void MpmSolver<T>::load_velocity(int i, double dt) {
  if (mirrors_.empty()) sum_tiles(i);
  T* node = grid_.nodes(i);
  const T kick[3] = {T(dt * settings_.gravity[0]), T(dt * settings_.gravity[1]),
                     T(dt * settings_.gravity[2])};
  for (int n = 0; n < kBlockNodes; ++n) {
    T* value = node + n * kComponents;
    const T inverse = value[0] > kLeastMass<T> ? T(1) / value[0] : T(0);
    const T loaded = value[0] > kLeastMass<T> ? T(1) : T(0);
    for (int a = 0; a < 3; ++a) value[1 + a] = value[1 + a] * inverse + loaded * kick[a];
  }
}

// The boundaries; returns the largest squared speed of the block's nodes.
template <class T>
double MpmSolver<T>::finish_block(int i, double dt) {
  for (const HalfSpace& wall : boundaries_) constrain_block(wall, i, dt);
  const T* node = grid_.nodes(i);
  T largest = 0;
  for (int n = 0; n < kBlockNodes; ++n) {
    const T* v = node + n * kComponents + 1;
    largest = std::max(largest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return largest;
}

template <class T>
void MpmSolver<T>::constrain_block(const HalfSpace& wall, int i, double dt) {
  const double dx = settings_.grid_spacing;
  double corner[3];
  block_corner(i, corner);
  double above = -wall.height_at(time_);
  for (int a = 0; a < 3; ++a) above += wall.normal[a] * corner[a];
  double middle = above;
  for (int a = 0; a < 3; ++a) middle += wall.normal[a] * 1.5 * dx;
  if (middle - kBlockReach * dx > wall.thickness) return;
  for (int n = 0; n < kBlockNodes; ++n) {
    T* value = grid_.nodes(i) + n * kComponents;
    if (!(value[0] > T(0))) continue;
    const double up =
        wall.normal[0] * (n >> 4) + wall.normal[1] * (n >> 2 & 3) + wall.normal[2] * (n & 3);
    T v[3] = {value[1], value[2], value[3]};
    constrain(wall, above + up * dx, dt, v);
    for (int a = 0; a < 3; ++a) value[1 + a] = v[a];
  }
}

template <class T>
void MpmSolver<T>::block_corner(int i, double (&corner)[3]) const {
  const BlockIndex b = grid_.block(i);
  const double edge = kBlockEdge * settings_.grid_spacing;
  corner[0] = b.x * edge;
  corner[1] = b.y * edge;
  corner[2] = b.z * edge;
}

template <class T>
bool MpmSolver<T>::block_is_near(const RigidBody& body, int i) const {
  double middle[3];
  block_corner(i, middle);
  for (double& m : middle) m += 1.5 * settings_.grid_spacing;
  return body.near(middle, kBlockReach * settings_.grid_spacing + std::max(body.margin, 0.0),
                   time_);
}

template <class T>
bool MpmSolver<T>::block_is_near_a_body(int i) const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [&](const RigidBody& body) { return block_is_near(body, i); });
}

// The nodes of a block that lie inside the body, into `out`.
template <class T>
void MpmSolver<T>::find_contacts(const RigidBody& body, int i,
                                 std::vector<ContactNode>& out) const {
  out.clear();
  if (!block_is_near(body, i)) return;
  double corner[3];
  block_corner(i, corner);
  for (int n = 0; n < kBlockNodes; ++n) {
    const T* value = grid_.nodes(i) + n * kComponents;
    if (!(value[0] > T(0))) continue;
    const int index[3] = {n >> 4, n >> 2 & 3, n & 3};
    ContactNode c{i, n, double(value[0]), {}, {}, {}};
    double x[3], local[3], normal[3];
    for (int a = 0; a < 3; ++a) {
      x[a] = corner[a] + index[a] * settings_.grid_spacing;
      c.arm[a] = x[a] - body.state().position[a];
      c.velocity[a] = value[1 + a];
    }
    body.to_body(x, local);
    if (!(body.shape.distance(local, time_) < body.margin)) continue;
    const bool ridge = body.shape.normal(local, normal);
    body.to_world(normal, c.normal);
    if (ridge) face_approach(body, c);
    out.push_back(c);
  }
}

// Contact with one body: the nodes get the velocity that the contact leaves them, the body exactly
// the opposite impulse, summed in the order of the blocks.
template <class T>
void MpmSolver<T>::collide(RigidBody& body) {
  block_contacts_.resize(std::max(block_contacts_.size(), near_blocks_.size()));
#pragma omp parallel for schedule(dynamic, 4) if (near_blocks_.size() > kFew)
  for (std::size_t k = 0; k < near_blocks_.size(); ++k)
    find_contacts(body, near_blocks_[k], block_contacts_[k]);
  contacts_.clear();
  for (std::size_t k = 0; k < near_blocks_.size(); ++k)
    contacts_.insert(contacts_.end(), block_contacts_[k].begin(), block_contacts_[k].end());
  const Twist twist = solve_contact(body, contacts_, settings_.contact_iterations);
  if (!twist.settled && faulty_body_ < 0) {
    faulty_body_ = static_cast<int>(&body - bodies_.data());
    fault_.raise(kUnsolvedContact, 0);
  }
  ContactSum sum;
  for (const ContactNode& c : contacts_) {
    double u[3], v[3] = {c.velocity[0], c.velocity[1], c.velocity[2]}, j[3];
    twist.surface_velocity(c, body.shape.expansion_speed, u);
    if (contact_velocity(u, c.normal, body.friction, v) < 0) continue;
    T* value = grid_.nodes(c.block) + c.node * kComponents;
    for (int a = 0; a < 3; ++a) {
      value[1 + a] = T(v[a]);
      j[a] = c.mass * (c.velocity[a] - double(value[1 + a]));
      sum.impulse[a] += j[a];
      sum.normal_impulse -= j[a] * c.normal[a];
    }
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, d = (a + 2) % 3;
      sum.angular_impulse[a] += c.arm[b] * j[d] - c.arm[d] * j[b];
    }
  }
  body.receive(sum);
}

// The class is instantiated where its constructor is; what is defined here needs it here.
template double MpmSolver<float>::update_grid(double);
template double MpmSolver<double>::update_grid(double);
template void MpmSolver<float>::sum_tiles(int);
template void MpmSolver<double>::sum_tiles(int);
template void MpmSolver<float>::sum_all_tiles();
template void MpmSolver<double>::sum_all_tiles();
template void MpmSolver<float>::load_velocity(int, double);
template void MpmSolver<double>::load_velocity(int, double);
template double MpmSolver<float>::finish_block(int, double);
template double MpmSolver<double>::finish_block(int, double);
template void MpmSolver<float>::constrain_block(const HalfSpace&, int, double);
template void MpmSolver<double>::constrain_block(const HalfSpace&, int, double);
template void MpmSolver<float>::block_corner(int, double (&)[3]) const;
template void MpmSolver<double>::block_corner(int, double (&)[3]) const;
template bool MpmSolver<float>::block_is_near(const RigidBody&, int) const;
template bool MpmSolver<double>::block_is_near(const RigidBody&, int) const;
template bool MpmSolver<float>::block_is_near_a_body(int) const;
template bool MpmSolver<double>::block_is_near_a_body(int) const;
template void MpmSolver<float>::find_contacts(const RigidBody&, int,
                                              std::vector<ContactNode>&) const;
template void MpmSolver<double>::find_contacts(const RigidBody&, int,
                                               std::vector<ContactNode>&) const;
template void MpmSolver<float>::collide(RigidBody&);
template void MpmSolver<double>::collide(RigidBody&);

}  // namespace vulnus::injury
