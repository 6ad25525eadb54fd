// One row a material: what the laws of elasticity, plasticity and damage need to know.
#pragma once

#include "core/lanes.hpp"

namespace vulnus::injury {

// The order is that of the columns that Python passes (`materials.COLUMNS`).
enum MaterialColumn {
  kDensity,            // kg/m^3
  kBulkModulus,        // Pa
  kShearModulus,       // Pa, of the elasto-plastic part
  kVolumeExponent,     // n of the volumetric law, 0: linear in the volumetric Hencky strain
  kVolumeGrowth,       // a of the volumetric law (equation_of_state.hpp)
  kVolumeAveraging,    // 1: the volume rate is averaged over a cell (volume_averaging.hpp)
  kYieldStress,        // Pa, von Mises, at rest
  kHardening,          // Pa, growth of the yield stress with plastic strain
  kFriction,           // growth of the yield stress with pressure, 0: von Mises
  kRateReference,      // 1/s, 0: no rate law
  kRateExponent,       //
  kDamageStart,        // plastic strain where damage begins
  kDamageSlope,        // damage per plastic strain beyond that
  kPressureCutoff,     // Pa, largest tension of the pressure (cavitation, spall)
  kTensileStrength,    // Pa, largest principal stress (Rankine)
  kOpeningDamage,      // part of the opening strain that counts as plastic strain
  kNetworkModulus,     // Pa, shear modulus at rest of the network
  kNetworkStiffening,  // beta of the network's exponential
  kBreakStart,         // equivalent network strain where the network begins to break
  kBreakSlope,         // 1 / (equivalent strain from there to the end)
  kMaterialColumns
};

constexpr int kMaterialCapacity = 16;
constexpr double kUnlimited = 1e29;  // strengths above this are never reached

template <class T>
struct MaterialTable {
  alignas(64) T column[kMaterialColumns][kMaterialCapacity];
};

template <class R>
struct Material {
  R density, bulk_modulus, shear_modulus, volume_exponent, volume_growth;
  R yield_stress, hardening, friction, rate_reference, rate_exponent;
  R damage_start, damage_slope, pressure_cutoff, tensile_strength, opening_damage;
  R network_modulus, network_stiffening, break_start, break_slope;
};

template <class T>
VULNUS_HD Material<typename LaneTraits<T>::Real> look_up_material(
    const MaterialTable<T>& table, typename LaneTraits<T>::Integer index) {
  auto get = [&](int column) { return look_up(table.column[column], index); };
  return {get(kDensity),           get(kBulkModulus),     get(kShearModulus),  get(kVolumeExponent),
          get(kVolumeGrowth),      get(kYieldStress),     get(kHardening),     get(kFriction),
          get(kRateReference),     get(kRateExponent),    get(kDamageStart),   get(kDamageSlope),
          get(kPressureCutoff),    get(kTensileStrength), get(kOpeningDamage), get(kNetworkModulus),
          get(kNetworkStiffening), get(kBreakStart),      get(kBreakSlope)};
}

}  // namespace vulnus::injury
