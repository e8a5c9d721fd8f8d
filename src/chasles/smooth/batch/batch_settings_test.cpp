#include <chasles/base/settings_testing.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>

namespace chasles::test {
namespace {

TEST(BatchSettings, EachIsDescribedAndAssessed) {
  expect_each_field_is_described<BatchSettings>();
  expect_each_field_is_assessed<BatchSettings>("batch.");
}

TEST(BatchSettings, WhatIsAllowedIsReportedInWords) {
  EXPECT_EQ(complaint_about(BatchSettings{.chart = "polar"}),
            "batch.chart: found 'polar', expected one of filter, standard, left-se3, right-se3, "
            "right-sen3");
  EXPECT_EQ(complaint_about(BatchSettings{.frames_per_keyframe = 0}),
            "batch.frames_per_keyframe: found 0, expected a whole number above 0 [count]");
}

}  // namespace
}  // namespace chasles::test
