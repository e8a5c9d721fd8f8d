#include <limits>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/base/settings_testing.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {
namespace {

template <typename Value>
void set(StreetSettings& settings, const std::string& name, Value value) {
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

std::string complaint(const StreetSettings& settings) {
  try {
    simulate_street(settings);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

void expect_street_rejected(const StreetSettings& settings, const std::string& field,
                            const std::string& found) {
  const std::string message = complaint(settings);
  EXPECT_NE(message.find(field), std::string::npos) << field << ": '" << message << "'";
  EXPECT_NE(message.find(found), std::string::npos) << field << ": '" << message << "'";
  EXPECT_NE(message.find("expected"), std::string::npos) << field << ": '" << message << "'";
}

TEST(StreetSettings, EverySceneIsValidAndBearsItsOwnName) {
  for (const StreetScene& scene : street_scenes()) {
    EXPECT_NO_THROW(validate(scene.settings)) << scene.name;
    EXPECT_EQ(scene.settings.name, scene.name);
    EXPECT_EQ(street_scene(scene.name).name, scene.name);
  }
  EXPECT_THROW(street_scene("hallway"), UsageError);
}

TEST(StreetSettings, EveryFieldHasAMeaningAndANumberHasItsRange) {
  int fields = 0;
  const StreetSettings settings;
  for_each_setting(settings, [&](const std::string& name, const auto&, const char*,
                                 const std::string& doc, const Limits&) {
    EXPECT_FALSE(doc.empty()) << name;
    ++fields;
  });
  EXPECT_GE(fields, 50);
  test::expect_each_field_is_described<StreetSettings>();
  test::expect_each_field_is_assessed<StreetSettings>("simulation setting ");
}

TEST(StreetSettings, NoNumberMayBeNaNInfiniteOrFarOutside) {
  StreetSettings probe;
  for_each_setting(
      probe, [](const std::string& name, auto& slot, const char*, const char*, const Limits&) {
        using Value = std::remove_reference_t<decltype(slot)>;
        if constexpr (std::is_same_v<Value, double>) {
          using Number = std::numeric_limits<double>;
          for (const double bad : {Number::quiet_NaN(), Number::infinity(), -1e30, 1e30}) {
            StreetSettings settings;
            set(settings, name, bad);
            expect_street_rejected(settings, name, "");
          }
        } else if constexpr (std::is_same_v<Value, int>) {
          StreetSettings settings;
          set(settings, name, -1);
          expect_street_rejected(settings, name, "-1");
        }
      });
}

TEST(StreetSettings, ZeroLengthsRatesAndSpeedsAreRejected) {
  for (const char* name :
       {"block_length", "block_width", "corner_length", "cruise_speed", "corner_speed",
        "acceleration", "road_wavelength", "sway_wavelength", "street_width", "imu_height",
        "focal_length", "baseline", "frame_rate", "track_life", "min_depth", "max_depth"}) {
    StreetSettings settings;
    set(settings, name, 0.0);
    expect_street_rejected(settings, name, "found 0");
  }
}

TEST(StreetSettings, AFractionIsAtMostOne) {
  for (const char* name : {"outlier_fraction", "moving_fraction", "dropped_fraction"}) {
    StreetSettings settings;
    set(settings, name, 1.01);
    expect_street_rejected(settings, name, "1.01");
  }
}

TEST(StreetSettings, AnUnknownLetterOfTheRouteIsNamed) {
  expect_street_rejected({.route = "LLX"}, "route", "letter 3 is 'X'");
}

TEST(StreetSettings, WhatCannotBeDrivenIsRejected) {
  expect_street_rejected({.block_width = 50}, "cruise_speed", "too short");
  expect_street_rejected({.block_width = 20}, "corner_length", "20 m");
  expect_street_rejected({.street_width = 6}, "street_width", "6 m");
  expect_street_rejected({.corner_speed = 9}, "corner_speed", "9 m/s");
  expect_street_rejected({.min_depth = 70}, "max_depth", "60 m");
  expect_street_rejected({.image_border = 188}, "image_border", "188 px");
  expect_street_rejected({.frame_rate = 1000, .velocities_per_frame = 1000}, "frame_rate",
                         "samples");
}

}  // namespace
}  // namespace chasles
