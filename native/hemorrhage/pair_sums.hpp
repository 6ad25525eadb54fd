// Sums over the neighbours of one particle, from a buffer that holds all candidates of its cell in
// a row: no index, no branch, so the compiler turns them into vector instructions. Candidates
// beyond h count nothing because the kernels are zero there.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hemorrhage/forces.hpp"
#include "hemorrhage/smoothing_kernel.hpp"

namespace vulnus::hemorrhage {

// GCC's tuning for some processors stops at half of the widest registers that they have.
#if defined(__AVX512F__) && defined(__GNUC__) && !defined(__clang__)
#define VULNUS_WIDE __attribute__((target("prefer-vector-width=512"), noinline))
#else
#define VULNUS_WIDE
#endif

inline constexpr std::size_t kLanes = 16;
inline std::size_t padded(std::size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

template <class Real>
struct CandidateBuffer {
  static constexpr int kFields = 9;
  Real *x, *y, *z, *weight, *vx, *vy, *vz, *p_over_rho2, *inverse_density;

  void reserve(std::size_t n) {
    const std::size_t stride = padded(n) + kLanes;
    if (storage_.size() < kFields * stride + kLanes) storage_.resize(kFields * stride + kLanes);
    auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
    Real* base = reinterpret_cast<Real*>((address + 63) / 64 * 64);
    Real** fields[kFields] = {&x, &y, &z, &weight, &vx, &vy, &vz, &p_over_rho2, &inverse_density};
    for (int f = 0; f < kFields; ++f) *fields[f] = base + f * stride;
  }

  // The same buffer from candidate `offset` on, a multiple of `kLanes`.
  CandidateBuffer from(std::size_t offset) const {
    CandidateBuffer part;
    part.x = x + offset, part.y = y + offset, part.z = z + offset, part.weight = weight + offset;
    part.vx = vx + offset, part.vy = vy + offset, part.vz = vz + offset;
    part.p_over_rho2 = p_over_rho2 + offset, part.inverse_density = inverse_density + offset;
    return part;
  }

  // Fills up to a whole vector with a candidate so far away that it counts nothing.
  void pad(std::size_t n) {
    for (std::size_t k = n; k < padded(n); ++k) {
      x[k] = y[k] = z[k] = Real(1e6);
      weight[k] = vx[k] = vy[k] = vz[k] = p_over_rho2[k] = inverse_density[k] = 0;
    }
  }

 private:
  std::vector<Real> storage_;
};

// Sum of eq. (6) without the mass and the kernel's factor.
template <class Real, class Kernels>
VULNUS_WIDE Real density_sum(const Kernels& kernels, const CandidateBuffer<Real>& b, std::size_t n,
                             Real xi, Real yi, Real zi) {
  const Real *bx = b.x, *by = b.y, *bz = b.z, *bw = b.weight;
  Real sum = 0;
#pragma omp simd reduction(+ : sum) aligned(bx, by, bz, bw : 64)
  for (std::size_t k = 0; k < n; ++k) {
    const Real dx = xi - bx[k], dy = yi - by[k], dz = zi - bz[k];
    sum += density_share(bw[k], kernels.density(dx * dx + dy * dy + dz * dz));
  }
  return sum;
}

// One particle's own values, and its sums of eq. (10) and (11) without the constant factors.
template <class Real>
struct Probe {
  Real x, y, z, vx, vy, vz, p_over_rho2, inverse_density;
};

template <class Real>
struct PairForces {
  Real pressure_x = 0, pressure_y = 0, pressure_z = 0;
  Real viscous_x = 0, viscous_y = 0, viscous_z = 0;
};

template <class Real>
struct PairConstants {
  Real tiny_r2;  // keeps r > 0, so that a particle exerts no force on itself
  Real dissipation, sound_speed, rest_density, inverse_rest_density;
  Real gx, gy, gz;
};

template <class Real, class Kernels>
VULNUS_WIDE void blood_forces(const Kernels& kernels, const CandidateBuffer<Real>& b, std::size_t n,
                              const Probe<Real>& i, const PairConstants<Real>& c,
                              PairForces<Real>& out) {
  const Real *bx = b.x, *by = b.y, *bz = b.z, *bw = b.weight;
  const Real *bu = b.vx, *bv = b.vy, *bs = b.vz, *bp = b.p_over_rho2, *bi = b.inverse_density;
  Real px = 0, py = 0, pz = 0, qx = 0, qy = 0, qz = 0;
#pragma omp simd reduction(+ : px, py, pz, qx, qy, qz) \
    aligned(bx, by, bz, bw, bu, bv, bs, bp, bi : 64)
  for (std::size_t k = 0; k < n; ++k) {
    const Real dx = i.x - bx[k], dy = i.y - by[k], dz = i.z - bz[k];
    const Real dvx = bu[k] - i.vx, dvy = bv[k] - i.vy, dvz = bs[k] - i.vz;
    const Real r2 = dx * dx + dy * dy + dz * dz + c.tiny_r2;
    const Real inverse_r = Real(1) / std::sqrt(r2);
    const Real r = r2 * inverse_r;
    const Real closing = (dvx * dx + dvy * dy + dvz * dz) * inverse_r;
    const Real shock =
        dissipation_zhang2017(closing, c.dissipation, c.sound_speed, c.inverse_rest_density);
    const Real p =
        pressure_pair(bw[k], i.p_over_rho2, bp[k], shock, kernels.gradient_over_r(r, inverse_r));
    const Real q = viscosity_pair(bw[k], bi[k], kernels.laplacian(r));
    px += p * dx, py += p * dy, pz += p * dz;
    qx += q * dvx, qy += q * dvy, qz += q * dvz;
  }
  out.pressure_x += px, out.pressure_y += py, out.pressure_z += pz;
  out.viscous_x += qx, out.viscous_y += qy, out.viscous_z += qz;
}

// A barrier's particles press back with the pressure they were given. They stand still, but
// friction sees their mirrored velocity, so that blood stands still at the barrier's face (no
// slip).
template <class Real, class Kernels>
VULNUS_WIDE void barrier_forces(const Kernels& kernels, const CandidateBuffer<Real>& b,
                                std::size_t n, const Probe<Real>& i, const PairConstants<Real>& c,
                                PairForces<Real>& out) {
  const Real *bx = b.x, *by = b.y, *bz = b.z, *bw = b.weight;
  const Real *bu = b.vx, *bv = b.vy, *bs = b.vz, *bp = b.p_over_rho2, *bi = b.inverse_density;
  Real px = 0, py = 0, pz = 0, qx = 0, qy = 0, qz = 0;
#pragma omp simd reduction(+ : px, py, pz, qx, qy, qz) \
    aligned(bx, by, bz, bw, bu, bv, bs, bp, bi : 64)
  for (std::size_t k = 0; k < n; ++k) {
    const Real dx = i.x - bx[k], dy = i.y - by[k], dz = i.z - bz[k];
    const Real r2 = dx * dx + dy * dy + dz * dz + c.tiny_r2;
    const Real inverse_r = Real(1) / std::sqrt(r2);
    const Real r = r2 * inverse_r;
    const Real closing = -(i.vx * dx + i.vy * dy + i.vz * dz) * inverse_r;
    const Real shock =
        dissipation_zhang2017(closing, c.dissipation, c.sound_speed, c.inverse_rest_density);
    const Real p =
        pressure_pair(bw[k], i.p_over_rho2, bp[k], shock, kernels.gradient_over_r(r, inverse_r));
    const Real q = viscosity_pair(bw[k], bi[k], kernels.laplacian(r));
    px += p * dx, py += p * dy, pz += p * dz;
    qx += q * (bu[k] - i.vx), qy += q * (bv[k] - i.vy), qz += q * (bs[k] - i.vz);
  }
  out.pressure_x += px, out.pressure_y += py, out.pressure_z += pz;
  out.viscous_x += qx, out.viscous_y += qy, out.viscous_z += qz;
}

// Sums over blood around a barrier particle, each weighted by the kernel: the weights, the pressure
// continued to it from each neighbour, p_j + rho0 g.(r_b - r_j), and the velocity. `p_over_rho2` of
// the buffer holds p_j here.
template <class Real>
struct MirrorSums {
  Real weight = 0, pressure = 0, vx = 0, vy = 0, vz = 0;
};

template <class Real, class Kernels>
VULNUS_WIDE MirrorSums<Real> mirror_sums(const Kernels& kernels, const CandidateBuffer<Real>& b,
                                         std::size_t n, Real xb, Real yb, Real zb,
                                         const PairConstants<Real>& c) {
  const Real *bx = b.x, *by = b.y, *bz = b.z, *bw = b.weight, *bp = b.p_over_rho2;
  const Real *bu = b.vx, *bv = b.vy, *bs = b.vz;
  Real sum = 0, sum_p = 0, sum_u = 0, sum_v = 0, sum_s = 0;
#pragma omp simd reduction(+ : sum, sum_p, sum_u, sum_v, sum_s) \
    aligned(bx, by, bz, bw, bp, bu, bv, bs : 64)
  for (std::size_t k = 0; k < n; ++k) {
    const Real dx = xb - bx[k], dy = yb - by[k], dz = zb - bz[k];
    const Real share = density_share(bw[k], kernels.density(dx * dx + dy * dy + dz * dz));
    const Real continued =
        mirrored_pressure(bp[k], c.rest_density, c.gx * dx + c.gy * dy + c.gz * dz);
    sum += share;
    sum_p += interpolation_share(continued, share, Real(1));
    sum_u += interpolation_share(bu[k], share, Real(1));
    sum_v += interpolation_share(bv[k], share, Real(1));
    sum_s += interpolation_share(bs[k], share, Real(1));
  }
  return {sum, sum_p, sum_u, sum_v, sum_s};
}

}  // namespace vulnus::hemorrhage
