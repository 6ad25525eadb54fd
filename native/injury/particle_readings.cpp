#include "injury/particle_readings.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vulnus::injury {

namespace {

constexpr int kLanes = LaneTraits<double>::kWidth;
constexpr int kChunk =
    512 * kLanes;  // places whose sum is taken by one thread; chosen: some 0.1 ms

// Up to eight neighbouring points as doubles; lanes past the end repeat the last without volume.
template <class T>
struct Octet {
  PointState<Double8> point{};
  Double8 volume{};
  Int8 material{};
  Double8 hencky[3];
  Eigen3<Double8> eigen;
  Double8 log_jacobian;

  Octet(const ParticleSet<T>& set, int first) {
    const int last = set.places() - 1;
    auto load = [&](int field) {
      Double8 r{};
      for (int i = 0; i < kLanes; ++i) r[i] = set.field[field][std::min(first + i, last)];
      return r;
    };
    auto tensor = [&](int f) -> Symmetric3<Double8> {
      return {load(f), load(f + 1), load(f + 2), load(f + 3), load(f + 4), load(f + 5)};
    };
    point = {tensor(kStrain), tensor(kNetworkStrain), load(kPlasticStrain), load(kOpening),
             load(kDamage)};
    volume = load(kVolume);
    for (int i = 0; i < kLanes; ++i) {
      material[i] = set.material[std::min(first + i, last)];
      if (first + i > last) volume[i] = 0;
    }
    eigen = symmetric_eigen(point.strain);
    principal_hencky(eigen, hencky);
    log_jacobian = hencky[0] + hencky[1] + hencky[2] + point.opening;
  }
};

template <class T>
Double8 stored_energy(const Octet<T>& o, const Material<Double8>& m) {
  const NetworkStretch<Double8> stretch = network_stretch(o.point.network, o.log_jacobian);
  return hencky_energy(m, o.hencky) + (1.0 - o.point.damage) * network_energy(m, stretch.excess);
}

constexpr int kExchangeIterations = 25;  // for strains up to 3

// Principal Hencky strains of an octet under new constants and equal Kirchhoff stress.
struct ExchangedStrain {
  Double8 hencky[3];
  Double8 before, volume;  // the volumetric strain before and after
};

template <class T>
ExchangedStrain exchange_strain(const Octet<T>& o, const Material<Double8>& old,
                                const Material<Double8>& m) {
  ExchangedStrain e;
  e.before = o.hencky[0] + o.hencky[1] + o.hencky[2];
  e.volume =
      volume_strain_at(m, volumetric_kirchhoff(old, e.before), Double8{}, kExchangeIterations);
  const auto fluid = m.shear_modulus <= Double8{};
  const Double8 ratio =
      select(fluid, Double8{}, old.shear_modulus) / select(fluid, Double8{} + 1.0, m.shear_modulus);
  for (int a = 0; a < 3; ++a) e.hencky[a] = e.volume / 3.0 + ratio * (o.hencky[a] - e.before / 3.0);
  return e;
}

// The strains of an octet under new constants, and the square of its wave speeds.
struct Exchanged {
  Symmetric3<Double8> strain, network;
  Double8 speed_squared;
};

template <class T>
Exchanged exchange(const Octet<T>& o, const Material<Double8>& old, const Material<Double8>& m) {
  const ExchangedStrain e = exchange_strain(o, old, m);
  const Double8 trace = e.before, volume = e.volume;
  Double8 rebuilt[3];
  for (int a = 0; a < 3; ++a) rebuilt[a] = exp_minus_one(2.0 * e.hencky[a]);
  const Double8 swell = exp_minus_one((volume - trace) * (2.0 / 3.0));  // of b at equal shape
  const Double8 grown = swell + 1.0;
  const Symmetric3<Double8>& b = o.point.network;
  const Symmetric3<Double8> swollen = {b.xx * grown + swell, b.yy * grown + swell,
                                       b.zz * grown + swell, b.xy * grown,
                                       b.yz * grown,         b.zx * grown};
  const auto connected = (m.network_modulus > Double8{}) & (o.point.damage < Double8{} + 1.0);
  const Symmetric3<Double8> network = choose(connected, swollen, b);
  const NetworkStretch<Double8> stretch = network_stretch(network, volume + o.point.opening);
  const Double8 stiffness =
      point_stiffness(m, volume, stretch.excess, network_modulus(m, stretch.excess));
  return {from_principal(o.eigen.vector, rebuilt), network, stiffness / m.density};
}

template <class T>
Double8 wave_speed_squared(const Octet<T>& o, const Material<Double8>& m) {
  const Double8 trace = o.hencky[0] + o.hencky[1] + o.hencky[2];
  const NetworkStretch<Double8> stretch = network_stretch(o.point.network, o.log_jacobian);
  const Double8 modulus = network_modulus(m, stretch.excess) * (1.0 - o.point.damage);
  return point_stiffness(m, trace, stretch.excess, modulus) / m.density;
}

}  // namespace

