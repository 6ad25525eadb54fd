// The material points as arrays, one a quantity, kept in the order of blocks and cells. Every
// block's points start at a multiple of the lane width; the places left over hold copies without
// volume (id -1).
#pragma once

#include <cstdint>
#include <vector>

#include "injury/block_grid.hpp"

namespace vulnus::injury {

enum ParticleField {
  kPosition = 0,  // 3 [m], in the local frame
  kVelocity = 3,  // 3 [m/s]
  kGradient = 6,  // 9 [1/s], APIC's C, row by row
  kStrain = 15,   // 6, b_e - I as xx yy zz xy yz zx
  kVolume = 21,   // [m^3], undeformed
  kPlasticStrain = 22,
  kOpening = 23,
  kDamage = 24,         // 0 to 1
  kNetworkStrain = 25,  // 6, b - I of the network, in the order of kStrain
  kParticleFields = 31
};

template <class T>
class ParticleSet {
 public:
  static constexpr int kWidth = LaneTraits<T>::kWidth;

  // Room for n points without order; fields are zero.
  void reset(int n);
  // Takes a saved order as it is.
  void restore(std::size_t places, const T* fields, const std::int32_t* ids,
               const std::uint8_t* materials);
  // Sorts into blocks and cells, and makes the grid for the occupied blocks.
  void sort(T cells_per_metre, BlockGrid<T>& grid);

  int count() const { return count_; }
  int places() const { return static_cast<int>(id.size()); }
  // The first bundle of block i; blocks end where the next begins.
  int first_bundle(int i) const { return first_bundle_[i]; }
  // The most bundles of a block.
  int largest_block() const { return largest_block_; }
  // Of each cell of block i the place behind its last point, as sorted.
  const std::int32_t* cell_ends(int i) const {
    return cell_place_.data() + std::size_t(i) * kBlockNodes;
  }
  std::size_t memory_bytes() const;

  AlignedVector<T> field[kParticleFields];
  AlignedVector<std::int32_t> id;
  AlignedVector<std::uint8_t> material;

 private:
  void compute_keys(T cells_per_metre);
  std::vector<std::uint64_t> occupied_blocks() const;
  void assign_places(const BlockGrid<T>& grid);
  void permute();

  int count_ = 0;
  int largest_block_ = 0;
  std::vector<std::int32_t> first_bundle_;
  AlignedVector<std::uint64_t> key_;    // block << 6 | cell; all ones for a place without a point
  AlignedVector<std::int32_t> source_;  // for every new place: where its point stands now
  AlignedVector<T> spare_;
  std::vector<std::int32_t> cell_place_;
};

extern template class ParticleSet<float>;
extern template class ParticleSet<double>;

}  // namespace vulnus::injury
