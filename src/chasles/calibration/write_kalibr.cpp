#include <array>

#include <Eigen/Dense>
#include <fmt/format.h>

#include <chasles/calibration/imu_range.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/calibration/writing.hpp>

namespace chasles {
namespace {

KalibrLens checked_kalibr_lens(const Camera& camera, std::size_t index) {
  Camera stated = camera;
  stated.coefficients = LensCoefficients(stated_coefficients(camera));
  const Distortion model = camera.distortion;
  constexpr std::size_t kMostOfRadtan = 4;
  const bool has = model != Distortion::kDivision && model != Distortion::kFisheye624 &&
                   (model != Distortion::kRadtan || stated.coefficients.size() <= kMostOfRadtan);
  if (has) return kalibr_lens(stated);
  no_such_lens(index, camera, "Kalibr",
               "none, radtan with 4 coefficients, equidistant, fov, ds, eucm or omni");
}

std::string topic_of(const CalibrationToWrite& calibration, std::size_t camera) {
  const auto& topics = calibration.camera_topics;
  return camera < topics.size() && !topics[camera].empty()
             ? topics[camera]
             : fmt::format("/cam{}/image_raw", camera);
}

std::string kalibr_camera(const CalibrationToWrite& calibration, std::size_t index) {
  const Camera& camera = calibration.cameras[index];
  const KalibrLens lens = checked_kalibr_lens(camera, index);
  std::string text = fmt::format("cam{}:\n", index);
  if (calibration.has_imu) text += "  T_cam_imu:\n" + pointed_motion(camera.cam_T_imu, "  ");
  if (index > 0) {
    const SE3 imu_T_before = calibration.cameras[index - 1].cam_T_imu.inverse();
    text += "  T_cn_cnm1:\n" + pointed_motion(camera.cam_T_imu * imu_T_before, "  ");
  }
  text += fmt::format(
      "  camera_model: {}\n  distortion_coeffs: {}\n  distortion_model: {}\n  intrinsics: {}\n"
      "  resolution: [{}, {}]\n  rostopic: {}\n",
      lens.camera_model, pointed_list(lens.coefficients), lens.distortion_model,
      pointed_list(lens.intrinsics), camera.width, camera.height, topic_of(calibration, index));
  if (calibration.has_imu) {
    text += fmt::format("  timeshift_cam_imu: {}\n", pointed(time_offset_of(calibration, index)));
  }
  return text + shutter_text(camera.shutter, "  ");
}

std::string matrix_rows(const Eigen::Matrix3d& M, const std::string& indent) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += indent + "- " + pointed_list(std::array{M(i, 0), M(i, 1), M(i, 2)}) + "\n";
  }
  return text;
}

// f_m = M f and w_m = M C w + A C f, with a lower triangular M of the gyroscope and a rotation C:
// the QR decomposition of the transposed matrix M C.
std::string intrinsics_text(const ImuIntrinsics& intrinsics, const std::string& indent) {
  const Eigen::Matrix3d M_C = intrinsics.rate.inverse();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(M_C.transpose());
  const Eigen::Matrix3d Q = qr.householderQ();
  const Eigen::Matrix3d R = qr.matrixQR().triangularView<Eigen::Upper>();
  const Eigen::Vector3d signs = R.diagonal().cwiseSign();
  const Eigen::Matrix3d M = R.transpose() * signs.asDiagonal();
  const Eigen::Matrix3d C = signs.asDiagonal() * Q.transpose();
  const Eigen::Matrix3d A = M_C * intrinsics.rate_of_force * C.transpose();
  const std::string deeper = indent + "  ";
  return indent + "model: scale-misalignment\n" + indent + "accelerometers:\n" + deeper + "M:\n" +
         matrix_rows(intrinsics.force.inverse(), deeper) + indent + "gyroscopes:\n" + deeper +
         "M:\n" + matrix_rows(M, deeper) + deeper + "A:\n" + matrix_rows(A, deeper) + deeper +
         "C_gyro_i:\n" + matrix_rows(C, deeper);
}

