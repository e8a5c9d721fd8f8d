#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/initialise/initialiser.hpp>
#include <chasles/initialise/initialiser_testing.hpp>
#include <chasles/initialise/static_conditions.hpp>
#include <chasles/initialise/static_start.hpp>

// The parts of the initialisation without a simulator; the whole is in initialiser_motion_test.cpp.

namespace chasles {
namespace {

using namespace test;

constexpr double kRate = 200;

std::vector<ImuSample> static_samples(Normal& normal, double seconds,
                                      const Eigen::Matrix3d& nav_R_imu, const Eigen::Vector3d& ba,
                                      const Eigen::Vector3d& bg) {
  std::vector<ImuSample> samples;
  const double root = std::sqrt(kRate);
  for (int i = 0; i < seconds * kRate; ++i) {
    samples.push_back(
        {.time = from_seconds(i / kRate),
         .specific_force_imu = nav_R_imu.transpose() * Eigen::Vector3d(0, 0, kStandardGravity) +
                               ba + normal.vector(kNoise.accelerometer_noise_density * root),
         .angular_rate_imu = bg + normal.vector(kNoise.gyroscope_noise_density * root)});
  }
  return samples;
}

TEST(StandstillStart, IsWrongByWhatItSays) {
  InitialiserSettings s;
  s.accelerometer_bias_sigma = 0.05;
  s.gyroscope_bias_sigma = 0.01;
  Normal normal(1);
  constexpr int kRuns = 200;
  double nees = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Eigen::Matrix3d R = so3::exp(normal.vector(0.8));
    const Eigen::Vector3d ba = normal.vector(s.accelerometer_bias_sigma);
    const Eigen::Vector3d bg = normal.vector(s.gyroscope_bias_sigma);
    const auto samples = static_samples(normal, 0.75, R, ba, bg);
    const InertialStart start = static_start({}, standstill_means(samples, kNoise), kNoise, s);
    // Exp(theta) maps the estimated up to the true one, z = up + theta x up; the heading is
    // arbitrary.
    const Eigen::Vector3d up = start.nav_T_imu.R * R.transpose() * Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 8, 1> error;
    error << up.y(), -up.x(), ba - start.accelerometer_bias, bg - start.gyroscope_bias;
    Eigen::Matrix<double, 15, 8> pick = Eigen::Matrix<double, 15, 8>::Zero();
    pick(0, 0) = pick(1, 1) = 1;
    pick.bottomRightCorner<6, 6>().setIdentity();
    const Eigen::Matrix<double, 8, 8> P = pick.transpose() * *start.covariance * pick;
    nees += error.dot(P.ldlt().solve(error)) / kRuns;
  }
  EXPECT_TRUE(chi2_band(8, kRuns, 0.999).contains(nees)) << nees;
}

TEST(StandstillStart, TiltAndHorizontalBiasCannotBeSeparated) {
  Normal normal(2);
  InitialiserSettings s;
  const auto samples =
      static_samples(normal, 1, Eigen::Matrix3d::Identity(), {0, 0, 0.03}, {0, 0, 0});
  const InertialStart start = static_start({}, standstill_means(samples, kNoise), kNoise, s);
  const Matrix15d& P = *start.covariance;
  EXPECT_NEAR(std::sqrt(P(0, 0)), s.accelerometer_bias_sigma / s.gravity, 1e-4);
  EXPECT_GT(std::abs(P(0, 10)) / std::sqrt(P(0, 0) * P(10, 10)), 0.99);
  EXPECT_NEAR(start.accelerometer_bias.z(), 0.03, 0.03);  // along gravity it is determined
  EXPECT_LT(std::sqrt(P(11, 11)), 0.011);
  EXPECT_EQ(P(2, 2), 0);  // heading, position
  EXPECT_EQ(P(4, 4), 0);
}

TEST(StandstillConditions, MotionInSamplesOrPixelsIsSaidWithItsMeasure) {
  Normal normal(3);
  InitialiserSettings s;
  auto samples = static_samples(normal, 1, so3::exp({0.3, 0.2, 0}), {0, 0, 0}, {0, 0, 0});
  std::vector<FeatureFrame> frames(20);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (int id = 0; id < 30; ++id) {
      frames[k].pixels.push_back(
          {.landmark = id, .camera = 0, .pixel = {20.0 * id + normal(), 100 + normal()}});
    }
  }
  StandstillScratch scratch;
  EXPECT_TRUE(all_met(static_conditions(samples, frames, 1, kNoise, 1, s, scratch)));
  auto turns = frames;  // each camera sees half of the frames
  for (std::size_t k = 1; k < turns.size(); k += 2) {
    for (auto& o : turns[k].pixels) o.camera = 1;
  }
  EXPECT_TRUE(all_met(static_conditions(samples, turns, 2, kNoise, 1, s, scratch)));
  auto drifting = frames;
  for (std::size_t k = 0; k < drifting.size(); ++k) {
    for (auto& o : drifting[k].pixels) o.pixel.x() += 0.25 * static_cast<double>(k);
  }
  auto found = static_conditions(samples, drifting, 1, kNoise, 1, s, scratch);
  EXPECT_FALSE(found.back().met);
  EXPECT_EQ(found.back().name, "displacement of the tracks");
  EXPECT_NEAR(found.back().measured, 2.5, 0.5);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].specific_force_imu.x() += 4 * std::sin(0.2 * static_cast<double>(i));
  }
  found = static_conditions(samples, frames, 1, kNoise, 1, s, scratch);
  EXPECT_EQ(found[2].name, "accelerometer standard deviation");
  EXPECT_FALSE(found[2].met);
  EXPECT_FALSE(static_conditions({}, frames, 1, kNoise, 1, s, scratch).front().met);
}

