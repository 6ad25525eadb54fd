// The grid beside planes of symmetry (mirror.hpp).
#include "injury/mpm_solver.hpp"

namespace vulnus::injury {

namespace {

int component(const BlockIndex& b, int axis) { return axis == 0 ? b.x : axis == 1 ? b.y : b.z; }

// Number of a node in its block, and the step from one node to the next along an axis.
constexpr int kStride[3] = {16, 4, 1};

}  // namespace

template <class T>
void MpmSolver<T>::find_mirrors() {
  mirrors_.clear();
  for (const HalfSpace& wall : boundaries_)
    if (const auto mirror = mirror_of(wall, settings_.grid_spacing)) mirrors_.push_back(*mirror);
}

// Calls visit(front, back) with the values of every pair of nodes that are images of each other.
template <class T>
template <class Visit>
void MpmSolver<T>::for_image_pairs(const Mirror& mirror, const Visit& visit) {
#pragma omp parallel for schedule(static)
  for (int i = 0; i < grid_.active(); ++i)
    for (int depth = 1; depth <= kMirrorDepth; ++depth) {
      const BlockIndex block = grid_.block(i);
      const int first = kBlockEdge * component(block, mirror.axis);
      const int front = mirror.node + mirror.free_side * depth - first;
      if (front < 0 || front >= kBlockEdge) continue;
      int back = mirror.node - mirror.free_side * depth - first;
      BlockIndex other = block;
      int& along = mirror.axis == 0 ? other.x : mirror.axis == 1 ? other.y : other.z;
      for (; back < 0; back += kBlockEdge) --along;
      for (; back >= kBlockEdge; back -= kBlockEdge) ++along;
      const int j = grid_.find(morton_key(other));
      if (j < 0) continue;
      const int stride = kStride[mirror.axis];
      for (int n = 0; n < kBlockNodes; ++n) {
        if (n / stride % kBlockEdge != 0) continue;
        visit(grid_.nodes(i) + (n + front * stride) * kComponents,
              grid_.nodes(j) + (n + back * stride) * kComponents);
      }
    }
}

// Mass and momentum behind each mirror are added to their images'.
template <class T>
void MpmSolver<T>::fold_mirrors() {
  for (const Mirror& mirror : mirrors_)
    for_image_pairs(mirror, [&](T* front, T* back) {
      for (int c = 0; c < kComponents; ++c) {
        front[c] += c == 1 + mirror.axis ? -back[c] : back[c];
        back[c] = T(0);
      }
    });
}

// The velocity behind each mirror is its image's.
template <class T>
void MpmSolver<T>::reflect_mirrors() {
  for (const Mirror& mirror : mirrors_)
    for_image_pairs(mirror, [&](const T* front, T* back) {
      for (int c = 1; c < kComponents; ++c) back[c] = c == 1 + mirror.axis ? -front[c] : front[c];
    });
}

// The class is instantiated where its constructor is; what is defined here needs it here.
template void MpmSolver<float>::find_mirrors();
template void MpmSolver<double>::find_mirrors();
template void MpmSolver<float>::fold_mirrors();
template void MpmSolver<double>::fold_mirrors();
template void MpmSolver<float>::reflect_mirrors();
template void MpmSolver<double>::reflect_mirrors();

}  // namespace vulnus::injury
