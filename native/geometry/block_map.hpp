// Where the 8x8x8 blocks of a sparse grid are: an open-addressing table from block coordinates to
// an index, or to the mark of a tile that lies wholly inside.
#pragma once

#include <cstdint>
#include <vector>

namespace vulnus::geometry {

constexpr int kSide = 8;                       // voxels along a block's edge
constexpr int kBlock = kSide * kSide * kSide;  // voxels of a block
constexpr std::int32_t kOutside = -1;          // no block there: outside the band, phi > 0
constexpr std::int32_t kInside = -2;           // no block there: inside the band, phi < 0

struct BlockCoordinate {
  std::int32_t x, y, z;
  friend bool operator==(const BlockCoordinate&, const BlockCoordinate&) = default;
  friend auto operator<=>(const BlockCoordinate&, const BlockCoordinate&) = default;
};

inline int voxel_offset(int x, int y, int z) { return (x * kSide + y) * kSide + z; }
inline std::int32_t block_of(std::int32_t voxel) { return voxel >> 3; }  // floor(voxel / 8)
inline int within_block(std::int32_t voxel) { return voxel & 7; }

class BlockMap {
 public:
  BlockMap() { slots_.resize(64); }

  std::int32_t find(const BlockCoordinate& block) const {
    for (std::uint64_t slot = hash(block) & mask();; slot = (slot + 1) & mask()) {
      if (!slots_[slot].used) return kOutside;
      if (slots_[slot].block == block) return slots_[slot].value;
    }
  }

  // The value stored for `block`; `value` is stored first where there is none.
  std::int32_t& find_or_insert(const BlockCoordinate& block, std::int32_t value) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    for (std::uint64_t slot = hash(block) & mask();; slot = (slot + 1) & mask()) {
      Slot& entry = slots_[slot];
      if (!entry.used) {
        entry = {block, value, true};
        ++count_;
        return entry.value;
      }
      if (entry.block == block) return entry.value;
    }
  }

  std::size_t size() const { return count_; }
  std::size_t memory_bytes() const { return slots_.size() * sizeof(Slot); }

  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (const Slot& entry : slots_) {
      if (entry.used) visit(entry.block, entry.value);
    }
  }

 private:
  struct Slot {
    BlockCoordinate block{0, 0, 0};
    std::int32_t value = kOutside;
    bool used = false;
  };

  static std::uint64_t hash(const BlockCoordinate& block) {
    std::uint64_t key = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.x)) << 42) ^
                        (static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.y)) << 21) ^
                        static_cast<std::uint64_t>(static_cast<std::uint32_t>(block.z));
    key *= 0x9E3779B97F4A7C15ull;  // Fibonacci hashing (Knuth, TAOCP 3, §6.4)
    return key ^ (key >> 32);
  }

  std::uint64_t mask() const { return slots_.size() - 1; }

  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    count_ = 0;
    for (const Slot& entry : old) {
      if (entry.used) find_or_insert(entry.block, entry.value);
    }
  }

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
};

}  // namespace vulnus::geometry
