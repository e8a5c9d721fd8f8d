#include <chasles/base/settings_testing.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles::test {
namespace {

TEST(FrontendSettings, EachIsDescribedAndAssessed) {
  expect_each_field_is_described<FrontendSettings>();
  expect_each_field_is_assessed<FrontendSettings>("frontend.");
}

TEST(FrontendSettings, AWindowHasAMiddleAndPredictedLevelsAreAmongTheLevels) {
  EXPECT_EQ(complaint_about(FrontendSettings{.window = 14}),
            "frontend.window: found 14, expected an odd number: a patch has a middle");
  EXPECT_EQ(complaint_about(FrontendSettings{.levels = 2, .predicted_levels = 3}),
            "frontend.predicted_levels: found 3, expected not more than levels, 2");
}

TEST(FrontendSettings, WhatIsAllowedIsReportedInWords) {
  EXPECT_EQ(complaint_about(FrontendSettings{.max_tracks = 0}),
            "frontend.max_tracks: found 0, expected a whole number not below 1 and not above 10000 "
            "[count]");
  EXPECT_EQ(complaint_about(FrontendSettings{.min_correlation = 1.5}),
            "frontend.min_correlation: found 1.5, expected a finite number not below -1 and not "
            "above 1");
  EXPECT_EQ(complaint_about(FrontendSettings{.corners = CornerMeasure{2}}),
            "frontend.corners: found the value 2, expected one of harris, shi-tomasi");
}

}  // namespace
}  // namespace chasles::test
