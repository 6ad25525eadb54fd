// A vector whose data starts on a cache line, so that lanes load without crossing one. Growing
// does not write: pages are touched first by the thread that uses them.
#pragma once

#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace vulnus {

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class U>
  CacheLineAllocator(const CacheLineAllocator<U>&) {}
  T* allocate(std::size_t n) {
    return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t{64}));
  }
  void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t{64}); }
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;  // default, not value: leaves numbers unset
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  template <class U>
  bool operator==(const CacheLineAllocator<U>&) const {
    return true;
  }
};

template <class T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;

// Resizes with a sixteenth to spare rather than twice the room; the content is lost.
template <class T>
void grow(AlignedVector<T>& values, std::size_t size) {
  if (values.capacity() < size) {
    values = AlignedVector<T>();
    values.reserve(size + size / 16);
  }
  values.resize(size);
}

}  // namespace vulnus
