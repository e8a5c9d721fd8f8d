#include <numbers>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/velocity/velocity_model.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {
namespace {

StereoRig stereo_rig() {
  StereoRig rig{.fx = 700, .fy = 700, .cx = 600, .cy = 180, .baseline = 0.5, .cam0_T_imu = {}};
  rig.cam0_T_imu.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return rig;
}

// Points ahead of and beside a car that drives along x.
Eigen::Vector3d point(LandmarkId id) {
  const auto i = static_cast<int>(id);
  return {12 + 2.0 * (i % 7), -6 + 2.0 * (i % 6), -1 + 0.7 * (i % 5)};
}

FeatureFrame frame_at(double seconds, const SE3& world_T_imu, LandmarkId first, LandmarkId count) {
  FeatureFrame frame{.time = from_seconds(seconds), .observations = {}};
  for (LandmarkId id = first; id < first + count; ++id) {
    const Eigen::Vector3d p_imu = world_T_imu.inverse() * point(id);
    const auto projection = project(stereo_rig(), stereo_rig().cam0_T_imu * p_imu);
    if (projection) frame.observations.push_back({.landmark = id, .pixels = projection->pixels});
  }
  return frame;
}

BodyVelocity velocity_at(double seconds, double speed = 1) {
  return {.time = from_seconds(seconds),
          .linear_imu = {speed, 0, 0},
          .angular_imu = Eigen::Vector3d::Zero()};
}

VelocitySlamNoise noise() {
  VelocitySlamNoise noise;
  noise.motion.sample_sigma << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;
  noise.motion.walk << 0.1, 0.1, 0.1, 1, 1, 1;
  noise.gyro_bias_sigma = 0.001;
  noise.initialisation = {.u = 0.5, .v = 0.5, .disparity = 0.7};
  noise.update = noise.initialisation;
  return noise;
}

// Every observation updates the state.
VelocitySlamSettings with_all() {
  VelocitySlamSettings settings;
  settings.updates_per_frame = 0;
  return settings;
}

VelocitySlam make(const VelocitySlamSettings& settings = {}) {
  return VelocitySlam(settings, stereo_rig(), noise());
}

// Drives along x at 1 m/s while the velocities measure `claimed`; returns the last estimate.
Estimate drive(VelocitySlam& slam, int frames, double claimed = 1) {
  Estimate estimate;
  for (int i = 0; i < frames; ++i) {
    const double t = 0.1 * i;
    slam.process(velocity_at(t, claimed));
    estimate = slam.process(frame_at(t, {Eigen::Matrix3d::Identity(), {t, 0, 0}}, 0, 30));
  }
  return estimate;
}

TEST(VelocitySlam, StaysOnTheTruthWhenEverythingIsExact) {
  VelocitySlam slam = make(with_all());
  const Estimate estimate = drive(slam, 50);
  EXPECT_LT((estimate.world_T_imu.p - Eigen::Vector3d(4.9, 0, 0)).norm(), 1e-6);
  EXPECT_LT(so3::log(estimate.world_T_imu.R).norm(), 1e-7);
  EXPECT_EQ(estimate.used, 30);
  EXPECT_EQ(estimate.health, Health::kOk);
  for (const MapLandmark& landmark : slam.filter().map()) {
    EXPECT_LT((landmark.p_world - point(landmark.id)).norm(), 1e-6);
  }
}

TEST(VelocitySlam, LandmarksCorrectAVelocityThatIsWrong) {
  VelocitySlamSettings localize;
  localize.mode = SlamMode::kLocalize;
  VelocitySlam blind = make(localize);
  VelocitySlam seeing = make();
  EXPECT_NEAR(drive(blind, 50, 1.1).world_T_imu.p.x(), 5.39, 1e-9);
  EXPECT_NEAR(drive(seeing, 50, 1.1).world_T_imu.p.x(), 4.9, 0.05);
}

TEST(VelocitySlam, AnObservationThatBeginsALandmarkDoesNotUpdateTheState) {
  VelocitySlam slam = make();
  slam.process(velocity_at(0));
  const Estimate first = slam.process(frame_at(0, {}, 0, 10));
  EXPECT_EQ(first.added, 10);
  EXPECT_EQ(first.used, 0);
  slam.process(velocity_at(0.1));
  const Estimate second =
      slam.process(frame_at(0.1, {Eigen::Matrix3d::Identity(), {0.1, 0, 0}}, 0, 12));
  EXPECT_EQ(second.used, 10);
  EXPECT_EQ(second.added, 2);
}

TEST(VelocitySlam, ALocalizedCarOnACircleComesBackToItsStart) {
  VelocitySlamSettings settings;
  settings.mode = SlamMode::kLocalize;
  VelocitySlam slam = make(settings);
  const double rate = 2 * 3.14159265358979323846 / 10;  // one turn in 10 s
  Estimate estimate;
  for (int i = 0; i <= 100; ++i) {
    BodyVelocity u = velocity_at(0.1 * i, 5);
    u.angular_imu.z() = rate;
    slam.process(u);
    estimate = slam.process(FeatureFrame{.time = u.time, .observations = {}});
  }
  EXPECT_LT(estimate.world_T_imu.p.norm(), 1e-9);
  EXPECT_GT(estimate.pose_covariance()(5, 5), 0);
}

TEST(VelocitySlam, MappingTakesTheTrajectoryForTheTruth) {
  VelocitySlamSettings settings = with_all();
  settings.mode = SlamMode::kMap;
  VelocitySlam slam = make(settings);
  const Estimate estimate = drive(slam, 20);
  EXPECT_EQ(estimate.pose_covariance().norm(), 0);
  EXPECT_NEAR(estimate.world_T_imu.p.x(), 1.9, 1e-9);
  const auto map = slam.filter().map();
  ASSERT_EQ(map.size(), 30u);
  EXPECT_EQ(map[0].observations, 20);
  EXPECT_LT(map[0].covariance.trace(), 0.01);
}

// Du's figures 4 to 6: where a landmark began, and where the mapping update moved it.
TEST(VelocitySlam, KeepsTheInitialPositionsBeforeTheFirstUpdate) {
  for (const bool at_once : {false, true}) {
    VelocitySlamSettings settings;
    settings.mode = SlamMode::kMap;
    settings.update_with_first_observation = at_once;
    VelocitySlam slam = make(settings);
    slam.process(velocity_at(0));
    FeatureFrame first = frame_at(0, {}, 0, 10);
    for (StereoObservation& o : first.observations) o.pixels[0] += 0.4;  // the depth is wrong
    slam.process(first);
    for (int i = 1; i < 20; ++i) {
      slam.process(velocity_at(0.1 * i));
      slam.process(frame_at(0.1 * i, {Eigen::Matrix3d::Identity(), {0.1 * i, 0, 0}}, 0, 10));
    }
    const auto map = slam.filter().map();
    ASSERT_EQ(map.size(), 10u);
    ASSERT_EQ(slam.initial_landmarks().size(), 10u);
    for (std::size_t i = 0; i < map.size(); ++i) {
      const MapLandmark& initialised = slam.initial_landmarks()[i];
      ASSERT_EQ(initialised.id, map[i].id);
      const auto expected = triangulate(stereo_rig(), first.observations[i].pixels);
      ASSERT_TRUE(expected);
      const Eigen::Vector3d p = stereo_rig().cam0_T_imu.inverse() * expected->p_cam0;
      EXPECT_LT((initialised.p_world - p).norm(), 1e-9) << at_once;
      EXPECT_LT((map[i].p_world - point(initialised.id)).norm(),
                (p - point(initialised.id)).norm());
      EXPECT_LT(map[i].covariance.trace(), initialised.covariance.trace());
    }
  }
}

TEST(VelocitySlam, AGrossObservationIsRejectedAndChangesNothing) {
  VelocitySlam clean = make();
  VelocitySlam dirty = make();
  for (int i = 0; i < 20; ++i) {
    const double t = 0.1 * i;
    FeatureFrame frame = frame_at(t, {Eigen::Matrix3d::Identity(), {t, 0, 0}}, 0, 30);
    FeatureFrame wrong = frame;
    if (i > 5) wrong.observations[3].pixels += Eigen::Vector4d(80, -40, 80, -40);
    if (i > 5) frame.observations.erase(frame.observations.begin() + 3);
    clean.process(velocity_at(t));
    dirty.process(velocity_at(t));
    const Estimate a = clean.process(frame);
    const Estimate b = dirty.process(wrong);
    EXPECT_EQ(b.rejected, i > 5 ? 1 : 0);
    EXPECT_LT((a.world_T_imu.p - b.world_T_imu.p).norm(), 1e-9);
  }
}

// A filter without a gate uses whatever it is given: only its NIS shows that the noise is wrong.
TEST(VelocitySlam, InnovationsThatContradictTheirCovarianceDegradeIt) {
  for (const SlamMode mode : {SlamMode::kSlam, SlamMode::kMap}) {
    for (const double stated : {2.0, 0.2}) {
      VelocitySlamSettings settings = with_all();
      settings.mode = mode;
      settings.gate = settings.loose_gate = 1;
      VelocitySlamNoise noise_of_run = noise();
      noise_of_run.initialisation = {.u = stated, .v = stated, .disparity = stated};
      noise_of_run.update = noise_of_run.initialisation;
      VelocitySlam slam(settings, stereo_rig(), noise_of_run);
      Estimate estimate;
      for (int i = 0; i < 20; ++i) {
        const double t = 0.1 * i;
        slam.process(velocity_at(t));
        FeatureFrame frame = frame_at(t, {Eigen::Matrix3d::Identity(), {t, 0, 0}}, 0, 30);
        for (StereoObservation& o : frame.observations) {
          const double error = (i + o.landmark) % 2 == 0 ? 2 : -2;
          o.pixels += Eigen::Vector4d(error, -error, error, -error);
        }
        estimate = slam.process(frame);
      }
      EXPECT_EQ(estimate.used, 30);
      EXPECT_EQ(estimate.health, stated == 2 ? Health::kOk : Health::kDegraded);
      EXPECT_EQ(estimate.degradation, stated == 2 ? Degradation::kNone : Degradation::kInnovations);
    }
  }
}

TEST(VelocitySlam, ObservationsThatAreNotFiniteOrComeTwiceAreLeftOut) {
  VelocitySlam slam = make();
  slam.process(velocity_at(0));
  FeatureFrame frame = frame_at(0, {}, 0, 10);
  frame.observations.push_back(frame.observations[2]);
  frame.observations[5].pixels[1] = std::nan("");
  const Estimate estimate = slam.process(frame);
  EXPECT_EQ(estimate.observations, 11);
  EXPECT_EQ(estimate.added, 9);
}

TEST(VelocitySlam, TimeThatRunsBackwardsIsAnErrorWithBothTimes) {
  VelocitySlam slam = make();
  slam.process(velocity_at(1));
  try {
    slam.process(velocity_at(0.5));
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("500000000 ns after 1000000000 ns"),
              std::string::npos);
  }
}

