// The real recordings with the settings of `chasles run RECORDING`: defaults, no options. The
// limits are those of the project's issue 2; docs/results.md has the figures.

#include <cstdlib>
#include <filesystem>
#include <map>

#include <gtest/gtest.h>

#include <chasles/eval/evaluation.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

fs::path data() {
  const char* set = std::getenv("CHASLES_DATA");
  return (set ? fs::path(set) : fs::path(CHASLES_SOURCE_DIR) / "../shared/data") / "kitti_tracks";
}

struct Case {
  const char* name;
  const char* file;
  const char* truth;  // null: in the recording itself
  std::map<std::string, double> limits;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

Recording read(const Case& c) {
  Recording recording = read_recording(data() / c.file);
  if (c.truth) recording.truth = read_tum(data() / "ground_truth" / c.truth);
  return recording;
}

struct Result {
  std::vector<Estimate> estimates;
  std::vector<MapLandmark> map;
};

Result run(const Recording& recording, const VelocitySlamSettings& settings) {
  const VelocitySlamNoise noise = choose_noise(settings, recording.velocities, recording.frames,
                                               {recording.velocity_sigma, recording.pixel_sigma});
  VelocitySlam slam(settings, recording.rig, noise);
  Result result;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<BodyVelocity>(&*event)) {
      slam.process(*velocity);
    } else {
      result.estimates.push_back(slam.process(std::get<FeatureFrame>(*event)));
    }
  }
  result.map = slam.filter().map();
  return result;
}

Evaluation evaluated(const Recording& recording, const std::vector<Estimate>& estimates,
                     PoseError pose_error) {
  Trajectory trajectory;
  std::vector<Matrix6d> covariances;
  for (const Estimate& e : estimates) {
    trajectory.push_back({.time = e.time, .pose = e.world_T_imu});
    covariances.push_back(e.pose_covariance());
  }
  EvaluationOptions options;
  options.pose_error = pose_error;
  return evaluate(trajectory, recording.truth, covariances, options);
}

double figure(const Evaluation& evaluation, const std::string& name) {
  for (const auto& [key, value] : figures(evaluation)) {
    if (key == name) return value.value_or(std::nan(""));
  }
  throw std::out_of_range(name);
}

const Case k2018_0020{"Ece2018_0020",
                      "ece276a_2018/0020.npz",
                      "0020_gt_imu_stars.tum",
                      {{"ate_m", 3.5}, {"rpe_100m_percent", 1.77}}};
const Case k2020_0022{"Ece2020_0022",
                      "ece276a_2020/0022.npz",
                      "0022_pseudogt_orbslam3_imu.tum",
                      {{"ate_m", 2.36}, {"rpe_100m_percent", 1.74}, {"attitude_deg", 1.2}}};
const Case k2020_0027{"Ece2020_0027",
                      "ece276a_2020/0027.npz",
                      "0027_gt_imu_stars.tum",
                      {{"ate_m", 2.7}, {"rpe_100m_percent", 1.27}, {"attitude_deg", 2.5}}};
const Case kStarryNight{"StarryNight", "stars/dataset3.mat", nullptr, {{"ate_m", 0.053}}};

std::string case_name(const testing::TestParamInfo<Case>& c) { return c.param.name; }

class RealRecording : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    if (!fs::exists(data())) GTEST_SKIP() << "skipped: no recordings";
  }
};

TEST_P(RealRecording, IsEstimatedWithinItsLimits) {
  const Recording recording = read(GetParam());
  const Result result = run(recording, {});
  const Evaluation evaluation = evaluated(recording, result.estimates, PoseError::kWorldTwist);
  for (const auto& [name, limit] : GetParam().limits) {
    EXPECT_LE(figure(evaluation, name), limit) << name;
    RecordProperty(name, std::to_string(figure(evaluation, name)));
  }
}

