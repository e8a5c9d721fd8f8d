#include <algorithm>

#include <chasles/filter/numeric_derivatives.hpp>
#include <chasles/slam/study_hooks.hpp>

namespace chasles {

StudyHooks::StudyHooks(const InertialSlamSettings& settings, Time start)
    : composition_interval_(settings.composition_interval),
      noise_inflation_(settings.noise_inflation),
      noise_inflation_frames_(settings.noise_inflation_frames),
      numeric_jacobians_(settings.numeric_jacobians),
      composed_(start) {}

bool StudyHooks::compose_when_due(Ekf& filter, Time now) {
  if (composition_interval_ <= 0) return false;
  if (to_seconds(now - composed_) < composition_interval_) return false;
  filter.compose();
  composed_ = now;
  return true;
}

double StudyHooks::noise_inflation(const Landmark& landmark) const {
  if (noise_inflation_ <= 0 || noise_inflation_frames_ <= 0) return 1;
  const double age = static_cast<double>(landmark.observations) / noise_inflation_frames_;
  return 1 + noise_inflation_ * std::max(0.0, 1 - age);
}

void StudyHooks::differentiate(const Ekf& filter, const Camera& camera,
                               Measurement& measurement) const {
  if (!numeric_jacobians_) return;
  differentiate_numerically(filter.chart(), camera, filter.state(), measurement);
}

const ErrorChart* first_order_chart(const InertialSlamSettings& settings) {
  return settings.first_order_transition ? &error_chart(settings.chart) : nullptr;
}

}  // namespace chasles
