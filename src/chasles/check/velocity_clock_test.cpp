#include <limits>

#include <gtest/gtest.h>

#include <chasles/check/velocity_clock.hpp>
#include <chasles/lie/se3.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

struct Drive {
  double lag = 0;            // delay of the velocities' stamps [s]
  double seconds = 30;       // duration [s]
  double turning = 1;        // factor on the changing part of the motion
  double pixel_noise = 0.3;  // [px]
  double outliers = 0;       // share of observations that are wrong by tens of pixels
  double rate_noise = 0, velocity_noise = 0;
  Eigen::Vector3d mounting =
      Eigen::Vector3d::Zero();  // rotation of the samples' axes relative to the IMU's
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  double scale = 1;
};

constexpr double kStep = 0.1;  // between two frames, and two velocities [s]

Vector6d true_velocity(const Drive& drive, double t) {
  Vector6d u;
  u << 0.02 * std::sin(1.1 * t), 0.02 * std::cos(0.9 * t), 0.2 * std::sin(0.5 * t),
      1.5 * std::sin(0.4 * t), 0.1 * std::sin(t), 0.05 * std::cos(0.7 * t);
  u *= drive.turning;
  u[3] += 8;
  return u;
}

StereoRig rig() {
  StereoRig rig{.fx = 700, .fy = 700, .cx = 600, .cy = 180, .baseline = 0.5, .cam0_T_imu = {}};
  Eigen::Matrix3d axes;  // z forward, x right, y down
  axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  rig.cam0_T_imu = {so3::exp({0.02, -0.01, 0.03}) * axes, {0.2, 0.1, -0.3}};
  return rig;
}

BodyVelocity sample(const Drive& drive, double t, test::Random& random) {
  const Vector6d u = true_velocity(drive, t - drive.lag);
  const Eigen::Matrix3d R = so3::exp(drive.mounting);
  return {.time = from_seconds(t),
          .linear_imu = R * u.tail<3>() * drive.scale +
                        drive.velocity_noise * Eigen::Vector3d(random.normal_vector(3)),
          .angular_imu = R * u.head<3>() + drive.bias +
                         drive.rate_noise * Eigen::Vector3d(random.normal_vector(3))};
}

FeatureFrame observe(const Drive& drive, double t, const SE3& world_T_imu,
                     const std::vector<Eigen::Vector3d>& points, test::Random& random) {
  FeatureFrame frame{.time = from_seconds(t)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto seen = project(rig(), rig().cam0_T_imu * (world_T_imu.inverse() * points[i]));
    if (!seen || seen->pixels[0] < 0 || seen->pixels[0] > 1200 || seen->pixels[1] < 0 ||
        seen->pixels[1] > 360 || seen->pixels[0] - seen->pixels[2] < 8) {
      continue;
    }
    Eigen::Vector4d pixels = seen->pixels + drive.pixel_noise * random.normal_vector(4);
    if (random.uniform() < drive.outliers) pixels += 30 * random.normal_vector(4);
    frame.observations.push_back({.landmark = static_cast<LandmarkId>(i), .pixels = pixels});
  }
  return frame;
}

// A path between points on both sides.
Recording drive_past_points(const Drive& drive) {
  constexpr int kSubsteps = 100;
  test::Random random(7);
  Recording r;
  r.rig = rig();
  SE3 world_T_imu;
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k * kStep < drive.seconds; ++k) {
    const double t = k * kStep;
    for (int i = 0; i < 4; ++i) {
      const double side = (random.uniform() < 0.5 ? -1 : 1) * (3 + 9 * random.uniform());
      points.push_back(world_T_imu *
                       Eigen::Vector3d(8 + 30 * random.uniform(), side, 3 * random.uniform() - 1));
    }
    r.velocities.push_back(sample(drive, t, random));
    r.frames.push_back(observe(drive, t, world_T_imu, points, random));
    for (int i = 0; i < kSubsteps; ++i) {
      const double middle = t + (i + 0.5) * kStep / kSubsteps;
      world_T_imu = world_T_imu * se3::exp(kStep / kSubsteps * true_velocity(drive, middle));
    }
  }
  return r;
}

void expect_found(const Drive& drive) {
  const auto clock = velocity_clock(drive_past_points(drive));
  ASSERT_TRUE(clock);
  EXPECT_NEAR(clock->offset, drive.lag, 4 * clock->sigma);
  EXPECT_LT(clock->sigma, 0.006);
  EXPECT_EQ(clock->stands_out(), drive.lag != 0) << clock->offset;
}

TEST(VelocityClock, IsDeterminedByTheTracks) {
  for (const double lag : {0.06, -0.045, 0.17, 0.0}) expect_found({.lag = lag});
}

