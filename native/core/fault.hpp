// Trouble inside a loop travels as bits of a code with the index of the particle that had it;
// Python turns it into an UnstableStepError. The lowest particle index wins, so that the report
// does not depend on the number of threads.
#pragma once

#include <atomic>
#include <cstdint>

namespace vulnus {

enum FaultBits : std::uint32_t {
  kNoFault = 0,
  kNotFinite = 1u << 0,
  kInvertedElement = 1u << 1,
  kLeftDomain = 1u << 2,
  kNeighbourOverflow = 1u << 3,
  kStepTooSmall = 1u << 4,
  kUnsolvedContact = 1u << 5,
};

class FaultRecord {
 public:
  void raise(std::uint32_t bits, std::int64_t particle) {
    bits_.fetch_or(bits, std::memory_order_relaxed);
    std::int64_t current = particle_.load(std::memory_order_relaxed);
    while (particle < current &&
           !particle_.compare_exchange_weak(current, particle, std::memory_order_relaxed)) {
    }
  }
  void clear() {
    bits_.store(kNoFault);
    particle_.store(INT64_MAX);
  }
  std::uint32_t bits() const { return bits_.load(); }
  std::int64_t particle() const { return bits() == kNoFault ? -1 : particle_.load(); }

 private:
  std::atomic<std::uint32_t> bits_{kNoFault};
  std::atomic<std::int64_t> particle_{INT64_MAX};
};

}  // namespace vulnus