TEST(Requirements, MakeASentenceOfWhatIsNotMet) {
  Requirement a = at_most("gyroscope standard deviation", 0.21, 0.014, "rad/s");
  Requirement b = at_least("parallax", 3.1, 10, "px"), c = at_least("window", 2, 1, "s");
  Requirement d = at_most("uncertainty", std::nan(""), 10, "%");
  a.way = "static";
  b.way = c.way = d.way = "dynamic";
  EXPECT_EQ(why_not_initialised(2.1, std::vector{a, c, b, d}),
            "not initialised after 2.1 s: static: gyroscope standard deviation 0.21 rad/s of at "
            "most 0.014 "
            "rad/s; dynamic: parallax 3.1 px of at least 10 px, uncertainty nan% of at most 10%");
  EXPECT_TRUE(c.met);
  EXPECT_FALSE(d.met);
}

std::string rejection(const InitialiserSettings& settings, const ImuNoise& noise = kNoise,
                      double pixel_sigma = 1, std::vector<Camera> cameras = {test_camera()}) {
  try {
    const Initialiser initialiser(settings, std::move(cameras), noise, {}, pixel_sigma);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(Initialiser, SettingsThatCannotBeUsedAreRejectedByName) {
  EXPECT_EQ(rejection({}), "");
  EXPECT_EQ(rejection({}, ImuNoise{}), "");  // densities of 0 are replaced by small ones
  InitialiserSettings s;
  s.inflation = 0.5;
  EXPECT_NE(rejection(s).find("start.inflation: found 0.5, expected a finite number not below 1"),
            std::string::npos);
  s = {};
  s.keyframes = 3;
  EXPECT_NE(rejection(s).find("start.keyframes: found 3"), std::string::npos);
  s = {};
  s.max_window = 0.5;
  EXPECT_NE(rejection(s).find("max_window"), std::string::npos);
  s = {};
  s.min_parallax = std::nan("");
  EXPECT_NE(rejection(s).find("min_parallax"), std::string::npos);
  EXPECT_NE(rejection({}, kNoise, 0).find("pixel_sigma"), std::string::npos);
  EXPECT_NE(rejection({}, kNoise, 1, {}).find("cameras"), std::string::npos);
  EXPECT_NE(rejection({}, {.accelerometer_noise_density = -1}).find("accelerometer_noise_density"),
            std::string::npos);
}

TEST(Initialiser, FramesOutOfOrderOrWithoutSamplesAreCountedAndAGapBeginsAnew) {
  Initialiser initialiser({}, {test_camera()}, kNoise, {}, 1);
  EXPECT_FALSE(initialiser.add(FeatureFrame{.time = from_seconds(0)}));  // no sample yet
  EXPECT_EQ(initialiser.counts().ignored_frames, 1);
  EXPECT_NE(why_not_initialised(0, initialiser.requirements()).find("frames with observations"),
            std::string::npos);
  const auto sample = [](double t) {
    return ImuSample{.time = from_seconds(t), .specific_force_imu = {0, 0, 9.8}};
  };
  for (int i = 0; i <= 40; ++i) initialiser.add(sample(0.01 * i));
  for (const double t : {0.1, 0.2, 0.15, 0.2, 0.3, 0.9}) {
    EXPECT_FALSE(initialiser.add(FeatureFrame{.time = from_seconds(t)}));
  }
  EXPECT_EQ(initialiser.counts().ignored_frames, 4);  // 0.15, 0.2, and 0.9 without samples
  EXPECT_EQ(initialiser.counts().restarts, 0);
  initialiser.add(sample(0.2));
  ImuSample broken = sample(0.5);
  broken.angular_rate_imu.x() = std::nan("");
  initialiser.add(broken);
  EXPECT_EQ(initialiser.imu_counts().not_finite, 1);
  EXPECT_EQ(initialiser.imu_counts().not_later, 1);
  initialiser.add(sample(1.0));
  EXPECT_EQ(initialiser.counts().restarts, 1);
}

}  // namespace
}  // namespace chasles