// The limit of each recording is the 100 m relative error of dead reckoning (docs/results.md).
INSTANTIATE_TEST_SUITE_P(Drives, RealRecording,
                         testing::Values(k2020_0022, k2020_0027, kStarryNight, k2018_0020,
                                         Case{"Ece2018_0027",
                                              "ece276a_2018/0027.npz",
                                              "0027_gt_imu_stars.tum",
                                              {{"ate_m", 1.85}, {"rpe_100m_percent", 2.16}}},
                                         Case{"Ece2018_0042",
                                              "ece276a_2018/0042.npz",
                                              "0042_gt_imu_stars.tum",
                                              {{"ate_m", 2.1}, {"rpe_100m_percent", 1.21}}},
                                         Case{"Stars0001",
                                              "stars/2011_09_26_drive_0001_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 2.21}}},
                                         Case{"Stars0009",
                                              "stars/2011_09_26_drive_0009_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 1.90}}},
                                         Case{"Stars0027",
                                              "stars/2011_09_26_drive_0027_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 1.37}}},
                                         Case{"Stars0036",
                                              "stars/2011_09_26_drive_0036_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 1.58}}},
                                         Case{"Stars0039",
                                              "stars/2011_09_26_drive_0039_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 1.43}}},
                                         Case{"Stars0930_0027",
                                              "stars/2011_09_30_drive_0027_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 1.92}}},
                                         Case{"Stars1003_0042",
                                              "stars/2011_10_03_drive_0042_sync_KLT.mat",
                                              nullptr,
                                              {{"rpe_100m_percent", 1.31}}}),
                         case_name);

class LongRecording : public RealRecording {};

TEST_P(LongRecording, LandmarksInTheGroupHaveATenthOfThePoseNees) {
  const Recording recording = read(GetParam());
  VelocitySlamSettings settings;
  settings.updates_per_frame = 50;  // the standard chart is the more overconfident the more it uses
  VelocitySlamSettings standard = settings;
  standard.chart = "standard";
  const Evaluation group =
      evaluated(recording, run(recording, settings).estimates, PoseError::kWorldTwist);
  const Evaluation other =
      evaluated(recording, run(recording, standard).estimates, PoseError::kStandard);
  EXPECT_LE(figure(group, "nees_pose"), figure(other, "nees_pose") / 10);
}

INSTANTIATE_TEST_SUITE_P(NoisyVelocities, LongRecording, testing::Values(k2020_0022, k2020_0027),
                         case_name);

TEST_F(RealRecording, StarryNightIsMappedAndItsCovarianceIsConsistent) {
  const Recording recording = read(kStarryNight);
  const Result result = run(recording, {});
  const double nees =
      figure(evaluated(recording, result.estimates, PoseError::kWorldTwist), "nees_pose");
  EXPECT_GT(nees, 4);
  EXPECT_LT(nees, 8);
  // The world frame of the estimate is the first pose of the vehicle.
  const SE3& truth_T_world = recording.truth.front().pose;
  double sum = 0;
  ASSERT_EQ(result.map.size(), recording.true_landmarks.size());
  for (const MapLandmark& landmark : result.map) {
    const auto& truth = recording.true_landmarks.at(static_cast<std::size_t>(landmark.id));
    ASSERT_EQ(truth.id, landmark.id);
    sum += (truth_T_world * landmark.p_world - truth.p_world).squaredNorm();
  }
  EXPECT_LE(std::sqrt(sum / static_cast<double>(result.map.size())), 0.045);
}

// Cut so that the dense filter is fast enough: 60 frames, about 500 landmarks.
TEST_F(RealRecording, TheCompressedMapIsThatOfTheDenseFilterInEveryChart) {
  Recording recording = read(k2020_0027);
  recording.frames.resize(60);
  recording.velocities.resize(60);
  for (const ErrorChart& chart : error_charts()) {
    VelocitySlamSettings settings;
    settings.chart = chart.name;
    const Result compressed = run(recording, settings);
    settings.compress_map = false;
    const Result dense = run(recording, settings);
    ASSERT_EQ(compressed.map.size(), dense.map.size());
    ASSERT_GT(dense.map.size(), 400u);
    for (std::size_t i = 0; i < dense.map.size(); ++i) {
      const MapLandmark& a = compressed.map[i];
      const MapLandmark& b = dense.map[i];
      ASSERT_EQ(a.id, b.id);
      EXPECT_LT((a.p_world - b.p_world).norm(), 1e-8 * b.p_world.norm()) << chart.name;
      EXPECT_LT((a.covariance - b.covariance).norm(), 1e-8 * b.covariance.norm()) << chart.name;
    }
  }
}

// KITTI's velocities are along level axes; the files state the vehicle's axes (docs/noise.md).
TEST_F(RealRecording, LevelVelocitiesAreFoundAndWorthHalfOfTheErrors) {
  const Recording drive = read(k2018_0020);
  VelocitySlamSettings own;
  own.velocity_axes = VelocityAxes::kImu;
  const auto errors = [&](const VelocitySlamSettings& settings) {
    return evaluated(drive, run(drive, settings).estimates, PoseError::kWorldTwist);
  };
  const Evaluation level = errors({}), taken_as_own = errors(own);
  EXPECT_LT(figure(level, "ate_m"), 0.5 * figure(taken_as_own, "ate_m"));
  EXPECT_LT(figure(level, "rpe_100m_percent"), 0.7 * figure(taken_as_own, "rpe_100m_percent"));
  EXPECT_LT(figure(level, "attitude_deg"), figure(taken_as_own, "attitude_deg"));
  const Recording hand_held = read(kStarryNight);
  EXPECT_FALSE(choose_noise({}, hand_held.velocities, hand_held.frames, {}).level_velocities);
}

}  // namespace
}  // namespace chasles
