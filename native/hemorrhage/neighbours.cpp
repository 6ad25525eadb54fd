#include "hemorrhage/neighbours.hpp"

namespace vulnus::hemorrhage {
namespace {

template <class Real>
Box<Real> bounding_box(const Real* x, const Real* y, const Real* z, std::int32_t first,
                       std::int32_t last) {
  Box<Real> box{{x[first], y[first], z[first]}, {x[first], y[first], z[first]}};
  for (std::int32_t i = first + 1; i < last; ++i) {
    const std::array<Real, 3> point{x[i], y[i], z[i]};
    for (int a = 0; a < 3; ++a) {
      box.lower[a] = std::min(box.lower[a], point[a]);
      box.upper[a] = std::max(box.upper[a], point[a]);
    }
  }
  return box;
}

template <class Real>
Box<Real> moved(Box<Real> box, const std::array<Real, 3>& by, Real grow) {
  for (int a = 0; a < 3; ++a) {
    box.lower[a] += by[a] - grow;
    box.upper[a] += by[a] + grow;
  }
  return box;
}

template <class Real>
Real outside(Real value, Real lower, Real upper) {
  return std::max(std::max(lower - value, value - upper), Real(0));
}

// Appends all points of `order` within `reach` of the box, as candidates of one periodic image.
template <class Real>
void collect(const CellOrder<Real>& order, const Real* x, const Real* y, const Real* z,
             const Box<Real>& box, Real reach, std::uint32_t image,
             std::vector<std::uint32_t>& found) {
  const Real reach2 = reach * reach;
  const std::uint32_t tag = image << kImageShift;
  order.visit_rows(moved(box, {0, 0, 0}, reach), [&](std::int32_t first, std::int32_t last) {
    const std::size_t before = found.size();
    found.resize(before + static_cast<std::size_t>(last - first));
    std::uint32_t* out = found.data() + before;
    for (std::int32_t j = first; j < last; ++j) {
      const Real dx = outside(x[j], box.lower[0], box.upper[0]);
      const Real dy = outside(y[j], box.lower[1], box.upper[1]);
      const Real dz = outside(z[j], box.lower[2], box.upper[2]);
      *out = tag | static_cast<std::uint32_t>(j);
      out += dx * dx + dy * dy + dz * dz < reach2 ? 1 : 0;
    }
    found.resize(static_cast<std::size_t>(out - found.data()));
  });
}

template <class Real>
void collect_images(const CellOrder<Real>& order, const Real* x, const Real* y, const Real* z,
                    const Box<Real>& box, Real reach, const Periodicity<Real>& periodicity,
                    std::vector<std::uint32_t>& found) {
  collect(order, x, y, z, box, reach, kOwnImage, found);
  if (!periodicity.any()) return;
  for (std::uint32_t image = 0; image < 27; ++image) {
    if (image == kOwnImage) continue;
    const std::array<Real, 3> shift = periodicity.shift(image);
    const std::array<int, 3> step{int(image / 9) - 1, int(image / 3 % 3) - 1, int(image % 3) - 1};
    bool exists = true;
    for (int a = 0; a < 3; ++a) exists = exists && (step[a] == 0 || periodicity.length[a] > 0);
    if (!exists) continue;
    const Box<Real> there = moved(box, {-shift[0], -shift[1], -shift[2]}, Real(0));
    collect(order, x, y, z, there, reach, image, found);
  }
}

}  // namespace

template <class Real>
void Neighbours<Real>::search(const Particles<Real>& p, const CellOrder<Real>& order,
                              const BarrierParticles<Real>& barrier,
                              const CellOrder<Real>& barrier_order,
                              const Periodicity<Real>& periodicity, Real blood_reach,
                              Real barrier_reach, int threads) {
  const int cells = static_cast<int>(order.cell_count());
  used_ = static_cast<std::size_t>((cells + kCellsPerBatch - 1) / kCellsPerBatch);
  if (batches_.size() < used_) batches_.resize(used_);
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads) if (threads > 1)
  for (std::int64_t b = 0; b < static_cast<std::int64_t>(used_); ++b) {
    CellBatch& batch = batches_[b];
    batch.first_cell = static_cast<std::int32_t>(b * kCellsPerBatch);
    batch.last_cell = std::min<std::int32_t>(batch.first_cell + kCellsPerBatch, cells);
    batch.blood.clear();
    batch.barrier.clear();
    batch.blood_start.assign(1, 0);
    batch.barrier_start.assign(1, 0);
    for (std::int32_t c = batch.first_cell; c < batch.last_cell; ++c) {
      const Real *x = p.built_x.data(), *y = p.built_y.data(), *z = p.built_z.data();
      const Box<Real> box = bounding_box(x, y, z, order.cell_start(c), order.cell_start(c + 1));
      collect_images(order, x, y, z, box, blood_reach, periodicity, batch.blood);
      collect_images(barrier_order, barrier.x.data(), barrier.y.data(), barrier.z.data(), box,
                     barrier_reach, periodicity, batch.barrier);
      batch.blood_start.push_back(static_cast<std::uint32_t>(batch.blood.size()));
      batch.barrier_start.push_back(static_cast<std::uint32_t>(batch.barrier.size()));
    }
  }
  list_wet_cells(barrier, barrier_order.cell_count());
  search_wet(p, order, barrier, barrier_order, periodicity, barrier_reach, threads);
}