std::string noise_text(const CalibrationToWrite& calibration, const std::string& indent) {
  const ImuNoise& noise = *calibration.imu_noise;
  std::string text = fmt::format(
      "{0}accelerometer_noise_density: {1}\n{0}accelerometer_random_walk: {2}\n"
      "{0}gyroscope_noise_density: {3}\n{0}gyroscope_random_walk: {4}\n{0}rostopic: {5}\n",
      indent, pointed(noise.accelerometer_noise_density), pointed(noise.accelerometer_random_walk),
      pointed(noise.gyroscope_noise_density), pointed(noise.gyroscope_random_walk),
      calibration.imu_topic.empty() ? "/imu0" : calibration.imu_topic);
  if (calibration.imu_rate > 0) {
    text += fmt::format("{}update_rate: {}\n", indent, pointed(calibration.imu_rate));
  }
  return text + imu_range_text(calibration.imu_range, indent);
}

const char* const kChainRemark =
    "Kalibr's camera chain. T_cam_imu maps IMU coordinates to those of the camera [m], and "
    "T_cn_cnm1\n"
    "those of the camera before: p_cam = T_cam_imu * p_imu.\n"
    "timeshift_cam_imu [s]: clock of the IMU = clock of the camera + timeshift_cam_imu.\n"
    "Pixels: the centre of the first one is (0, 0).";
const char* const kImuRemark =
    "Kalibr's IMU. Noise densities are in continuous time: white noise [m/s^2/sqrt(Hz)] and\n"
    "[rad/s/sqrt(Hz)], and random walks of the biases [m/s^3/sqrt(Hz)] and [rad/s^2/sqrt(Hz)].";

// Kalibr's input has the noise at the top level, its result all below imu0.
CalibrationFile kalibr_imu(const CalibrationToWrite& calibration) {
  std::string text = as_comment(calibration, kImuRemark);
  if (!calibration.imu_intrinsics) return {"kalibr/imu.yaml", text + noise_text(calibration, "")};
  text += as_comment({},
                     "The samples f_m, w_m of the true f, w: f_m = M f, w_m = M C_gyro_i w + "
                     "A C_gyro_i f.");
  return {"kalibr/imu.yaml", text + "imu0:\n  T_i_b:\n" + pointed_motion({}, "  ") +
                                 "  time_offset: 0.0\n" + noise_text(calibration, "  ") +
                                 intrinsics_text(*calibration.imu_intrinsics, "  ")};
}

std::vector<std::string> left_out_of_kalibr(const CalibrationToWrite& calibration) {
  std::vector<std::string> left_out;
  if (!calibration.has_imu) return left_out;
  if (!calibration.imu_noise) {
    left_out.emplace_back(
        "Kalibr's imu.yaml is not written: the calibration states no noise of the IMU");
  } else if (!(calibration.imu_rate > 0)) {
    left_out.emplace_back(
        "Kalibr's imu.yaml has no update_rate, which its tools need: the rate of the IMU is not "
        "known");
  }
  if (!calibration.imu_intrinsics) return left_out;
  const ImuIntrinsics& intrinsics = *calibration.imu_intrinsics;
  if (!intrinsics.force_bias.isZero(0) || !intrinsics.rate_bias.isZero(0)) {
    left_out.push_back(fmt::format(
        "Kalibr's imu.yaml has no biases: those of {:.3g} m/s^2 and {:.3g} rad/s are left to the "
        "estimator",
        intrinsics.force_bias.norm(), intrinsics.rate_bias.norm()));
  }
  return left_out;
}

}  // namespace

CalibrationFiles kalibr_files(const CalibrationToWrite& calibration) {
  std::string chain = as_comment(calibration, kChainRemark);
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    chain += kalibr_camera(calibration, c);
  }
  CalibrationFiles result{
      .files = {{calibration.has_imu ? "kalibr/camchain-imucam.yaml" : "kalibr/camchain.yaml",
                 chain}},
      .left_out = left_out_of_kalibr(calibration)};
  if (calibration.has_imu && calibration.imu_noise) {
    result.files.push_back(kalibr_imu(calibration));
  }
  return result;
}

}  // namespace chasles
