#pragma once

#include <chasles/base/time.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// What the reproduction of Kleinert & Stilla changes in the filter (docs/papers.md): the
/// composition step, numeric derivatives, and the noise of young landmarks. With the default
/// settings none of it does anything. The fixed depth is UndelayedInitialiser's.
class StudyHooks {
 public:
  /// `start`: of the state.
  StudyHooks(const InertialSlamSettings& settings, Time start);

  /// Makes the composition step if its interval has passed. Whether it did.
  bool compose_when_due(Ekf& filter, Time now);
  /// Factor on the pixel noise of a landmark. The first linearisations are the worst, so they get
  /// more noise (docs/derivations.md, D50).
  double noise_inflation(const Landmark& landmark) const;
  /// Replaces the derivatives of a pixel by numeric ones, where the settings ask for them.
  void differentiate(const Ekf& filter, const Camera& camera, Measurement& measurement) const;

 private:
  double composition_interval_;  ///< 0: never [s]
  double noise_inflation_;
  int noise_inflation_frames_;
  bool numeric_jacobians_;
  Time composed_;
};

/// The chart of their transition to first order (InertialModel::first_order); null: the exact one.
const ErrorChart* first_order_chart(const InertialSlamSettings& settings);

}  // namespace chasles