template <class T>
int stiffest_point(const ParticleSet<T>& set, const MaterialTable<T>& materials) {
  MaterialTable<double> table;
  for (int c = 0; c < kMaterialColumns; ++c)
    std::copy(materials.column[c], materials.column[c] + kMaterialCapacity, table.column[c]);
  int place = -1;
  double largest = 0;
  for (int first = 0; first < set.places(); first += kLanes) {
    const Octet<T> o(set, first);
    const Double8 value = wave_speed_squared(o, look_up_material(table, o.material));
    for (int i = 0; i < kLanes && first + i < set.places(); ++i)
      if (set.id[first + i] >= 0 && value[i] > largest) {
        largest = value[i];
        place = first + i;
      }
  }
  return place;
}

template <class T>
int fastest_point(const ParticleSet<T>& set) {
  int place = -1;
  double largest = 0;
  for (int p = 0; p < set.places(); ++p) {
    double value = 0;
    for (int a = 0; a < 3; ++a) value += std::pow(double(set.field[kVelocity + a][p]), 2);
    if (set.id[p] >= 0 && value > largest) {
      largest = value;
      place = p;
    }
  }
  return place;
}

template <class T>
void read_stress(const ParticleSet<T>& set, const MaterialTable<double>& table, T* out) {
#pragma omp parallel for schedule(static)
  for (int first = 0; first < set.places(); first += kLanes) {
    const Octet<T> o(set, first);
    const Symmetric3<Double8> t = resting_kirchhoff(look_up_material(table, o.material), o.point);
    const Double8 ratio = exp_minus_one(o.log_jacobian) + 1.0;
    const Double8 value[kReadings] = {t.xx / ratio, t.yy / ratio, t.zz / ratio, t.xy / ratio,
                                      t.yz / ratio, t.zx / ratio, ratio};
    for (int i = 0; i < kLanes && first + i < set.places(); ++i) {
      const std::int32_t id = set.id[first + i];
      if (id < 0) continue;
      for (int c = 0; c < kReadings; ++c) out[std::size_t(id) * kReadings + c] = T(value[c][i]);
    }
  }
}

template <class T>
Energies sum_energies(const ParticleSet<T>& set, const MaterialTable<double>& table) {
  const int chunks = (set.places() + kChunk - 1) / kChunk;
  std::vector<Energies> part(chunks);
#pragma omp parallel for schedule(static)
  for (int c = 0; c < chunks; ++c) {
    Energies sum{};
    const int end = std::min(set.places(), (c + 1) * kChunk);
    for (int first = c * kChunk; first < end; first += kLanes) {
      const Octet<T> o(set, first);
      const Double8 energy = o.volume * stored_energy(o, look_up_material(table, o.material));
      for (int i = 0; i < kLanes && first + i < end; ++i) {
        if (set.id[first + i] < 0) continue;
        double speed_squared = 0;
        for (int a = 0; a < 3; ++a) {
          const double v = set.field[kVelocity + a][first + i];
          speed_squared += v * v;
        }
        const double density = table.column[kDensity][set.material[first + i]];
        sum.kinetic += 0.5 * density * o.volume[i] * speed_squared;
        sum.elastic += energy[i];
      }
    }
    part[c] = sum;
  }
  Energies total{};
  for (const Energies& e : part) {
    total.kinetic += e.kinetic;
    total.elastic += e.elastic;
  }
  return total;
}

