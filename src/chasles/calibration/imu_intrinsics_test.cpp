#include <cmath>

#include <fmt/format.h>

#include <chasles/calibration/imu_intrinsics.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

std::string rows_of(const Eigen::Matrix3d& M, const std::string& indent) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{}- [{}, {}, {}]\n", indent, M(i, 0), M(i, 1), M(i, 2));
  }
  return text;
}

// An IMU whose axes are scaled, skewed and turned, and whose gyroscope feels the force.
struct Imu {
  Eigen::Matrix3d force_scale, rate_scale, of_force;
  Eigen::Matrix3d gyro_R_imu = so3::exp({0.02, -0.03, 0.01});
  Eigen::Matrix3d acc_R_imu = so3::exp({-0.01, 0.02, 0.03});

  Imu() {
    force_scale << 1.02, 0, 0, 0.01, 0.97, 0, -0.02, 0.005, 1.05;
    rate_scale << 0.98, 0, 0, -0.01, 1.03, 0, 0.02, 0.004, 1.01;
    of_force << 1e-3, 2e-4, -3e-4, 4e-4, -5e-4, 6e-4, 7e-4, 8e-4, -9e-4;
  }
  // The models are Kalibr's and OpenVINS's documents'.
  ImuSample by_kalibr(const ImuSample& t) const {
    return {.time = t.time,
            .specific_force_imu = force_scale * t.specific_force_imu,
            .angular_rate_imu = rate_scale * gyro_R_imu * t.angular_rate_imu +
                                of_force * gyro_R_imu * t.specific_force_imu};
  }
  ImuSample by_openvins(const ImuSample& t) const {
    return {.time = t.time,
            .specific_force_imu = force_scale * acc_R_imu * t.specific_force_imu,
            .angular_rate_imu =
                rate_scale * gyro_R_imu * t.angular_rate_imu + of_force * t.specific_force_imu};
  }
  std::string kalibr_text() const {
    return "model: scale-misalignment\naccelerometers:\n  M:\n" + rows_of(force_scale, "  ") +
           "gyroscopes:\n  M:\n" + rows_of(rate_scale, "  ") + "  A:\n" + rows_of(of_force, "  ") +
           "  C_gyro_i:\n" + rows_of(gyro_R_imu, "  ");
  }
  std::string openvins_text() const {
    return "model: calibrated\nTa:\n" + rows_of(force_scale, "  ") + "R_IMUtoACC:\n" +
           rows_of(acc_R_imu, "  ") + "Tw:\n" + rows_of(rate_scale, "  ") + "R_IMUtoGYRO:\n" +
           rows_of(gyro_R_imu, "  ") + "Tg:\n" + rows_of(of_force, "  ");
  }
};

std::vector<ImuSample> true_samples() {
  std::vector<ImuSample> samples;
  for (int k = 0; k < 20; ++k) {
    samples.push_back({.time = std::chrono::milliseconds(5 * k),
                       .specific_force_imu = {std::sin(k), std::cos(2 * k), 9.8 + 0.1 * k},
                       .angular_rate_imu = {0.1 * k, std::cos(k), std::sin(3 * k)}});
  }
  return samples;
}

class ImuIntrinsicsOfAFile : public ::testing::Test {
 protected:
  std::optional<ImuIntrinsics> read(const std::string& text) {
    const auto file = test::scratch() / "imu.yaml";
    test::spill(file, text);
    return read_imu_intrinsics(YamlMap::read(file, {}), recording.remarks);
  }
  // The largest error of the corrected samples.
  double error_of_corrected(const std::vector<ImuSample>& truth) const {
    double error = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      error = std::max({error,
                        (recording.imu[k].specific_force_imu - truth[k].specific_force_imu).norm(),
                        (recording.imu[k].angular_rate_imu - truth[k].angular_rate_imu).norm()});
    }
    return error;
  }
  Recording recording;
  const Imu imu;
};

TEST_F(ImuIntrinsicsOfAFile, GiveBackTheTruthByKalibrsModel) {
  const std::vector<ImuSample> truth = true_samples();
  for (const ImuSample& sample : truth) recording.imu.push_back(imu.by_kalibr(sample));
  EXPECT_GT(error_of_corrected(truth), 0.1);
  correct_samples(read(imu.kalibr_text()).value(), recording);
  EXPECT_LT(error_of_corrected(truth), 1e-12);
  ASSERT_EQ(recording.remarks.size(), 1u);
  expect_parts(recording.remarks[0], {"accelerometer by up to 4.76 %"});
}

