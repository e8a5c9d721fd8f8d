#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/imu_intrinsics.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles {
namespace {

constexpr double kLeastDeterminant = 1e-3;  // of a matrix of scales near 1
constexpr double kSame = 1e-12;

Eigen::Matrix3d matrix_or(const YamlMap& map, const std::string& key,
                          const Eigen::Matrix3d& otherwise) {
  return map.has(key) ? Eigen::Matrix3d(map.matrix(key, 3, 3)) : otherwise;
}

Eigen::Matrix3d rotation_or_identity(const YamlMap& map, const std::string& key) {
  if (!map.has(key)) return Eigen::Matrix3d::Identity();
  return checked_rotation(map.where(key), Eigen::Matrix3d(map.matrix(key, 3, 3)));
}

Eigen::Matrix3d inverse_of_scales(const YamlMap& map, const std::string& key) {
  const Eigen::Matrix3d M = matrix_or(map, key, Eigen::Matrix3d::Identity());
  if (M.determinant() >= kLeastDeterminant) return M.inverse();
  throw InputError(fmt::format("{}: has the determinant {:.3g}, expected scales near 1",
                               map.where(key), M.determinant()));
}

// The g-sensitivity, in rad/s for 1 m/s^2. Gyroscopes have some 1e-4; 0.1 would be 56 deg/s for g.
Eigen::Matrix3d sensitivity(const YamlMap& map, const std::string& key) {
  constexpr double kMost = 0.1;
  const Eigen::Matrix3d M = matrix_or(map, key, Eigen::Matrix3d::Zero());
  for (int i = 0; i < 9; ++i) {
    if (std::abs(M(i / 3, i % 3)) <= kMost) continue;
    throw InputError(fmt::format(
        "{}: its entry in row {}, column {} is {:g}, expected at most {}: it is what 1 m/s^2 adds "
        "to the gyroscope, in rad/s. {}",
        map.where(key), i / 3 + 1, i % 3 + 1, M(i / 3, i % 3), kMost,
        M.isIdentity(0) ? "It is the identity: write zeros, which mean none"
                        : "Write zeros where it is not known"));
  }
  return M;
}

// The distances of the accelerometer's axes from the origin of the IMU.
void remark_on_lever_arms(const YamlMap& accelerometers, std::vector<std::string>& remarks) {
  double longest = 0;
  for (const char* key : {"rx_i", "ry_i", "rz_i"}) {
    if (!accelerometers.has(key)) continue;
    longest = std::max(longest, accelerometers.numbers(key, 3, "numbers [m]").norm());
  }
  if (longest == 0) return;
  remarks.push_back(fmt::format(
      "the lever arms of the accelerometer's axes (rx_i, ry_i, rz_i: up to {:.1f} mm) are not "
      "applied",
      1e3 * longest));
}

ImuIntrinsics of_kalibr(const YamlMap& map, std::vector<std::string>& remarks) {
  ImuIntrinsics result;
  if (map.has("accelerometers")) {
    const YamlMap sensor = map.map("accelerometers", {});
    result.force = inverse_of_scales(sensor, "M");
    remark_on_lever_arms(sensor, remarks);
  }
  if (!map.has("gyroscopes")) return result;
  const YamlMap sensor = map.map("gyroscopes", {});
  const Eigen::Matrix3d gyro_R_imu = rotation_or_identity(sensor, "C_gyro_i");
  const Eigen::Matrix3d of_force = sensitivity(sensor, "A");
  result.rate = gyro_R_imu.transpose() * inverse_of_scales(sensor, "M");
  result.rate_of_force = result.rate * of_force * gyro_R_imu;
  return result;
}

ImuIntrinsics of_openvins(const YamlMap& map) {
  ImuIntrinsics result;
  result.force = rotation_or_identity(map, "R_IMUtoACC").transpose() * inverse_of_scales(map, "Ta");
  result.rate = rotation_or_identity(map, "R_IMUtoGYRO").transpose() * inverse_of_scales(map, "Tw");
  result.rate_of_force = result.rate * sensitivity(map, "Tg");
  return result;
}

// A value that M cannot make of values below `range`, plus what `more` adds to it.
double raised(double range, const Eigen::Matrix3d& M, double more) {
  return std::isfinite(range) ? M.cwiseAbs().rowwise().sum().maxCoeff() * range + more : range;
}

}  // namespace

std::optional<ImuIntrinsics> read_imu_intrinsics(const YamlMap& map,
                                                 std::vector<std::string>& remarks) {
  const bool kalibr = map.has("accelerometers") || map.has("gyroscopes");
  const ImuIntrinsics result = kalibr ? of_kalibr(map, remarks) : of_openvins(map);
  if (result.force.isIdentity(kSame) && result.rate.isIdentity(kSame) &&
      result.rate_of_force.isZero(kSame)) {
    return std::nullopt;
  }
  return result;
}

ImuSample corrected(const ImuIntrinsics& intrinsics, const ImuRange& measured, ImuSample s) {
  const auto at_limit = [](const Eigen::Vector3d& value, double range) {
    return value.cwiseAbs().maxCoeff() >= range;
  };
  s.force_clipped = s.force_clipped || at_limit(s.specific_force_imu, measured.accelerometer);
  s.rate_clipped = s.rate_clipped || at_limit(s.angular_rate_imu, measured.gyroscope);
  s.specific_force_imu = intrinsics.force * s.specific_force_imu;
  if (!intrinsics.force_bias.isZero(0)) s.specific_force_imu -= intrinsics.force_bias;
  const Eigen::Vector3d of_force = intrinsics.rate_of_force * s.specific_force_imu;
  s.angular_rate_imu = intrinsics.rate * s.angular_rate_imu - of_force;
  if (!intrinsics.rate_bias.isZero(0)) s.angular_rate_imu -= intrinsics.rate_bias;
  return s;
}

ImuRange corrected_range(const ImuIntrinsics& intrinsics, const ImuRange& measured,
                         double force_on_rate) {
  const double force_bias = intrinsics.force_bias.cwiseAbs().maxCoeff(),
               rate_bias = intrinsics.rate_bias.cwiseAbs().maxCoeff();
  return {.accelerometer = raised(measured.accelerometer, intrinsics.force, force_bias),
          .gyroscope = raised(measured.gyroscope, intrinsics.rate, force_on_rate + rate_bias)};
}

}  // namespace chasles