TEST(VelocitySlam, AVelocityThatIsNotFiniteIsAnErrorWithItsTime) {
  VelocitySlam slam = make();
  BodyVelocity u = velocity_at(2);
  u.angular_imu.y() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(slam.process(u), InputError);
}

TEST(VelocitySlam, WithoutObservationsItSaysDegradedAndItsUncertaintyGrows) {
  VelocitySlam slam = make();
  const Estimate good = drive(slam, 20);
  Estimate blind;
  for (int i = 20; i < 60; ++i) {
    slam.process(velocity_at(0.1 * i));
    blind = slam.process(FeatureFrame{.time = from_seconds(0.1 * i), .observations = {}});
  }
  EXPECT_EQ(good.health, Health::kOk);
  EXPECT_EQ(blind.health, Health::kDegraded);
  EXPECT_GT(blind.pose_covariance().trace(), 10 * good.pose_covariance().trace());
}

TEST(VelocitySlam, AfterAGapOfSecondsItRecovers) {
  VelocitySlam slam = make();
  drive(slam, 20);
  Estimate estimate;
  for (int i = 50; i < 70; ++i) {  // 3 s without data, then new landmarks only
    const double t = 0.1 * i;
    slam.process(velocity_at(t));
    estimate = slam.process(frame_at(t, {Eigen::Matrix3d::Identity(), {t, 0, 0}}, 100, 30));
  }
  EXPECT_EQ(estimate.health, Health::kOk);
  EXPECT_NEAR(estimate.world_T_imu.p.x(), 6.9, 0.05);
  EXPECT_EQ(estimate.landmarks, 60);
}

