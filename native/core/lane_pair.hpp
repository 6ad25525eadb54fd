// A bundle of 16 lanes as two vectors of 8, for processors whose registers hold 8 floats: there the
// compiler would keep a vector of 16 in memory and shuffle it lane by lane.
#pragma once

#include <cstdint>

#include "core/host_device.hpp"

namespace vulnus {

typedef float FloatHalf __attribute__((vector_size(32)));
typedef std::int32_t IntHalf __attribute__((vector_size(32)));

template <class H>
struct ElementOf;
template <>
struct ElementOf<FloatHalf> {
  using Type = float;
};
template <>
struct ElementOf<IntHalf> {
  using Type = std::int32_t;
};

template <class H>
struct LanePair {
  using Element = typename ElementOf<H>::Type;

  H half[2];

  VULNUS_HD Element& operator[](int lane) { return reinterpret_cast<Element*>(half)[lane]; }
  VULNUS_HD Element operator[](int lane) const {
    return reinterpret_cast<const Element*>(half)[lane];
  }
};

#define VULNUS_LANE_PAIR_OPERATOR(op)                                          \
  template <class H>                                                           \
  VULNUS_HD auto operator op(LanePair<H> a, LanePair<H> b) {                   \
    return LanePair<decltype(a.half[0] op b.half[0])>{a.half[0] op b.half[0],  \
                                                      a.half[1] op b.half[1]}; \
  }                                                                            \
  template <class H>                                                           \
  VULNUS_HD auto operator op(LanePair<H> a, typename ElementOf<H>::Type b) {   \
    return LanePair<decltype(a.half[0] op b)>{a.half[0] op b, a.half[1] op b}; \
  }                                                                            \
  template <class H>                                                           \
  VULNUS_HD auto operator op(typename ElementOf<H>::Type a, LanePair<H> b) {   \
    return LanePair<decltype(a op b.half[0])>{a op b.half[0], a op b.half[1]}; \
  }

VULNUS_LANE_PAIR_OPERATOR(+)
VULNUS_LANE_PAIR_OPERATOR(-)
VULNUS_LANE_PAIR_OPERATOR(*)
VULNUS_LANE_PAIR_OPERATOR(/)
VULNUS_LANE_PAIR_OPERATOR(<)
VULNUS_LANE_PAIR_OPERATOR(>)
VULNUS_LANE_PAIR_OPERATOR(<=)
VULNUS_LANE_PAIR_OPERATOR(>=)
VULNUS_LANE_PAIR_OPERATOR(==)
VULNUS_LANE_PAIR_OPERATOR(&)
VULNUS_LANE_PAIR_OPERATOR(|)
VULNUS_LANE_PAIR_OPERATOR(<<)
VULNUS_LANE_PAIR_OPERATOR(>>)
#undef VULNUS_LANE_PAIR_OPERATOR

template <class H>
VULNUS_HD LanePair<H> operator-(LanePair<H> a) {
  return {-a.half[0], -a.half[1]};
}
template <class H>
VULNUS_HD LanePair<H> operator~(LanePair<H> a) {
  return {~a.half[0], ~a.half[1]};
}
template <class H, class B>
VULNUS_HD LanePair<H>& operator+=(LanePair<H>& a, B b) {
  return a = a + b;
}
template <class H, class B>
VULNUS_HD LanePair<H>& operator-=(LanePair<H>& a, B b) {
  return a = a - b;
}
template <class H, class B>
VULNUS_HD LanePair<H>& operator*=(LanePair<H>& a, B b) {
  return a = a * b;
}
template <class H>
VULNUS_HD LanePair<H>& operator|=(LanePair<H>& a, LanePair<H> b) {
  return a = a | b;
}
template <class H>
VULNUS_HD LanePair<H>& operator&=(LanePair<H>& a, LanePair<H> b) {
  return a = a & b;
}

}  // namespace vulnus
