#include "injury/block_grid.hpp"

#include <cstring>

namespace vulnus::injury {

namespace {

std::uint64_t spread_bits(std::uint64_t v) {  // 21 bits to every third place
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffull;
  v = (v | v << 16) & 0x1f0000ff0000ffull;
  v = (v | v << 8) & 0x100f00f00f00f00full;
  v = (v | v << 4) & 0x10c30c30c30c30c3ull;
  return (v | v << 2) & 0x1249249249249249ull;
}

std::uint64_t gather_bits(std::uint64_t v) {
  v &= 0x1249249249249249ull;
  v = (v | v >> 2) & 0x10c30c30c30c30c3ull;
  v = (v | v >> 4) & 0x100f00f00f00f00full;
  v = (v | v >> 8) & 0x1f0000ff0000ffull;
  v = (v | v >> 16) & 0x1f00000000ffffull;
  return (v | v >> 32) & 0x1fffff;
}

constexpr std::uint64_t kEmptySlot = ~0ull;

// Where the four nodes of a block's row in z stand in a tile: own nodes at 1, those of the block
// above at 5 (three of them), that of the block below at 0.
constexpr int kOwnZ = 1 * kComponents;
constexpr int kUpperZ = 5 * kComponents;

template <class T>
using Row = typename LaneTraits<T>::Row;

template <class T>
VULNUS_HD const T* tile_row(const T* tile, int x, int y) {
  return tile + (x * kTileEdge + y) * kTileEdge * kComponents;
}

// A node of a block lies in exactly two tiles along each axis: its own, and the lower neighbour's
// halo (nodes 0-2) or the upper neighbour's (node 3).
struct AxisShare {
  int neighbour;
  int tile_index;
};
VULNUS_HD AxisShare other_share(int node) {
  return node < 3 ? AxisShare{-1, node + 5} : AxisShare{+1, 0};
}

}  // namespace

std::uint64_t morton_key(BlockIndex b) {
  return spread_bits(b.x + kBlockOffset) | spread_bits(b.y + kBlockOffset) << 1 |
         spread_bits(b.z + kBlockOffset) << 2;
}

BlockIndex block_of_key(std::uint64_t key) {
  auto coordinate = [](std::uint64_t v) {
    return static_cast<std::int32_t>(static_cast<std::int64_t>(gather_bits(v)) - kBlockOffset);
  };
  return {coordinate(key), coordinate(key >> 1), coordinate(key >> 2)};
}

template <class T>
void BlockGrid<T>::hash_reserve(std::size_t blocks) {
  std::size_t size = 64;
  while (size < 2 * blocks) size *= 2;
  slot_key_.assign(size, kEmptySlot);
  slot_block_.assign(size, -1);
}

template <class T>
int BlockGrid<T>::find(std::uint64_t key) const {
  const std::size_t mask = slot_key_.size() - 1;
  std::size_t slot = (key * 0x9e3779b97f4a7c15ull >> 20) & mask;
  while (slot_key_[slot] != kEmptySlot) {
    if (slot_key_[slot] == key) return slot_block_[slot];
    slot = (slot + 1) & mask;
  }
  return -1;
}

template <class T>
int BlockGrid<T>::add_block(std::uint64_t key) {
  const std::size_t mask = slot_key_.size() - 1;
  std::size_t slot = (key * 0x9e3779b97f4a7c15ull >> 20) & mask;
  while (slot_key_[slot] != kEmptySlot) {
    if (slot_key_[slot] == key) return slot_block_[slot];
    slot = (slot + 1) & mask;
  }
  slot_key_[slot] = key;
  slot_block_[slot] = active();
  block_.push_back(block_of_key(key));
  return slot_block_[slot];
}

template <class T>
void BlockGrid<T>::rebuild(const std::vector<std::uint64_t>& occupied_keys) {
  occupied_ = static_cast<int>(occupied_keys.size());
  block_.clear();
  hash_reserve(27 * occupied_keys.size());
  for (std::uint64_t key : occupied_keys) add_block(key);
  for (int i = 0; i < occupied_; ++i)
    for (int n = 0; n < 27; ++n) {
      const BlockIndex b = block_[i];
      add_block(morton_key({b.x + n / 9 - 1, b.y + n / 3 % 3 - 1, b.z + n % 3 - 1}));
    }
  link_neighbours();
  grow(tile_, std::size_t(occupied_) * kTileValues);
  grow(node_, std::size_t(active()) * kBlockValues);
}

template <class T>
void BlockGrid<T>::link_neighbours() {
  neighbour_.resize(std::size_t(active()) * 27);
#pragma omp parallel for schedule(static)
  for (int i = 0; i < active(); ++i)
    for (int n = 0; n < 27; ++n) {
      const BlockIndex b = block_[i];
      neighbour_[std::size_t(i) * 27 + n] =
          find(morton_key({b.x + n / 9 - 1, b.y + n / 3 % 3 - 1, b.z + n % 3 - 1}));
    }
}

template <class T>
void BlockGrid<T>::reduce(int i, bool add) {
  Row<T> keep_lower{}, keep_upper{};  // which lanes the tiles below and above in z fill
  for (int lane = 0; lane < 16; ++lane) (lane < 12 ? keep_lower : keep_upper)[lane] = T(1);
  const T* around[27];
  for (int n = 0; n < 27; ++n) around[n] = tile_if_occupied(neighbour_[std::size_t(i) * 27 + n]);
  T* out = nodes(i);
  for (int x = 0; x < kBlockEdge; ++x)
    for (int y = 0; y < kBlockEdge; ++y) {
      const AxisShare xs[2] = {{0, x + 1}, other_share(x)};
      const AxisShare ys[2] = {{0, y + 1}, other_share(y)};
      T* row = out + (x * kBlockEdge + y) * 16;
      Row<T> sum{};
      if (add) sum = load_lanes<Row<T>>(row);
      for (int a = 0; a < 4; ++a) {
        const AxisShare sx = xs[a >> 1], sy = ys[a & 1];
        const int column = (sx.neighbour + 1) * 9 + (sy.neighbour + 1) * 3 + 1;
        if (const T* t = around[column])
          sum += load_lanes<Row<T>>(tile_row(t, sx.tile_index, sy.tile_index) + kOwnZ);
        if (const T* t = around[column - 1])
          sum +=
              keep_lower * load_lanes<Row<T>>(tile_row(t, sx.tile_index, sy.tile_index) + kUpperZ);
        if (const T* t = around[column + 1])
          for (int c = 0; c < kComponents; ++c)
            sum[12 + c] += tile_row(t, sx.tile_index, sy.tile_index)[c];
      }
      store_lanes(row, sum);
    }
}

template <class T>
void BlockGrid<T>::load_tile(int i, T* tile) const {
  for (int x = 0; x < kTileEdge; ++x)
    for (int y = 0; y < kTileEdge; ++y) {
      const int dx = x == 0 ? -1 : x <= kBlockEdge ? 0 : 1;
      const int dy = y == 0 ? -1 : y <= kBlockEdge ? 0 : 1;
      const int local = (((x + 3) & 3) * kBlockEdge + ((y + 3) & 3)) * 16;
      T* row = tile + (x * kTileEdge + y) * kTileEdge * kComponents;
      std::memcpy(row + kUpperZ, nodes(neighbour(i, dx, dy, 1)) + local, 12 * sizeof(T));
      std::memcpy(row + kOwnZ, nodes(neighbour(i, dx, dy, 0)) + local, 16 * sizeof(T));
      std::memcpy(row, nodes(neighbour(i, dx, dy, -1)) + local + 12, 4 * sizeof(T));
    }
}

template <class T>
std::size_t BlockGrid<T>::memory_bytes() const {
  return tile_.capacity() * sizeof(T) + node_.capacity() * sizeof(T) +
         neighbour_.capacity() * sizeof(std::int32_t) + block_.capacity() * sizeof(BlockIndex) +
         slot_key_.capacity() * sizeof(std::uint64_t) +
         slot_block_.capacity() * sizeof(std::int32_t);
}

template class BlockGrid<float>;
template class BlockGrid<double>;

}  // namespace vulnus::injury
