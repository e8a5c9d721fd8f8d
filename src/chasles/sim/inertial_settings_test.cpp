#include <limits>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/base/settings_testing.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {
namespace {

template <typename Value>
void set(InertialSettings& settings, const std::string& name, Value value) {
  bool found = false;
  for_each_setting(settings,
                   [&](const char* field, auto& slot, const char*, const char*, const Limits&) {
                     if constexpr (std::is_same_v<std::remove_reference_t<decltype(slot)>, Value>) {
                       if (name == field) {
                         slot = value;
                         found = true;
                       }
                     }
                   });
  ASSERT_TRUE(found) << name;
}

void expect_rejected(const InertialSettings& settings, const std::string& field,
                     const std::string& found) {
  std::string message;
  try {
    validate(settings);
  } catch (const UsageError& error) {
    message = error.what();
  }
  for (const std::string& part : {field, found, std::string("expected")}) {
    EXPECT_NE(message.find(part), std::string::npos) << field << ": '" << message << "'";
  }
}

TEST(InertialSettings, EverySceneIsValidAndBearsItsOwnName) {
  for (const InertialScene& scene : inertial_scenes()) {
    EXPECT_NO_THROW(validate(scene.settings)) << scene.name;
    EXPECT_EQ(scene.settings.name, scene.name);
    EXPECT_EQ(name_of(scene.settings.geometry), scene.name);
    EXPECT_EQ(inertial_scene(scene.name).name, scene.name);
    EXPECT_FALSE(scene.doc.empty());
  }
  EXPECT_EQ(inertial_scenes().size(), 4U);
  EXPECT_THROW(inertial_scene("street"), UsageError);
}

TEST(InertialSettings, EveryFieldHasAMeaningAndANumberItsRange) {
  const InertialSettings settings;
  int fields = 0;
  for_each_setting(settings, [&](const std::string& name, const auto&, const char*,
                                 const std::string& doc, const Limits&) {
    EXPECT_FALSE(doc.empty()) << name;
    ++fields;
  });
  EXPECT_GE(fields, 60);
  test::expect_each_field_is_described<InertialSettings>();
  test::expect_each_field_is_assessed<InertialSettings>("simulation setting ");
}

TEST(InertialSettings, NoNumberMayBeNaNInfiniteOrFarOutside) {
  InertialSettings probe;
  for_each_setting(
      probe, [](const std::string& name, auto& slot, const char*, const char*, const Limits&) {
        using Value = std::remove_reference_t<decltype(slot)>;
        if constexpr (std::is_same_v<Value, double>) {
          using Number = std::numeric_limits<double>;
          for (const double bad : {Number::quiet_NaN(), Number::infinity(), -1e30, 1e30}) {
            InertialSettings settings;
            set(settings, name, bad);
            expect_rejected(settings, name, "");
          }
        } else if constexpr (std::is_same_v<Value, int>) {
          InertialSettings settings;
          set(settings, name, -1);
          expect_rejected(settings, name, "-1");
        }
      });
}

TEST(InertialSettings, ZeroLengthsRatesAndSpeedsAreRejected) {
  for (const char* name : {"knot_interval",
                           "hall_length",
                           "hall_width",
                           "corridor_width",
                           "corridor_height",
                           "walking_speed",
                           "turn_duration",
                           "step_rate",
                           "circle_radius",
                           "revolutions",
                           "revolution_duration",
                           "cube_edge",
                           "landmark_spacing",
                           "landmark_nearest",
                           "baseline",
                           "frame_rate",
                           "focal_length",
                           "min_range",
                           "max_range",
                           "imu_rate"}) {
    InertialSettings settings;
    set(settings, name, 0.0);
    expect_rejected(settings, name, "found 0");
  }
}

TEST(InertialSettings, WhatDoesNotFitTogetherIsRejected) {
  expect_rejected({.geometry = Geometry{7}}, "geometry", "hallway, turntable, trajectory, walk");
  expect_rejected({.imu_convention = ImuConvention{7}}, "imu_convention", "interval-mean");
  expect_rejected({.hall_width = 3}, "hall_width", "3 m");
  expect_rejected({.corridor_height = 1.1}, "corridor_height", "1.2 m");
  expect_rejected({.circle_radius = 0.5}, "circle_radius", "radial_sway");
  expect_rejected({.landmark_nearest = 11}, "landmark_farthest", "11 m");
  expect_rejected({.min_range = 16}, "max_range", "15 m");
  expect_rejected({.image_border = 270}, "image_border", "270 px");
  expect_rejected({.outlier_fraction = 1.01}, "outlier_fraction", "1.01");
}

TEST(InertialSettings, TheLensHasTheCoefficientsOfItsModel) {
  InertialSettings settings;
  settings.distortion = Distortion::kDoubleSphere;
  settings.distortion_1 = -0.2;
  EXPECT_EQ(lens_coefficients(settings), (LensCoefficients{-0.2, 0}));
  EXPECT_NO_THROW(validate(settings));
  settings.distortion_2 = 1.2;
  EXPECT_THROW(validate(settings), UsageError);
  settings.distortion_2 = 0.6;
  settings.distortion_3 = 0.1;
  EXPECT_THROW(validate(settings), UsageError);
  settings.distortion = Distortion::kOmni;
  EXPECT_EQ(lens_coefficients(settings), (LensCoefficients{-0.2, 0.6, 0.1, 0, 0}));
  settings.distortion = Distortion::kNone;
  EXPECT_EQ(lens_coefficients(settings), LensCoefficients());
}

TEST(InertialSettings, BothKindsOfSettingsCanBeVisitedSideBySide) {
  const auto names = [](const auto& settings) {
    std::string all;
    for_each_setting(settings, [&](const std::string& name, const auto&, const char*, const char*,
                                   const Limits&) { all += name + " "; });
    return all;
  };
  EXPECT_NE(names(StreetSettings{}).find("route"), std::string::npos);
  EXPECT_NE(names(InertialSettings{}).find("imu_rate"), std::string::npos);
}

}  // namespace
}  // namespace chasles
