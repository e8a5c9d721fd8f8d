#include <chasles/recording/extrinsics.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

// The real recordings. The expected figures are from shared/data/README.md, or were counted with
// numpy.
namespace chasles {
namespace {

struct Expected {
  const char* file;
  std::size_t frames, observations, stale, not_positive;
};

class RealRecording : public ::testing::TestWithParam<Expected> {};

std::size_t count(const Recording& r) {
  std::size_t sum = 0;
  for (const FeatureFrame& frame : r.frames) sum += frame.observations.size();
  return sum;
}

std::string all_remarks(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string test_name(std::string name) {
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

TEST_P(RealRecording, IsReadWithEveryTrapHandled) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Expected& expected = GetParam();
  const Recording r = read_recording(*folder / expected.file);
  EXPECT_EQ(r.frames.size(), expected.frames);
  EXPECT_EQ(r.velocities.size(), expected.frames);
  const std::string remarks = all_remarks(r.remarks);
  EXPECT_EQ(count(r), expected.observations - expected.stale - expected.not_positive) << remarks;
  // On every car the camera is 1.1 m in front of the IMU, 0.3 m right of it and 0.7 m above it.
  const Eigen::Vector3d p_imu = r.rig.cam0_T_imu.inverse() * Eigen::Vector3d::Zero();
  EXPECT_LT((p_imu - Eigen::Vector3d(1.1, -0.3, 0.73)).norm(), 0.06) << remarks;
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    EXPECT_EQ(r.frames[k].time, r.velocities[k].time);
    for (const StereoObservation& o : r.frames[k].observations) {
      EXPECT_GT(o.pixels[0] - o.pixels[2], 0);
      EXPECT_GT(o.pixels.minCoeff(), 0);
    }
  }
}

TEST_P(RealRecording, NoLandmarkEverRepeatsItsPixels) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Recording r = read_recording(*folder / GetParam().file);
  std::map<LandmarkId, Eigen::Vector4d> before;
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    for (const StereoObservation& o : r.frames[k].observations) {
      const auto known = before.find(o.landmark);
      if (known != before.end()) {
        EXPECT_NE(known->second, o.pixels) << "frame " << k << ", landmark " << o.landmark;
      }
      before[o.landmark] = o.pixels;
    }
  }
}

TEST_P(RealRecording, SurvivesTheProjectsOwnFolder) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Recording r = read_recording(*folder / GetParam().file);
  const auto own = test::scratch();
  write_folder_recording(r, own);
  const Recording again = read_recording(own);
  EXPECT_EQ(again.name, r.name);
  EXPECT_EQ(again.remarks, r.remarks);
  EXPECT_EQ(again.truth.size(), r.truth.size());
  ASSERT_EQ(count(again), count(r));
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    EXPECT_EQ(again.velocities[k].linear_imu, r.velocities[k].linear_imu);
    EXPECT_EQ(again.frames[k].time, r.frames[k].time);
    for (std::size_t i = 0; i < r.frames[k].observations.size(); ++i) {
      EXPECT_EQ(again.frames[k].observations[i].pixels, r.frames[k].observations[i].pixels);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kitti, RealRecording,
    ::testing::Values(Expected{"ece276a_2018/0020.npz", 1104, 3399, 364, 3},
                      Expected{"ece276a_2018/0027.npz", 1106, 3951, 225, 0},
                      Expected{"ece276a_2018/0042.npz", 500, 1859, 0, 120},
                      Expected{"ece276a_2020/0022.npz", 800, 58418, 3100, 93},
                      Expected{"ece276a_2020/0027.npz", 1106, 75647, 4196, 75},
                      Expected{"stars/2011_09_26_drive_0001_sync_KLT.mat", 108, 10501, 0, 22},
                      Expected{"stars/2011_09_26_drive_0005_sync_KLT.mat", 154, 13908, 0, 0},
                      Expected{"stars/2011_09_26_drive_0009_sync_KLT.mat", 446, 26708, 0, 34},
                      Expected{"stars/2011_09_26_drive_0027_sync_KLT.mat", 188, 12660, 0, 0},
                      Expected{"stars/2011_09_26_drive_0035_sync_KLT.mat", 131, 11588, 0, 0},
                      Expected{"stars/2011_09_26_drive_0036_sync_KLT.mat", 250, 17519, 0, 24},
                      Expected{"stars/2011_09_26_drive_0039_sync_KLT.mat", 300, 27602, 0, 5},
                      Expected{"stars/2011_09_30_drive_0027_sync_KLT.mat", 500, 44556, 0, 97},
                      Expected{"stars/2011_10_03_drive_0042_sync_KLT.mat", 500, 33678, 0, 1124}),
    [](const auto& tested) { return test_name(tested.param.file); });