template <class Real>
void Neighbours<Real>::list_wet_cells(const BarrierParticles<Real>& barrier,
                                      std::size_t barrier_cells) {
  is_wet_.resize(barrier_cells, 0);
  for (const std::int32_t c : wet_cells_) is_wet_[c] = 0;
  dried_cells_.swap(wet_cells_);
  wet_cells_.clear();
  for (std::size_t b = 0; b < used_; ++b) {
    for (const std::uint32_t candidate : batches_[b].barrier) {
      const std::int32_t c = barrier.cell[candidate & kIndexMask];
      if (is_wet_[c]) continue;
      is_wet_[c] = 1;
      wet_cells_.push_back(c);
    }
  }
  std::sort(wet_cells_.begin(), wet_cells_.end());
  std::erase_if(dried_cells_, [this](std::int32_t c) { return is_wet_[c] != 0; });
}

template <class Real>
void Neighbours<Real>::search_wet(const Particles<Real>& p, const CellOrder<Real>& order,
                                  const BarrierParticles<Real>& barrier,
                                  const CellOrder<Real>& barrier_order,
                                  const Periodicity<Real>& periodicity, Real reach, int threads) {
  const int cells = static_cast<int>(wet_cells_.size());
  wet_used_ = static_cast<std::size_t>((cells + kCellsPerBatch - 1) / kCellsPerBatch);
  if (wet_batches_.size() < wet_used_) wet_batches_.resize(wet_used_);
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads) if (threads > 1)
  for (std::int64_t b = 0; b < static_cast<std::int64_t>(wet_used_); ++b) {
    CellBatch& batch = wet_batches_[b];
    batch.first_cell = static_cast<std::int32_t>(b * kCellsPerBatch);
    batch.last_cell = std::min<std::int32_t>(batch.first_cell + kCellsPerBatch, cells);
    batch.blood.clear();
    batch.blood_start.assign(1, 0);
    for (std::int32_t place = batch.first_cell; place < batch.last_cell; ++place) {
      const std::int32_t c = wet_cells_[place];
      const Box<Real> box =
          bounding_box(barrier.x.data(), barrier.y.data(), barrier.z.data(),
                       barrier_order.cell_start(c), barrier_order.cell_start(c + 1));
      collect_images(order, p.built_x.data(), p.built_y.data(), p.built_z.data(), box, reach,
                     periodicity, batch.blood);
      batch.blood_start.push_back(static_cast<std::uint32_t>(batch.blood.size()));
    }
  }
}

template <class Real>
std::size_t Neighbours<Real>::memory_bytes() const {
  std::size_t bytes = batches_.capacity() * sizeof(CellBatch);
  for (const auto* list : {&batches_, &wet_batches_}) {
    for (const CellBatch& b : *list) {
      bytes += sizeof(std::uint32_t) * (b.blood.capacity() + b.barrier.capacity() +
                                        b.blood_start.capacity() + b.barrier_start.capacity());
    }
  }
  return bytes;
}

template class Neighbours<float>;
template class Neighbours<double>;

}  // namespace vulnus::hemorrhage
