#include <cmath>

#include <gtest/gtest.h>

#include <chasles/report/page_data.hpp>
#include <chasles/report/page_images.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using nlohmann::json;
using test::column;

ReportRun with_images() {
  ReportRun run = test::synthetic_drive({.states = 100, .landmarks = 10});
  test::add_synthetic_images(run.run, 10);
  return run;
}

TEST(PageImages, HoldWhatWasKept) {
  const auto run = with_images().run;
  const json cameras = images_json(run, kPagePictures);
  ASSERT_EQ(cameras.size(), 2u);
  const json& camera = cameras[0];
  EXPECT_EQ(camera["width"], 192);
  EXPECT_EQ(camera["height"], 120);
  ASSERT_EQ(camera["jpeg"].size(), 10u);
  EXPECT_TRUE(camera["jpeg"][3].get<std::string>().starts_with("/9j/")) << "a JPEG's first bytes";
  EXPECT_EQ(cameras[1]["jpeg"][3], "");
  const auto t = column(camera["t"]), count = column(camera["count"]);
  ASSERT_EQ(t.size(), 10u);
  EXPECT_NEAR(t[2], to_seconds(run.images[4].time - run.states[0].time), 1e-6);
  EXPECT_EQ(count[2], 12);
  // The third frame's point 2, which updated the state.
  const std::size_t at = 2 * 12 + 2;
  const ImageFeature& f = run.images[4].features[2];
  const auto is = [&](const char* name, double value, double within) {
    EXPECT_NEAR(column(camera[name])[at], value, within) << name;
  };
  is("id", 2, 0);
  is("age", 3, 0);
  is("outcome", static_cast<int>(Outcome::kUsed), 0);
  is("u", 10 * f.seen.observation.pixel.x(), 0.5);
  is("v", 10 * f.seen.observation.pixel.y(), 0.5);
  is("before_u", -600, 0.5);
  is("before_v", -150, 0.5);
  is("expected_u", 50, 0.5);
  is("expected_v", -50, 0.5);
  is("sigma_u", 100 * std::sqrt(1.5), 0.5);
  is("sigma_v", 100 * std::sqrt(0.75), 0.5);
  is("correlation", 100 * 0.4 / std::sqrt(1.5 * 0.75), 0.5);
  // And the first frame's point 0, which is waiting and has no earlier observation.
  for (const char* name : {"before_u", "expected_u", "sigma_u", "sigma_v", "correlation"}) {
    EXPECT_EQ(column(camera[name])[0], 0) << name;
  }
}

TEST(PageImages, TakeNoMoreThanTheirBudget) {
  const auto run = with_images().run;
  std::size_t all = 0;
  for (const ShownImage& image : run.images) all += image.jpeg.size();
  const auto frames = [&](std::size_t most) {
    const json cameras = images_json(run, most);
    EXPECT_EQ(cameras[0]["jpeg"].size(), cameras[1]["jpeg"].size()) << "whole frames";
    return cameras[0]["jpeg"].size();
  };
  EXPECT_EQ(frames(all + 1), 10u);
  EXPECT_EQ(frames(all / 2 + 1), 5u);
  EXPECT_EQ(frames(all / 5 + 1), 2u);
  EXPECT_EQ(frames(1), 1u);
}

TEST(PageImages, ARunWithoutThemOrWithoutStatesHasNone) {
  ReportRun run = with_images();
  const json data = json(page_data({run}));
  EXPECT_EQ(data["runs"][0]["images"].size(), 2u);
  run.run.images.clear();
  EXPECT_EQ(json(page_data({run}))["runs"][0]["images"].size(), 0u);
  run = with_images();
  run.run.states.clear();
  EXPECT_EQ(images_json(run.run, kPagePictures).size(), 0u);
}

TEST(PageImages, WhatIsNotFiniteIsLeftOut) {
  auto run = with_images().run;
  ImageFeature& f = run.images[0].features[2];
  f.seen.expected->covariance(0, 0) = std::nan("");
  f.seen.expected->pixel.x() = std::nan("");
  const json camera = images_json(run, kPagePictures)[0];
  EXPECT_EQ(column(camera["sigma_u"])[2], 0);
  EXPECT_EQ(column(camera["expected_u"])[2], 0);
}

}  // namespace
}  // namespace chasles