TEST(VelocitySlam, LandmarksOutOfViewWaitWhileThereIsRoomAndThenGoToTheMap) {
  VelocitySlamSettings settings;
  settings.waiting_landmarks = 12;
  VelocitySlam slam = make(settings);
  slam.process(velocity_at(0));
  slam.process(frame_at(0, {}, 0, 8));
  slam.process(velocity_at(0.1, 0));
  Estimate estimate = slam.process(FeatureFrame{.time = from_seconds(0.1), .observations = {}});
  EXPECT_EQ(estimate.in_state, 8);  // waiting
  estimate = slam.process(frame_at(0.2, {}, 100, 20));
  EXPECT_EQ(estimate.in_state, 28);
  estimate = slam.process(frame_at(0.3, {}, 100, 20));
  EXPECT_EQ(estimate.in_state, 20);
  EXPECT_EQ(estimate.landmarks, 28);
}

TEST(VelocitySlam, WhereMoreAreInViewThanAFrameMayUseTheirTurnComesRound) {
  VelocitySlamSettings settings;
  settings.updates_per_frame = 8;
  settings.gate = 1;
  settings.loose_gate = 1;
  VelocitySlam slam = make(settings);
  for (int k = 0; k <= 5; ++k) {
    const double t = 0.1 * k;
    slam.process(velocity_at(t));
    const Estimate estimate =
        slam.process(frame_at(t, {Eigen::Matrix3d::Identity(), {t, 0, 0}}, 0, 20));
    EXPECT_EQ(estimate.used, k == 0 ? 0 : 8);
    EXPECT_EQ(estimate.rejected, 0);
    EXPECT_EQ(estimate.in_state, 20);
  }
  // 40 updates over 20 landmarks, each initialised by one further observation.
  for (const MapLandmark& landmark : slam.filter().map()) {
    EXPECT_EQ(landmark.observations, 3) << landmark.id;
  }
}