template <class T>
double exchange_materials(ParticleSet<T>& set, const MaterialTable<double>& before,
                          const MaterialTable<double>& after) {
  double fastest = 0;
#pragma omp parallel for schedule(static) reduction(max : fastest)
  for (int first = 0; first < set.places(); first += kLanes) {
    const Octet<T> o(set, first);
    const Exchanged e =
        exchange(o, look_up_material(before, o.material), look_up_material(after, o.material));
    const Symmetric3<Double8>&s = e.strain, &w = e.network;
    const Double8 value[12] = {s.xx, s.yy, s.zz, s.xy, s.yz, s.zx,
                               w.xx, w.yy, w.zz, w.xy, w.yz, w.zx};
    for (int i = 0; i < kLanes && first + i < set.places(); ++i) {
      if (o.volume[i] > 0) fastest = std::max(fastest, e.speed_squared[i]);
      for (int f = 0; f < 6; ++f) {
        set.field[kStrain + f][first + i] = T(value[f][i]);
        set.field[kNetworkStrain + f][first + i] = T(value[6 + f][i]);
      }
    }
  }
  return std::sqrt(fastest);
}

template <class T>
double largest_exchanged_strain(const ParticleSet<T>& set, const MaterialTable<double>& before,
                                const MaterialTable<double>& after) {
  double largest = 0;
#pragma omp parallel for schedule(static) reduction(max : largest)
  for (int first = 0; first < set.places(); first += kLanes) {
    const Octet<T> o(set, first);
    const ExchangedStrain e = exchange_strain(o, look_up_material(before, o.material),
                                              look_up_material(after, o.material));
    const Double8 *h = e.hencky, mean = (h[0] + h[1] + h[2]) / 3.0;
    const Double8 most = maximum(h[0], maximum(h[1], h[2]));
    const Double8 least = minimum(h[0], minimum(h[1], h[2]));
    const Double8 spread = maximum(most - least, absolute(mean)) * 0.5;
    for (int i = 0; i < kLanes && first + i < set.places(); ++i)
      if (set.id[first + i] >= 0) largest = std::max(largest, spread[i]);
  }
  return largest;
}

template void read_stress(const ParticleSet<float>&, const MaterialTable<double>&, float*);
template void read_stress(const ParticleSet<double>&, const MaterialTable<double>&, double*);
template Energies sum_energies(const ParticleSet<float>&, const MaterialTable<double>&);
template Energies sum_energies(const ParticleSet<double>&, const MaterialTable<double>&);
template int stiffest_point(const ParticleSet<float>&, const MaterialTable<float>&);
template int stiffest_point(const ParticleSet<double>&, const MaterialTable<double>&);
template int fastest_point(const ParticleSet<float>&);
template int fastest_point(const ParticleSet<double>&);
template double exchange_materials(ParticleSet<float>&, const MaterialTable<double>&,
                                   const MaterialTable<double>&);
template double exchange_materials(ParticleSet<double>&, const MaterialTable<double>&,
                                   const MaterialTable<double>&);
template double largest_exchanged_strain(const ParticleSet<float>&, const MaterialTable<double>&,
                                         const MaterialTable<double>&);
template double largest_exchanged_strain(const ParticleSet<double>&, const MaterialTable<double>&,
                                         const MaterialTable<double>&);

}  // namespace vulnus::injury
