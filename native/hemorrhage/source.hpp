// Where blood enters: a spherical shell around the severed artery (Chong 2017, 2.3), and what it
// feels there. Volumes are kept in double so that the ledger closes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hemorrhage/grid_field.hpp"
#include "hemorrhage/particles.hpp"

namespace vulnus::hemorrhage {

// Flow rate over time, linear between samples and constant beyond them [s, m^3/s].
struct FlowSeries {
  const double* time = nullptr;
  const double* value = nullptr;
  std::size_t count = 0;
  double at(double t) const;
};

struct SourceSettings {
  bool enabled = false;
  std::array<double, 3> center{};  // local frame
  double radius = 1.5e-3;
  double sensor_volume = 0.0;  // of the shell R..R+h that blood can fill; 0 = all of it
  double wall_rate = 3e4;      // drag rate from which tissue is a wall: K = 1e-11 m^2 [1/s]
  std::uint64_t seed = 1;
};

template <class Real>
class ShellSource {
 public:
  SourceSettings settings;
  double particle_volume = 0, spacing = 0, smoothing = 0;
  Real newcomer_weight = Real(0.05);  // of a whole particle; it swells within `swelling_time`

  // State.
  double injected = 0;     // integral of the flow rate [m^3]
  double pending = 0;      // injected but not yet a particle [m^3]
  std::int64_t draws = 0;  // how many rotations have been drawn
  std::int32_t next_id = 0;
  double pressure_time = 0;  // integral of the pressure since the last reset [Pa s]
  double sampled_time = 0;

  // Remembers who is near; called after each neighbour search.
  void list_near(const Particles<Real>& particles, double margin);

  // Adds Q dt and turns it into particles, or takes particles back; true if any came or went.
  // Those taken back are marked by weight < 0.
  bool flow(Particles<Real>& particles, double flow_rate, double dt,
            const DistanceField<Real>& barrier, const TissueField<Real>& tissue);

  // Mean pressure around the shell, R..R+h; 0 where it is not filled (a free surface).
  double pressure_around(const Particles<Real>& particles) const;
  void sample_pressure(const Particles<Real>& particles, double dt);

 private:
  struct Site {
    std::array<double, 3> direction{};
    double clearance = -1.0, porosity = 1.0;
  };
  std::vector<std::int32_t> near_;

  Site freest_site(const Particles<Real>& particles, const DistanceField<Real>& barrier,
                   const TissueField<Real>& tissue);
  double nearest(const Particles<Real>& particles, const std::array<double, 3>& point) const;
  bool emit(Particles<Real>& particles, double flow_rate, const DistanceField<Real>& barrier,
            const TissueField<Real>& tissue);
  bool take_back(Particles<Real>& particles);
  double distance_to_center(const Particles<Real>& particles, std::int32_t i) const;
};

extern template class ShellSource<float>;
extern template class ShellSource<double>;

}  // namespace vulnus::hemorrhage
