// Floating point operations of a particle-step: the laws run on a number that counts what is done
// with it, the transfers are counted by the rows of their text. Comparisons and selections are
// free, a square root, a division and each term of a polynomial count as they stand in lanes.hpp.
// Prints "name value" lines.
#include <cmath>
#include <cstdio>
#include <random>

#include "core/host_device.hpp"

namespace vulnus {

long flops = 0;

struct Counted {
  float value = 0;
  Counted operator-() const { return {-value}; }
};

inline Counted counted(float value, int operations) {
  flops += operations;
  return {value};
}
inline Counted operator+(Counted a, Counted b) { return counted(a.value + b.value, 1); }
inline Counted operator-(Counted a, Counted b) { return counted(a.value - b.value, 1); }
inline Counted operator*(Counted a, Counted b) { return counted(a.value * b.value, 1); }
inline Counted operator/(Counted a, Counted b) { return counted(a.value / b.value, 1); }
inline Counted operator+(Counted a, float b) { return {a.value + b}; }  // `broadcast`
inline Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
inline Counted& operator-=(Counted& a, Counted b) { return a = a - b; }
inline bool operator<(Counted a, Counted b) { return a.value < b.value; }
inline bool operator>(Counted a, Counted b) { return a.value > b.value; }
inline bool operator<=(Counted a, Counted b) { return a.value <= b.value; }
inline bool operator>=(Counted a, Counted b) { return a.value >= b.value; }
inline bool operator==(Counted a, Counted b) { return a.value == b.value; }

inline Counted select(bool mask, Counted a, Counted b) { return mask ? a : b; }
inline Counted square_root(Counted a) { return counted(std::sqrt(a.value), 1); }
inline Counted reciprocal_square_root(Counted a) { return counted(1 / std::sqrt(a.value), 6); }
inline Counted logarithm(Counted a) { return counted(std::log(a.value), 28); }
inline Counted log_one_plus(Counted a) { return counted(std::log1p(a.value), 33); }
inline Counted exp_minus_one(Counted a) { return counted(std::expm1(a.value), 25); }

}  // namespace vulnus

#include "core/lanes.hpp"

namespace vulnus {
template <>
struct ScalarOf<Counted> {
  using Type = float;
};
}  // namespace vulnus

#include "injury/shape_function.hpp"
#include "injury/stress_update.hpp"

namespace {

using namespace vulnus;
using namespace vulnus::injury;

// transfer.hpp: rows of 16 values on which one operation is done, for one particle.
constexpr int kGatherRows = 5 + 3 * 11 + 3 + 4 + 3;    // z weights, planes, moments, sums
constexpr int kScatterRows = 5 + 5 + 3 * (2 + 9 + 1);  // z weights, q a_x a_y, planes
constexpr int kRow = 16;
constexpr int kGatherLanes = 3 * (1 + 3 * 3);             // v and C from the moments
constexpr int kScatterLanes = 5 + 3 * (1 + 3 * (3 + 2));  // mass, momentum, affine part
constexpr int kPlace = 3 * (2 + 3);                       // cell, floor and fraction of a position

Material<Counted> muscle_like(bool flows) {
  Material<Counted> m{};
  m.density = {1060};
  m.bulk_modulus = {2.3e9f};
  m.shear_modulus = {3.5e6f};
  m.volume_exponent = {7};
  m.volume_growth = {1};
  m.yield_stress = {flows ? 3e4f : 1e30f};
  m.rate_reference = {3};
  m.rate_exponent = {0.36f};
  m.pressure_cutoff = {3e5f};
  m.tensile_strength = {1e30f};
  m.network_modulus = {1e5f};
  m.break_start = {0.44f};
  m.break_slope = {3.3f};
  return m;
}

// Laws of one step of a point with random strains and a random velocity gradient.
void strain_and_stress(const Material<Counted>& m, std::mt19937& random) {
  std::normal_distribution<float> normal;
  PointState<Counted> point{};
  Counted* entry[12] = {&point.strain.xx,  &point.strain.yy,  &point.strain.zz,  &point.strain.xy,
                        &point.strain.yz,  &point.strain.zx,  &point.network.xx, &point.network.yy,
                        &point.network.zz, &point.network.xy, &point.network.yz, &point.network.zx};
  for (Counted* e : entry) e->value = 0.02f * normal(random);
  Matrix3<Counted> gradient, increment;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      gradient.m[i][j].value = 1e4f * normal(random);
      increment.m[i][j] = gradient.m[i][j] * Counted{3e-7f};
    }
  point.strain = advance_strain(point.strain, increment);
  point.network = advance_strain(point.network, increment);
  determinant_of_step(increment);
  update_stress(m, equivalent_strain_rate(gradient), point);
}

double mean_flops(bool flows) {
  constexpr int kPoints = 10000;
  std::mt19937 random(1);
  flops = 0;
  const Material<Counted> m = muscle_like(flows);
  for (int i = 0; i < kPoints; ++i) strain_and_stress(m, random);
  return double(flops) / kPoints;
}

double weight_flops() {
  flops = 0;
  Counted weight[3];
  quadratic_weights(Counted{1.2f}, weight);
  return 3.0 * flops + kPlace;
}

}  // namespace

int main() {
  std::printf("gather %.0f\n", kRow * kGatherRows + kGatherLanes + weight_flops());
  std::printf("scatter %.0f\n", kRow * kScatterRows + kScatterLanes + weight_flops());
  std::printf("laws %.0f\n", mean_flops(true));
}