TEST(VelocityClock, WhatIsConstantAndWhatIsWrongDoesNotMislead) {
  for (const double lag : {0.06, 0.0}) {
    expect_found({.lag = lag, .mounting = {0.03, -0.02, 0.01}});
    expect_found({.lag = lag, .bias = {0.002, -0.002, 0.004}});
    expect_found({.lag = lag, .scale = 1.03});
    expect_found({.lag = lag, .outliers = 0.3});
  }
}

TEST(VelocityClock, OfNoiseFreeNumbersIsExact) {
  const auto clock = velocity_clock(drive_past_points({.lag = 0.06, .pixel_noise = 0}));
  ASSERT_TRUE(clock);
  EXPECT_NEAR(clock->offset, 0.06, 0.002);  // samples are interpolated
  EXPECT_LT(clock->scatter, 0.1);
}

TEST(VelocityClock, AbsurdPixelsAreLeftOut) {
  Recording r = drive_past_points({.lag = 0.06});
  for (std::size_t k = 0; k < r.frames.size(); k += 3) {
    std::vector<StereoObservation>& all = r.frames[k].observations;
    for (std::size_t i = 0; i + 1 < all.size(); i += 7) {
      all[i].pixels = Eigen::Vector4d::Constant(600);
      all[i].pixels[2] -= 1e-12;  // a nearly infinite distance
      all[i + 1].pixels.setConstant(1e300);
    }
  }
  const auto clock = velocity_clock(r);
  ASSERT_TRUE(clock);
  EXPECT_NEAR(clock->offset, 0.06, 4 * clock->sigma);
}

// The mean of two noisy samples has less noise than either, whatever the time offset.
TEST(VelocityClock, OfNoisySamplesIsNotAccepted) {
  for (const double lag : {0.0, 0.06}) {
    const auto clock =
        velocity_clock(drive_past_points({.lag = lag, .rate_noise = 0.05, .velocity_noise = 0.5}));
    EXPECT_FALSE(clock && clock->stands_out());
  }
}

TEST(VelocityClock, IsUndeterminedWithoutInformation) {
  EXPECT_FALSE(velocity_clock({}));
  EXPECT_FALSE(velocity_clock(drive_past_points({.lag = 0.06, .seconds = 8})));
  const auto steady = velocity_clock(drive_past_points({.lag = 0.06, .turning = 0}));
  EXPECT_FALSE(steady && steady->stands_out());
  Recording r = drive_past_points({.lag = 0.06});
  for (FeatureFrame& frame : r.frames) frame.observations.clear();
  EXPECT_FALSE(velocity_clock(r));
  r = drive_past_points({.lag = 0.06});
  for (FeatureFrame& frame : r.frames) {
    for (StereoObservation& o : frame.observations) {
      o.pixels[2] = std::numeric_limits<double>::quiet_NaN();
    }
  }
  EXPECT_FALSE(velocity_clock(r));
}

std::vector<double> stamps(const Recording& r) {
  std::vector<double> seconds;
  for (const BodyVelocity& u : r.velocities) seconds.push_back(to_seconds(u.time));
  return seconds;
}

Recording three_samples(double first_frame) {
  Recording r;
  r.frames.push_back({.time = from_seconds(first_frame)});
  for (const double t : {0.0, 0.1, 0.2}) {
    r.velocities.push_back({.time = from_seconds(t), .linear_imu = {t, 0, 0}});
  }
  return r;
}

TEST(ShiftVelocities, TheFirstFrameStaysTheBeginning) {
  Recording late = three_samples(0);
  shift_velocities(late, 0.06);
  EXPECT_EQ(stamps(late), (std::vector<double>{0, 0.04, 0.14}));
  EXPECT_NEAR(late.velocities[0].linear_imu.x(), 0.06, 1e-12);
  EXPECT_EQ(late.velocities[1].linear_imu.x(), 0.1);
  Recording by_a_step = three_samples(0);
  shift_velocities(by_a_step, 0.1);
  EXPECT_EQ(stamps(by_a_step), (std::vector<double>{0, 0.1}));
  EXPECT_EQ(by_a_step.velocities[0].linear_imu.x(), 0.1);
  Recording early = three_samples(0);
  shift_velocities(early, -0.06);
  EXPECT_EQ(stamps(early), (std::vector<double>{0.06, 0.16, 0.26}));
}

TEST(ShiftVelocities, WhatBeganBeforeTheFramesStays) {
  Recording r = three_samples(0.15);
  shift_velocities(r, 0.06);
  EXPECT_EQ(stamps(r), (std::vector<double>{-0.06, 0.04, 0.14}));
  Recording none;
  shift_velocities(none, 0.06);
  EXPECT_TRUE(none.velocities.empty());
}

TEST(ShiftVelocities, AllBeforeTheFirstFrameAreKept) {
  Recording r = three_samples(0);
  shift_velocities(r, 0.5);
  EXPECT_EQ(r.velocities.size(), 3u);
}

}  // namespace
}  // namespace chasles
