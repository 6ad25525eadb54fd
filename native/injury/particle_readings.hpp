// What the material points say when asked: stress, volume and energy, in double precision; and the
// exchange of their material constants under unchanged stress. The particles must hold the whole
// state of strain (they always do between calls).
#pragma once

#include "injury/particle_set.hpp"
#include "injury/stress_update.hpp"

namespace vulnus::injury {

constexpr int kReadings = 7;  // Cauchy stress xx yy zz xy yz zx [Pa], volume ratio J

// Readings (count, 7) in the points' original order.
template <class T>
void read_stress(const ParticleSet<T>& set, const MaterialTable<double>& table, T* out);

struct Energies {
  double kinetic;  // [J]: of the particles' velocities, without APIC's affine part
  double elastic;  // [J]: stored by shear, volume and networks
};

// Sums in double and in a fixed order, whatever the number of threads.
template <class T>
Energies sum_energies(const ParticleSet<T>& set, const MaterialTable<double>& table);

// The places of the points with the fastest waves and with the largest velocity, or -1: they set
// the time step.
template <class T>
int stiffest_point(const ParticleSet<T>& set, const MaterialTable<T>& materials);
template <class T>
int fastest_point(const ParticleSet<T>& set);

// Rescales the elastic strains so that the Kirchhoff stress under `after` is that under `before`:
// the volumetric strain to equal pressure, the deviator by the ratio of shear moduli; the network's
// isochoric strain stays. Returns the largest wave speed [m/s] afterwards.
template <class T>
double exchange_materials(ParticleSet<T>& set, const MaterialTable<double>& before,
                          const MaterialTable<double>& after);

// Half of the largest difference of two principal Hencky strains that this would leave, or of the
// largest mean of the three.
template <class T>
double largest_exchanged_strain(const ParticleSet<T>& set, const MaterialTable<double>& before,
                                const MaterialTable<double>& after);

}  // namespace vulnus::injury
