#include "injury/particle_set.hpp"

#include <algorithm>
#include <cmath>

namespace vulnus::injury {

namespace {

constexpr std::uint64_t kNoKey = ~0ull;

template <class V>
void reorder(V& values, V& spare, const AlignedVector<std::int32_t>& source) {
  grow(spare, source.size());
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < source.size(); ++p)
    spare[p] = values[source[p] < 0 ? ~source[p] : source[p]];
  values.swap(spare);
}

}  // namespace

template <class T>
void ParticleSet<T>::reset(int n) {
  count_ = n;
  for (auto& f : field) f.assign(n, T(0));
  id.resize(n);
  for (int p = 0; p < n; ++p) id[p] = p;
  material.assign(n, 0);
}

template <class T>
void ParticleSet<T>::restore(std::size_t places, const T* fields, const std::int32_t* ids,
                             const std::uint8_t* materials) {
  for (int f = 0; f < kParticleFields; ++f)
    field[f].assign(fields + f * places, fields + (f + 1) * places);
  id.assign(ids, ids + places);
  material.assign(materials, materials + places);
  count_ = static_cast<int>(std::count_if(id.begin(), id.end(), [](int i) { return i >= 0; }));
}

template <class T>
void ParticleSet<T>::sort(T cells_per_metre, BlockGrid<T>& grid) {
  compute_keys(cells_per_metre);
  grid.rebuild(occupied_blocks());
  assign_places(grid);
  permute();
}

template <class T>
void ParticleSet<T>::compute_keys(T cells_per_metre) {
  const int n = places();
  grow(key_, n);
  constexpr T limit = T(kBlockOffset - 2) * kBlockEdge;
#pragma omp parallel for schedule(static)
  for (int p = 0; p < n; ++p) {
    std::int32_t node[3];
    for (int a = 0; a < 3; ++a) {
      const T cell = std::floor(field[kPosition + a][p] * cells_per_metre - T(0.5));
      node[a] = static_cast<std::int32_t>(std::min(std::max(cell, -limit), limit));
    }
    const std::uint64_t block = morton_key({node[0] >> 2, node[1] >> 2, node[2] >> 2});
    const std::uint64_t cell = (node[0] & 3) << 4 | (node[1] & 3) << 2 | (node[2] & 3);
    key_[p] = id[p] < 0 ? kNoKey : block << 6 | cell;
  }
}

template <class T>
std::vector<std::uint64_t> ParticleSet<T>::occupied_blocks() const {
  std::vector<std::uint64_t> blocks;
  std::uint64_t last = kNoKey;
  for (const std::uint64_t key : key_)
    if (key != kNoKey && key >> 6 != last) blocks.push_back(last = key >> 6);
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

// A stable counting sort by (block, cell), with every block rounded up to whole bundles.
template <class T>
void ParticleSet<T>::assign_places(const BlockGrid<T>& grid) {
  cell_place_.assign(std::size_t(grid.occupied()) * kBlockNodes, 0);
  std::uint64_t last = kNoKey;
  std::int32_t* cells = nullptr;
  auto cells_of = [&](std::uint64_t key) {
    if (key >> 6 != last) {
      last = key >> 6;
      cells = &cell_place_[std::size_t(grid.find(last)) * kBlockNodes];
    }
    return cells;
  };
  for (const std::uint64_t key : key_)
    if (key != kNoKey) ++cells_of(key)[key & 63];
  first_bundle_.assign(grid.occupied() + 1, 0);
  largest_block_ = 0;
  int place = 0;
  for (int i = 0; i < grid.occupied(); ++i) {
    for (int c = 0; c < kBlockNodes; ++c) {
      const int n = cell_place_[std::size_t(i) * kBlockNodes + c];
      cell_place_[std::size_t(i) * kBlockNodes + c] = place;
      place += n;
    }
    place = (place + kWidth - 1) / kWidth * kWidth;
    first_bundle_[i + 1] = place / kWidth;
    largest_block_ = std::max(largest_block_, first_bundle_[i + 1] - first_bundle_[i]);
  }
  source_.assign(place, -1);
  last = kNoKey;
  for (std::size_t p = 0; p < key_.size(); ++p)
    if (key_[p] != kNoKey) source_[cells_of(key_[p])[key_[p] & 63]++] = static_cast<int>(p);
  for (int i = 0; i < grid.occupied(); ++i)  // the rest of a block: copies of its first point
    for (int p = first_bundle_[i] * kWidth; p < first_bundle_[i + 1] * kWidth; ++p)
      if (source_[p] < 0) source_[p] = ~source_[first_bundle_[i] * kWidth];
}

template <class T>
void ParticleSet<T>::permute() {
  for (auto& f : field) reorder(f, spare_, source_);
  AlignedVector<std::int32_t> spare_id;
  reorder(id, spare_id, source_);
  AlignedVector<std::uint8_t> spare_material;
  reorder(material, spare_material, source_);
  for (std::size_t p = 0; p < source_.size(); ++p)
    if (source_[p] < 0) {
      id[p] = -1;
      field[kVolume][p] = T(0);
    }
}

template <class T>
std::size_t ParticleSet<T>::memory_bytes() const {
  std::size_t bytes = spare_.capacity() * sizeof(T);
  for (const auto& f : field) bytes += f.capacity() * sizeof(T);
  bytes += id.capacity() * sizeof(std::int32_t) + material.capacity();
  bytes += key_.capacity() * sizeof(std::uint64_t) + source_.capacity() * sizeof(std::int32_t);
  return bytes + (cell_place_.capacity() + first_bundle_.capacity()) * sizeof(std::int32_t);
}

template class ParticleSet<float>;
template class ParticleSet<double>;

}  // namespace vulnus::injury