TEST_F(ImuIntrinsicsOfAFile, GiveBackTheTruthByOpenVinssModel) {
  const std::vector<ImuSample> truth = true_samples();
  for (const ImuSample& sample : truth) recording.imu.push_back(imu.by_openvins(sample));
  correct_samples(read(imu.openvins_text()).value(), recording);
  EXPECT_LT(error_of_corrected(truth), 1e-12);
}

TEST_F(ImuIntrinsicsOfAFile, AreNoneWhereTheyAreTheIdentity) {
  EXPECT_FALSE(read("update_rate: 200\n"));
  const std::string one = rows_of(Eigen::Matrix3d::Identity(), "  ");
  EXPECT_FALSE(read("Ta:\n" + one + "Tw:\n" + one + "R_IMUtoGYRO:\n" + one + "R_IMUtoACC:\n" + one +
                    "Tg:\n" + rows_of(Eigen::Matrix3d::Zero(), "  ")));
  EXPECT_TRUE(recording.remarks.empty());
  EXPECT_FALSE(read("accelerometers:\n  M:\n" + one +
                    "  rx_i: [0, 0, 0]\n  ry_i: [0, 0.003, 0.004]\n  rz_i: [0, 0, 0]\n"));
  ASSERT_EQ(recording.remarks.size(), 1u);
  expect_parts(recording.remarks[0], {"lever arms", "5.0 mm", "not applied"});
}

// A range of 20 m/s^2 and scales of 0.8 and 1.2: one value crosses the range by the correction
// alone, and one falls below it.
TEST_F(ImuIntrinsicsOfAFile, LeaveTheSaturationToWhatTheSensorMeasured) {
  recording.imu_range.accelerometer = 20;
  recording.imu = {{.time = Time(0), .specific_force_imu = {19, 0, 0}},
                   {.time = Time(1), .specific_force_imu = {0, 20, 0}},
                   {.time = Time(2), .specific_force_imu = {0, -19.9, 0}}};
  correct_samples(read("accelerometers:\n  M: [[0.8, 0, 0], [0, 1.25, 0], [0, 0, 1]]\n").value(),
                  recording);
  EXPECT_NEAR(recording.imu[0].specific_force_imu.x(), 23.75, 1e-12);
  EXPECT_FALSE(recording.imu[0].force_clipped);
  EXPECT_TRUE(recording.imu[1].force_clipped);
  EXPECT_FALSE(recording.imu[1].rate_clipped);
  EXPECT_EQ(count_saturated(recording.imu, range_of(recording)), 1u);
  EXPECT_LT(range_of(recording).accelerometer, 26);
}

TEST_F(ImuIntrinsicsOfAFile, ThatCannotBeAreRejected) {
  const auto error = [&](const std::string& text) { return input_error([&] { read(text); }); };
  expect_parts(error("Ta: [[1, 0, 0], [0, 0, 0], [0, 0, 1]]\n"),
               {"imu.yaml:1: key 'Ta'", "determinant 0"});
  expect_parts(error("Tw: [[1, 0, 0], [0, -1, 0], [0, 0, 1]]\n"), {"'Tw'", "determinant -1"});
  expect_parts(error("Tw: [[1, 0, 0], [0, 1, 0]]\n"), {"'Tw'", "3 rows of 3 numbers"});
  expect_parts(error("Tg: [[1, 0, 0], [0, .inf, 0], [0, 0, 1]]\n"), {"'Tg'", "inf"});
  expect_parts(error("R_IMUtoGYRO: [[1, 0, 0], [0, 2, 0], [0, 0, 1]]\n"),
               {"'R_IMUtoGYRO'", "rotation"});
  expect_parts(error("gyroscopes:\n  M: 3\n"), {"imu.yaml:2", "'M'"});
}

// OpenVINS's Tg is zero without g-sensitivity; people write the identity, as for the scales.
TEST(ImuIntrinsics, AnIdentityAsSensitivityIsRejectedByItsName) {
  const auto file = test::scratch() / "imu.yaml";
  const auto rejected = [&](const std::string& text) {
    test::spill(file, text);
    std::vector<std::string> remarks;
    return input_error([&] { read_imu_intrinsics(YamlMap::read(file, {}), remarks); });
  };
  expect_parts(rejected("Tg:\n" + rows_of(Eigen::Matrix3d::Identity(), "  ")),
               {"imu.yaml:2: key 'Tg'", "row 1, column 1 is 1", "the identity: write zeros"});
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  A(1, 2) = -0.3;
  expect_parts(rejected("gyroscopes:\n  A:\n" + rows_of(A, "    ")),
               {"key 'A'", "row 2, column 3 is -0.3", "at most 0.1"});
}

}  // namespace
}  // namespace chasles
