#include <cmath>

#include <gtest/gtest.h>

#include <chasles/lab/trial.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_world.hpp>
#include <chasles/slam/inertial_calibration.hpp>

// Cameras with a rolling shutter, and with a calibration that is wrong, over some walks around a
// corner. studies/cameras.md has the figures of more and longer ones.
namespace chasles {
namespace {

constexpr std::uint64_t kCameraRuns = 8;

InertialScene corner(std::uint64_t seed, double readout) {
  InertialScene scene = inertial_scene("hallway");
  InertialSettings& s = scene.settings;
  s.hall_length = s.hall_width = 8;
  s.sections = 1;
  s.frame_rate = 10;
  s.seed = 700 + seed;
  s.distortion = Distortion::kRadtan;
  s.distortion_1 = -0.2;
  s.distortion_2 = 0.04;
  s.readout_time = readout;
  return scene;
}

struct CameraScore {
  double ate = 0, nees = 0;  // means of the runs; of the pose at the end

  void add(const Trial& trial) {
    EXPECT_FALSE(trial.diverged);
    ate += averages(trial).ate_posyaw / static_cast<double>(kCameraRuns);
    nees += trial.points.back().nees_pose / static_cast<double>(kCameraRuns);
  }
};

Trial trial_of(const Recording& recording, const InertialSlamSettings& settings,
               std::uint64_t run) {
  const FilterVariant filter{.name = "own", .settings = settings};
  return run_trial(filter, recording, draw_start(recording, settings, 3, run));
}

TEST(RollingShutterRuns, AreAsAccurateAsThoseOfAGlobalOne) {
  CameraScore global, rolling, ignored;
  for (std::uint64_t i = 0; i < kCameraRuns; ++i) {
    global.add(trial_of(simulate_inertial(corner(i, 0)), {}, i));
    Recording recording = simulate_inertial(corner(i, 0.03));
    rolling.add(trial_of(recording, {}, i));
    recording.cameras.front().shutter = {};
    ignored.add(trial_of(recording, {}, i));
  }
  EXPECT_LT(rolling.ate, 1.15 * global.ate);
  EXPECT_LT(rolling.nees, 12) << "expected: 6";
  EXPECT_GT(ignored.ate, 2 * global.ate);
  EXPECT_GT(ignored.nees, 30);
}

// A camera as its calibration might state it, by the initial sigmas of the settings.
Camera stated_wrongly(const Camera& camera, const InertialSlamSettings& settings,
                      std::uint64_t run) {
  const Random random{900};
  std::uint32_t component = 0;
  const auto normal = [&] { return random.normal(Stream::kStart, run, component++); };
  const auto three = [&](double sigma) {
    const double x = normal(), y = normal(), z = normal();
    return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
  };
  SE3 imu_T_cam = camera.cam_T_imu.inverse();
  imu_T_cam.R = so3::exp(three(settings.initial_extrinsic_rotation_sigma)) * imu_T_cam.R;
  imu_T_cam.p += three(settings.initial_extrinsic_translation_sigma);
  Intrinsics stated = intrinsics_of(camera);
  const std::vector<double> sigmas = intrinsics_sigmas(settings, camera);
  for (int i = 0; i < 4; ++i)
    stated.projection[i] += sigmas[static_cast<std::size_t>(i)] * normal();
  stated.readout += settings.initial_readout_sigma * normal();
  for (std::size_t k = 0; k < stated.coefficients.size(); ++k) {
    stated.coefficients[k] += sigmas[6 + k] * normal();
  }
  Camera wrong = with_intrinsics(camera, stated);
  wrong.cam_T_imu = imu_T_cam.inverse();
  return wrong;
}

TEST(WrongCalibration, IsEstimatedOrConsideredConsistently) {
  InertialSlamSettings known;
  known.initial_extrinsic_rotation_sigma = 0.0035;
  known.initial_extrinsic_translation_sigma = 0.005;
  const auto with = [&](Calibrate use) {
    InertialSlamSettings settings = known;
    settings.calibrate_extrinsics = settings.calibrate_intrinsics = use;
    settings.calibrate_readout = use;
    return settings;
  };
  CameraScore exact, wrong, estimated, considered;
  double squares = 0, parameters = 0;
  for (std::uint64_t i = 0; i < kCameraRuns; ++i) {
    Recording recording = simulate_inertial(corner(i, 0.02));
    exact.add(trial_of(recording, known, i));
    const Camera camera = recording.cameras.front();
    recording.cameras.front() = stated_wrongly(camera, known, i);
    wrong.add(trial_of(recording, known, i));
    considered.add(trial_of(recording, with(Calibrate::kConsidered), i));
    const Trial trial = trial_of(recording, with(Calibrate::kTrue), i);
    estimated.add(trial);
    ASSERT_TRUE(trial.calibration);
    const Intrinsics& found = trial.calibration->intrinsics.front();
    const int row = trial.calibration->intrinsics_row();
    const Eigen::Vector4d error = found.projection - intrinsics_of(camera).projection;
    const auto variances = trial.calibration->covariance.diagonal().segment<4>(row);
    squares += error.cwiseAbs2().cwiseQuotient(variances).sum();
    const double late = found.readout - camera.shutter.readout;
    squares +=
        late * late /
        trial.calibration->covariance(row + Intrinsics::kReadoutRow, row + Intrinsics::kReadoutRow);
    parameters += 5;
  }
  EXPECT_GT(wrong.nees, 30) << "expected: 6";
  EXPECT_LT(considered.nees, 12);
  EXPECT_LT(estimated.nees, 12);
  EXPECT_LT(estimated.ate, 1.5 * exact.ate);
  EXPECT_LT(estimated.ate, wrong.ate);
  EXPECT_LT(squares / parameters, 2) << "expected: 1";
}

}  // namespace
}  // namespace chasles
