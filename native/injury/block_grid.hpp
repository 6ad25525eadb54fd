// A sparse grid of 4^3-node blocks. Every block that holds particles owns a tile of 8^3 nodes into
// which its particles scatter (one node of halo below, three above, so that particles may drift by
// a cell before they are sorted again). Tiles are summed into the blocks' nodes in a fixed order:
// no atomics, and the same bits for any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "core/aligned_vector.hpp"
#include "core/lanes.hpp"

namespace vulnus::injury {

constexpr int kBlockEdge = 4;
constexpr int kBlockNodes = 64;
constexpr int kTileEdge = 8;
constexpr int kTileNodes = 512;
constexpr int kComponents = 4;  // mass and momentum, later mass and velocity
constexpr int kBlockValues = kBlockNodes * kComponents;
constexpr int kTilePad = 16;  // rows are read four nodes at a time, past the last one
constexpr int kTileValues = kTileNodes * kComponents + kTilePad;
constexpr std::int32_t kBlockOffset = 1 << 18;  // block coordinates are stored non-negative

struct BlockIndex {
  std::int32_t x, y, z;
};

std::uint64_t morton_key(BlockIndex block);
BlockIndex block_of_key(std::uint64_t key);

template <class T>
class BlockGrid {
 public:
  // Makes the grid for these occupied blocks (sorted keys) and their 26 neighbours.
  void rebuild(const std::vector<std::uint64_t>& occupied_keys);

  int occupied() const { return occupied_; }
  int active() const { return static_cast<int>(block_.size()); }
  BlockIndex block(int i) const { return block_[i]; }
  int find(std::uint64_t key) const;

  T* tile(int i) { return tile_.data() + std::size_t(i) * kTileValues; }
  T* nodes(int i) { return node_.data() + std::size_t(i) * kBlockValues; }
  const T* nodes(int i) const { return node_.data() + std::size_t(i) * kBlockValues; }

  // Sums what the tiles hold for block i into its nodes, or adds it to what they hold.
  void reduce(int i, bool add);
  // Copies the nodes around occupied block i into a tile.
  void load_tile(int i, T* tile) const;

  std::size_t memory_bytes() const;

 private:
  const T* tile_if_occupied(int i) const {
    return i >= 0 && i < occupied_ ? tile_.data() + std::size_t(i) * kTileValues : nullptr;
  }
  int neighbour(int i, int dx, int dy, int dz) const {
    return neighbour_[std::size_t(i) * 27 + (dx + 1) * 9 + (dy + 1) * 3 + (dz + 1)];
  }
  void link_neighbours();
  int add_block(std::uint64_t key);
  void hash_reserve(std::size_t blocks);

  int occupied_ = 0;
  std::vector<BlockIndex> block_;
  std::vector<std::int32_t> neighbour_;
  std::vector<std::uint64_t> slot_key_;
  std::vector<std::int32_t> slot_block_;
  AlignedVector<T> tile_;
  AlignedVector<T> node_;
};

extern template class BlockGrid<float>;
extern template class BlockGrid<double>;

}  // namespace vulnus::injury
