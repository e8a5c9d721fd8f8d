#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/depth_rule.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

namespace chasles {
namespace {

using test::Estimates;

Estimates estimates_with(const InertialSlamSettings& settings) {
  InertialScene scene = test::short_hallway();
  scene.settings.sections = 1;
  const Recording recording = simulate_inertial(scene, 0);
  InertialSession session = test::session_for(recording, std::nullopt, settings);
  return test::play(session, recording);
}

InertialSlamSettings undelayed(LandmarkForm form, const std::string& rule) {
  InertialSlamSettings settings;
  settings.init = LandmarkInit::kFixedDepth;
  settings.landmarks = form;
  settings.depth_rule = rule;
  return settings;
}

TEST(DepthRule, OneThatSaysWhatTheSettingsSayChangesNothing) {
  const InertialSlamSettings s;
  register_depth_rule("as-set", [s](const FirstObservation& o) {
    return AssumedDepth{.mean = o.inverse ? s.inverse_depth : s.fixed_depth,
                        .sigma = o.inverse ? s.inverse_depth_sigma : s.fixed_depth_sigma};
  });
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const Estimates a = estimates_with(undelayed(form, "constant"));
    const Estimates b = estimates_with(undelayed(form, "as-set"));
    ASSERT_EQ(a.size(), b.size());
    ASSERT_GT(a.size(), 50u);
    EXPECT_GT(a.back().landmarks, 10);
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].world_T_imu.p, b[i].world_T_imu.p);
      EXPECT_EQ(a[i].covariance, b[i].covariance);
    }
  }
}

TEST(DepthRule, KnowsTheObservationAndMayWait) {
  int calls = 0, with_landmarks = 0;
  register_depth_rule("far-alone", [&](const FirstObservation& o) -> std::optional<AssumedDepth> {
    ++calls;
    with_landmarks += !o.state.landmarks.empty();
    EXPECT_TRUE(unproject(o.camera, o.pixel).has_value());
    EXPECT_TRUE(o.inverse);
    if (calls % 2 == 0) return std::nullopt;
    return AssumedDepth{.mean = 0.2, .sigma = 0.3};
  });
  const Estimates e = estimates_with(undelayed(LandmarkForm::kInverseDepth, "far-alone"));
  EXPECT_GT(calls, 20);
  EXPECT_GT(with_landmarks, 0);
  EXPECT_GT(e.back().landmarks, 5);
  EXPECT_LE(e.back().landmarks, (calls + 1) / 2);
}

TEST(DepthRule, WrongOnesSayWhatIsWrong) {
  const auto message = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const UsageError& error) {
      return error.what();
    }
    return {};
  };
  const DepthRule any = [](const FirstObservation&) { return AssumedDepth{.mean = 1, .sigma = 1}; };
  EXPECT_NE(message([&] { register_depth_rule("constant", any); }).find("is one of the library"),
            std::string::npos);
  EXPECT_NE(message([&] { register_depth_rule("a/b", any); }).find("expected letters"),
            std::string::npos);
  EXPECT_NE(message([&] { register_depth_rule("none", {}); }).find("expected a function"),
            std::string::npos);
  EXPECT_NE(message([&] {
              estimates_with(undelayed(LandmarkForm::kCartesian, "conztant"));
            }).find("constant"),
            std::string::npos);
  for (const double sigma : {0., -1., std::numeric_limits<double>::quiet_NaN()}) {
    register_depth_rule("broken", [sigma](const FirstObservation&) {
      return AssumedDepth{.mean = 5, .sigma = sigma};
    });
    const std::string text =
        message([&] { estimates_with(undelayed(LandmarkForm::kCartesian, "broken")); });
    EXPECT_NE(text.find("depth rule 'broken': found 5 +- "), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace chasles
