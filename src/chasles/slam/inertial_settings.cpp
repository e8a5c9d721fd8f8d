#include <chasles/base/validate.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

void validate(const InertialSlamSettings& s) {
  validate_fields(s);
  if (s.composition_interval > 0 && !s.nav_attitude) {
    reject_value("composition_interval", setting_text(s.composition_interval),
                 "0 without nav_attitude, the world's attitude in the state");
  }
  if (s.first_order_transition && s.chart != kStandardChart.name && s.chart != kLeftSe3Chart.name &&
      s.chart != kRightSe3Chart.name) {
    reject_value("first_order_transition", setting_text(s.first_order_transition),
                 "false with the chart " + s.chart + ", which is not the paper's");
  }
  if (s.first_order_transition && s.uses_first_estimates()) {
    reject_value("first_order_transition", setting_text(s.first_order_transition),
                 "false with first_estimates, which have a transition of their own");
  }
  const bool cartesian =
      s.landmarks == LandmarkForm::kCartesian && s.init == LandmarkInit::kFixedDepth;
  if (s.numeric_jacobians &&
      (!cartesian || s.uses_first_estimates() || s.has_extrinsics() || s.has_intrinsics())) {
    reject_value("numeric_jacobians", setting_text(s.numeric_jacobians),
                 "false, or landmarks: cartesian, init: fixed-depth, first_estimates: false, "
                 "calibrate_extrinsics: false");
  }
  const bool any_imu = s.initial_imu_scale_sigma > 0 || s.initial_imu_misalignment_sigma > 0 ||
                       s.initial_g_sensitivity_sigma > 0;
  if (s.has_imu() && !any_imu) {
    reject_value("calibrate_imu", setting_text(s.calibrate_imu),
                 "false where initial_imu_scale_sigma, initial_imu_misalignment_sigma and "
                 "initial_g_sensitivity_sigma are all 0: set one above 0");
  }
  if (s.keep_scale == Toggle::kTrue && s.chart == kLeftSe3Chart.name) {
    reject_value("keep_scale", setting_text(s.keep_scale),
                 "auto or false with the chart left-se3, whose pose errors turn with the pose");
  }
}

}  // namespace chasles