TEST(RealRecordings, TheExtrinsicOfTheArchivesIsDecidedByTheirDataWhereTheyTurn) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  for (const char* file : {"2018/0020", "2018/0027", "2020/0022", "2020/0027"}) {
    const auto r = read_recording(*folder / (std::string("ece276a_") + file + ".npz"));
    EXPECT_EQ(all_remarks(r.remarks).find("do not decide"), std::string::npos)
        << all_remarks(r.remarks);
  }
  const auto r = read_recording(*folder / "ece276a_2018/0042.npz");
  EXPECT_NE(all_remarks(r.remarks).find("do not decide"), std::string::npos)
      << all_remarks(r.remarks);
}

void expect_truth(const Recording& r, const Trajectory& truth) {
  ASSERT_LE(r.truth.size(), truth.size());
  ASSERT_EQ(r.truth.size(), r.frames.size());
  for (std::size_t k = 0; k < r.truth.size(); ++k) {
    EXPECT_LT(std::abs(to_seconds(r.truth[k].time - truth[k].time)), 1e-6);
    EXPECT_LT((r.truth[k].pose.p - truth[k].pose.p).norm(), 2e-9);
    EXPECT_LT((r.truth[k].pose.R - truth[k].pose.R).norm(), 1e-8);
  }
}

TEST(RealRecordings, TheTruthOfAStarsFileIsThatOfTheGroundTruthFiles) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  for (const std::string drive : {"2011_09_26_drive_0009", "2011_09_30_drive_0027"}) {
    expect_truth(read_recording(*folder / "stars" / (drive + "_sync_KLT.mat")),
                 read_tum(*folder / "ground_truth" / ("stars_" + drive + "_gt_imu.tum")));
  }
}

TEST(RealRecordings, StarryNightHoldsTheTruthOfPosesAndLandmarks) {
  const auto folder = test::recordings();
  if (!folder) GTEST_SKIP() << "skipped: no recordings";
  const Recording r = read_recording(*folder / "stars/dataset3.mat");
  ASSERT_EQ(r.frames.size(), 1900u);
  EXPECT_EQ(r.true_landmarks.size(), 20u);
  EXPECT_EQ(count(r), 9410u) << "nothing is stale where the vehicle stands";
  expect_truth(r, read_tum(*folder / "ground_truth/starrynight_dataset3_gt_vehicle.tum"));
  // The true landmarks, projected from the true poses, agree with the observations: a median of a
  // few pixels.
  std::vector<double> errors;
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    for (const StereoObservation& o : r.frames[k].observations) {
      const auto& landmark = r.true_landmarks[static_cast<std::size_t>(o.landmark)].p_world;
      const auto seen = project(r.rig, r.rig.cam0_T_imu * (r.truth[k].pose.inverse() * landmark));
      errors.push_back(seen ? (seen->pixels - o.pixels).norm() : 1e9);
    }
  }
  std::nth_element(errors.begin(), errors.begin() + 4705, errors.end());
  EXPECT_LT(errors[4705], 20);
}

}  // namespace
}  // namespace chasles