TEST(VelocitySlam, TwoRunsGiveTheSameNumbers) {
  VelocitySlam a = make();
  VelocitySlam b = make();
  const Estimate first = drive(a, 30, 1.05);
  const Estimate second = drive(b, 30, 1.05);
  EXPECT_EQ(first.world_T_imu.p, second.world_T_imu.p);
  EXPECT_EQ(first.pose_covariance(), second.pose_covariance());
}

TEST(VelocitySlam, EveryChartAndMotionModelFollowsTheTruth) {
  for (const ErrorChart& chart : error_charts()) {
    for (const VelocityRole velocity : {VelocityRole::kMeasured, VelocityRole::kInput}) {
      for (const StereoRows rows :
           {StereoRows::kAll, StereoRows::kMeanDisparity, StereoRows::kMean}) {
        VelocitySlamSettings settings;
        settings.chart = chart.name;
        settings.velocity = velocity;
        settings.stereo_rows = rows;
        settings.velocity_scale = true;
        VelocitySlam slam = make(settings);
        EXPECT_NEAR(drive(slam, 30, 1.02).world_T_imu.p.x(), 2.9, 0.02)
            << chart.name << " " << name_of(velocity) << " " << name_of(rows);
        EXPECT_EQ(static_cast<Eigen::Index>(slam.additive_names().size()),
                  slam.filter().state().additive.size());
      }
    }
  }
}

VelocitySlamNoise level_noise() {
  VelocitySlamNoise level = noise();
  level.level_velocities = true;
  return level;
}

// A car whose IMU is pitched by 0.05 rad, on a level road. Its velocities have no vertical
// component; its camera observes that the IMU's x axis differs from the direction of motion.
TEST(VelocitySlam, LevelVelocitiesShowHowTheImuIsMounted) {
  VelocitySlam slam(VelocitySlamSettings{}, stereo_rig(), level_noise());
  const Eigen::Matrix3d nav_R_imu = so3::exp(Eigen::Vector3d(0, -0.05, 0));
  Estimate e;
  for (int i = 0; i < 5; ++i) {
    const double t = 0.1 * i;
    slam.process(velocity_at(t, 5));
    const Eigen::Vector3d p_world = nav_R_imu.transpose() * Eigen::Vector3d(5 * t, 0, 0);
    e = slam.process(frame_at(t, {Eigen::Matrix3d::Identity(), p_world}, 0, 40));
  }
  const BodyVelocityModel model = model_of({}, level_noise());
  ASSERT_EQ(e.additive.size(), model.size());
  const double sigma = e.additive_sigma()[model.tilt_index() + 1];
  EXPECT_LT(sigma, 0.03);  // of 0.05
  EXPECT_NEAR(e.additive[model.tilt_index() + 1], -0.05, 3 * sigma);
  EXPECT_NEAR(e.world_T_imu.p.z(), -std::sin(0.05) * 2, 0.02);
}

// The body pitches up by a right angle in one step. Its camera points along the axis of the
// rotation, and observes the same points.
TEST(VelocitySlam, AFrameWithoutLevelAxesKeepsItsPixels) {
  StereoRig sideways = stereo_rig();
  sideways.cam0_T_imu.R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  VelocitySlam slam(with_all(), sideways, level_noise());
  const double step = -std::numbers::pi / 2;
  Estimate e;
  for (int i = 0; i < 2; ++i) {
    BodyVelocity turning = velocity_at(0.1 * i, 0);
    turning.angular_imu = {0, step / 0.1, 0};
    slam.process(turning);
    FeatureFrame frame{.time = from_seconds(0.1 * i)};
    for (int id = 0; id < 30; ++id) {
      const Eigen::Vector3d p_world(0.3 * (id % 6) - 1, 10 + 0.2 * (id % 7), 0.3 * (id % 5) - 0.5);
      const Eigen::Vector3d p_imu = so3::exp(Eigen::Vector3d(0, -step * i, 0)) * p_world;
      const auto seen = project(sideways, sideways.cam0_T_imu * p_imu);
      ASSERT_TRUE(seen);
      frame.observations.push_back({.landmark = id, .pixels = seen->pixels});
    }
    e = slam.process(frame);
  }
  EXPECT_EQ(e.used, 30);
  EXPECT_EQ(e.rejected, 0);
  EXPECT_NEAR(so3::log(e.world_T_imu.R).y(), step, 0.01);
}

}  // namespace
}  // namespace chasles
