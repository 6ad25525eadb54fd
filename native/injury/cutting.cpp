// Blades: the particles that a cutting body sweeps lose their strength at once.
#include <cmath>

#include "injury/mpm_solver.hpp"

namespace vulnus::injury {

namespace {

constexpr double kCutReach = 0.25;    // cells beside the surface; half a particle's spacing
constexpr double kCellsInBlock = 6;   // a block's particles lie in its cells and a cell beside
constexpr double kCellsMiddle = 2.5;  // of those, from the block's first node

}  // namespace

template <class T>
void MpmSolver<T>::cut_tissue() {
  for (const RigidBody& body : bodies_)
    if (body.cutting) cut_tissue(body);
}

template <class T>
void MpmSolver<T>::cut_tissue(const RigidBody& body) {
  const double dx = settings_.grid_spacing;
  const double reach = (0.5 * kCellsInBlock * std::sqrt(3.0) + kCutReach) * dx;
#pragma omp parallel for schedule(dynamic, 8)
  for (int i = 0; i < grid_.occupied(); ++i) {
    double middle[3];
    block_corner(i, middle);
    for (double& m : middle) m += kCellsMiddle * dx;
    if (!body.near(middle, reach, time_)) continue;
    const int end = particles_.first_bundle(i + 1) * ParticleSet<T>::kWidth;
    for (int p = particles_.first_bundle(i) * ParticleSet<T>::kWidth; p < end; ++p) {
      double x[3];
      for (int a = 0; a < 3; ++a) x[a] = particles_.field[kPosition + a][p];
      if (body.distance(x, time_) < kCutReach * dx) particles_.field[kDamage][p] = T(1);
    }
  }
}

template void MpmSolver<float>::cut_tissue();
template void MpmSolver<double>::cut_tissue();
template void MpmSolver<float>::cut_tissue(const RigidBody&);
template void MpmSolver<double>::cut_tissue(const RigidBody&);

}  // namespace vulnus::injury
