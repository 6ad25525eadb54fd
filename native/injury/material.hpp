// One row a material: what the laws of elasticity, plasticity and damage need to know.
#pragma once

#include "core/lanes.hpp"

namespace vulnus::injury {

// The order is that of the columns that Python passes (`materials.COLUMNS`).
enum MaterialColumn {
  kDensity,          // kg/m^3
  kBulkModulus,      // Pa
  kShearModulus,     // Pa
  kTaitExponent,     // 0: linear in the volumetric Hencky strain
  kYieldStress,      // Pa, von Mises, at rest
  kFriction,         // growth of the yield stress with pressure, 0: von Mises
  kRateReference,    // 1/s, 0: no rate law
  kRateExponent,     //
  kDamageStart,      // plastic strain where damage begins
  kDamageEnd,        // plastic strain where damage is 1
  kPressureCutoff,   // Pa, largest tension of the pressure (cavitation, spall)
  kTensileStrength,  // Pa, largest principal stress (Rankine)
  kOpeningDamage,    // part of the opening strain that counts as plastic strain
  kMaterialColumns
};

constexpr int kMaterialCapacity = 16;

template <class T>
struct MaterialTable {
  alignas(64) T column[kMaterialColumns][kMaterialCapacity];
};

template <class R>
struct Material {
  R density, bulk_modulus, shear_modulus, tait_exponent;
  R yield_stress, friction, rate_reference, rate_exponent;
  R damage_start, damage_end, pressure_cutoff, tensile_strength, opening_damage;
};

template <class T>
VULNUS_HD Material<typename LaneTraits<T>::Real> look_up_material(
    const MaterialTable<T>& table, typename LaneTraits<T>::Integer index) {
  auto get = [&](int column) { return look_up(table.column[column], index); };
  return {get(kDensity),      get(kBulkModulus), get(kShearModulus),   get(kTaitExponent),
          get(kYieldStress),  get(kFriction),    get(kRateReference),  get(kRateExponent),
          get(kDamageStart),  get(kDamageEnd),   get(kPressureCutoff), get(kTensileStrength),
          get(kOpeningDamage)};
}

}  // namespace vulnus::injury
