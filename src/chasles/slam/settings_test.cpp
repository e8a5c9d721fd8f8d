#include <chasles/base/settings_testing.hpp>
#include <chasles/initialise/initialiser_settings.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/velocity/velocity_settings.hpp>

namespace chasles::test {
namespace {

template <typename Settings, typename Change>
Settings with(const Change& change) {
  Settings settings;
  change(settings);
  return settings;
}

TEST(Settings, EachIsDescribedAndAssessed) {
  expect_each_field_is_described<VelocitySlamSettings>();
  expect_each_field_is_assessed<VelocitySlamSettings>();
  expect_each_field_is_described<InertialSlamSettings>();
  expect_each_field_is_assessed<InertialSlamSettings>();
  expect_each_field_is_described<InitialiserSettings>();
  expect_each_field_is_assessed<InitialiserSettings>("start.");
}

TEST(Settings, WhatIsAllowedIsReportedInWords) {
  EXPECT_EQ(complaint_about(with<VelocitySlamSettings>([](auto& s) { s.gate = 2; })),
            "gate: found 2, expected a finite number above 0 and not above 1 [probability]");
  EXPECT_EQ(complaint_about(with<VelocitySlamSettings>([](auto& s) { s.rate_sigma = -0.5; })),
            "rate_sigma: found -0.5, expected a finite number not below 0 [rad/s], or auto");
  EXPECT_EQ(complaint_about(with<VelocitySlamSettings>([](auto& s) { s.chart = "left"; })),
            "chart: found 'left', expected one of standard, left-se3, right-se3, right-sen3");
  EXPECT_EQ(complaint_about(with<InertialSlamSettings>([](auto& s) { s.init = LandmarkInit{2}; })),
            "init: found the value 2, expected one of multi-view, fixed-depth");
}

TEST(Settings, WhatDoesNotGoTogetherIsRejected) {
  const auto rejected = [](const auto& settings, const std::string& words) {
    const std::string text = complaint_about(settings);
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  rejected(with<VelocitySlamSettings>([](auto& s) {
             s.mode = SlamMode::kMap;
             s.velocity_axes = VelocityAxes::kLevel;
           }),
           "velocity_axes=level");
  rejected(with<InertialSlamSettings>([](auto& s) { s.composition_interval = 0.5; }),
           "composition_interval: found 0.5, expected 0 without nav_attitude");
  rejected(with<InertialSlamSettings>([](auto& s) {
             s.chart = "left-se3";
             s.keep_scale = Toggle::kTrue;
           }),
           "keep_scale: found 'true', expected auto or false");
  rejected(with<InertialSlamSettings>([](auto& s) { s.first_order_transition = true; }),
           "first_order_transition: found true, expected false with the chart right-sen3");
  rejected(with<InertialSlamSettings>([](auto& s) {
             s.chart = "standard";
             s.first_order_transition = true;
             s.first_estimates = Toggle::kTrue;
           }),
           "first_order_transition: found true, expected false with first_estimates");
  rejected(with<InertialSlamSettings>([](auto& s) {
             s.calibrate_imu = Calibrate::kConsidered;
             s.initial_imu_scale_sigma = s.initial_imu_misalignment_sigma = 0;
             s.initial_g_sensitivity_sigma = 0;
           }),
           "calibrate_imu: found 'considered', expected false where initial_imu_scale_sigma");
  rejected(with<InertialSlamSettings>([](auto& s) { s.numeric_jacobians = true; }),
           "numeric_jacobians: found true, expected false, or landmarks: cartesian");
  validate(with<InertialSlamSettings>([](auto& s) {
    s.chart = "left-se3";
    s.landmarks = LandmarkForm::kCartesian;
    s.init = LandmarkInit::kFixedDepth;
    s.first_order_transition = s.numeric_jacobians = true;
  }));
  rejected(with<InitialiserSettings>([](auto& s) { s.heading_sigma = 0.1; }),
           "start.heading_sigma: found 0.1, expected 0 without start.heading");
  rejected(with<InitialiserSettings>([](auto& s) { s.min_window = 6; }),
           "start.max_window: found 5, expected at least");
}

}  // namespace
}  // namespace chasles::test
