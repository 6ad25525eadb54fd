// Candidates of each cell: all blood and barrier particles that may come within h of any particle
// of the cell before the next search. One list a cell (not a particle), so that it is short in
// memory and its values are fetched once for all particles of the cell.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hemorrhage/cell_order.hpp"
#include "hemorrhage/particles.hpp"

namespace vulnus::hemorrhage {

// A candidate is an index in its low bits and, above them, which periodic image of it is meant.
inline constexpr int kImageShift = 26;
inline constexpr std::uint32_t kIndexMask = (1u << kImageShift) - 1;
inline constexpr std::uint32_t kOwnImage = 13;  // of 27, (0, 0, 0)

template <class Real>
struct Periodicity {
  std::array<Real, 3> lower{}, length{0, 0, 0};  // length 0: the axis is open
  bool any() const { return length[0] > 0 || length[1] > 0 || length[2] > 0; }
  std::array<Real, 3> shift(std::uint32_t image) const {
    return {Real(int(image / 9) - 1) * length[0], Real(int(image / 3 % 3) - 1) * length[1],
            Real(int(image % 3) - 1) * length[2]};
  }
};

struct CellBatch {
  std::int32_t first_cell = 0, last_cell = 0;
  std::vector<std::uint32_t> blood, barrier;
  std::vector<std::uint32_t> blood_start, barrier_start;  // per cell, one more than cells
};

template <class Real>
class Neighbours {
 public:
  static constexpr int kCellsPerBatch = 8;

  // Finds candidates around the built positions of particles that are in cell order.
  void search(const Particles<Real>& particles, const CellOrder<Real>& order,
              const BarrierParticles<Real>& barrier, const CellOrder<Real>& barrier_order,
              const Periodicity<Real>& periodicity, Real blood_reach, Real barrier_reach,
              int threads);

  const std::vector<CellBatch>& batches() const { return batches_; }
  std::size_t batch_count() const { return used_; }
  // The other way round: blood near each barrier cell that any blood is near. A wet batch's cells
  // are places in `wet_cells`.
  const std::vector<CellBatch>& wet_batches() const { return wet_batches_; }
  std::size_t wet_batch_count() const { return wet_used_; }
  // Barrier cells that were wet before the last search and are not any more.
  const std::vector<std::int32_t>& dried_cells() const { return dried_cells_; }
  std::int32_t wet_cell(std::int32_t place) const { return wet_cells_[place]; }
  std::size_t memory_bytes() const;

 private:
  void list_wet_cells(const BarrierParticles<Real>& barrier, std::size_t barrier_cells);
  void search_wet(const Particles<Real>& particles, const CellOrder<Real>& order,
                  const BarrierParticles<Real>& barrier, const CellOrder<Real>& barrier_order,
                  const Periodicity<Real>& periodicity, Real reach, int threads);

  std::vector<CellBatch> batches_, wet_batches_;
  std::size_t used_ = 0, wet_used_ = 0;
  std::vector<std::uint8_t> is_wet_;
  std::vector<std::int32_t> wet_cells_, dried_cells_;
};

extern template class Neighbours<float>;
extern template class Neighbours<double>;

}  // namespace vulnus::hemorrhage
