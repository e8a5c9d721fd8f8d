#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/check/camera_fit.hpp>
#include <chasles/check/other_axes.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kAligned = 0.985;               // cosine of 10 degrees
constexpr double kUncertainTurn = 2 * kRadians;  // of the camera's rotation

void append(std::string& list, std::string_view sign, Eigen::Index axis) {
  list += fmt::format("{}{}{}", list.empty() ? "" : ", ", sign, "xyz"[axis]);
}

constexpr double kMean = 1, kBlock = 10;  // of forces; over which the gyroscope is integrated [s]
constexpr double kMostScatter = 0.25;     // of the means, over gravity
constexpr double kClearly = 0.9;          // less than where both are turned, which is more common

// The scatter of the specific force in axes that the gyroscope keeps, over gravity: root mean
// square of the means of a second about those of ten. `rates`: applied to the angular rates.
double scatter_of_gravity(const std::vector<ImuSample>& imu, const Eigen::Matrix3d& rates) {
  double squares = 0, count = 0;
  std::size_t i = 0;
  while (i < imu.size()) {
    const Time begin = imu[i].time;
    Eigen::Matrix3d start_R_imu = Eigen::Matrix3d::Identity();
    std::vector<Eigen::Vector3d> means;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), all = Eigen::Vector3d::Zero();
    double samples = 0;
    for (; i < imu.size() && to_seconds(imu[i].time - begin) < kBlock; ++i) {
      if (to_seconds(imu[i].time - begin) >= kMean * static_cast<double>(means.size() + 1)) {
        if (samples > 0) means.emplace_back(sum / samples);
        if (samples == 0) break;  // a gap: the block ends
        sum.setZero();
        samples = 0;
      }
      if (!imu[i].specific_force_imu.allFinite() || !imu[i].angular_rate_imu.allFinite()) continue;
      sum += start_R_imu * imu[i].specific_force_imu;
      ++samples;
      if (i + 1 == imu.size()) continue;
      const double tau = to_seconds(imu[i + 1].time - imu[i].time);
      start_R_imu = start_R_imu * so3::exp(rates * imu[i].angular_rate_imu * tau);
    }
    for (const Eigen::Vector3d& mean : means) all += mean / static_cast<double>(means.size());
    for (const Eigen::Vector3d& mean : means) squares += (mean - all).squaredNorm();
    count += static_cast<double>(means.size());
    if (samples == 0) ++i;
  }
  return count > 0 ? std::sqrt(squares / count) / kStandardGravity : 0;
}

// The turn onto other axes that is within 10 degrees of a rotation; the identity if none is.
Eigen::Matrix3d nearest_turn(const Eigen::Matrix3d& R) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    Eigen::Index at = 0;
    if (R.col(i).cwiseAbs().maxCoeff(&at) < kAligned) return Eigen::Matrix3d::Identity();
    turn(at, i) = R(at, i) < 0 ? -1 : 1;
  }
  return turn;
}

}  // namespace

std::string OtherAxes::mirrored() const {
  std::string axes;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (signs[i] < 0) append(axes, "", i);
  }
  return axes;
}

std::string OtherAxes::turned() const {
  std::string axes;
  for (Eigen::Index i = 0; i < 3; ++i) {
    Eigen::Index at = 0;
    imu_R_stated.col(i).cwiseAbs().maxCoeff(&at);
    append(axes, imu_R_stated(at, i) < 0 ? "-" : "", at);
  }
  return axes;
}

std::optional<OtherAxes> other_axes(const CameraFit& fit, const Camera& camera) {
  if (!fit.agrees() || fit.gyroscope->mirrored) return std::nullopt;
  if (fit.gyroscope->rotation_sigma > kUncertainTurn) return std::nullopt;
  const Eigen::Matrix3d imu_R_stated = fit.gyroscope->cam_R_imu.transpose() * camera.cam_T_imu.R;
  OtherAxes axes{.signs = fit.signs, .imu_R_stated = nearest_turn(imu_R_stated)};
  axes.rest = so3::log(axes.imu_R_stated.transpose() * imu_R_stated).norm();
  if (!axes.has_signs() && !axes.has_turn()) return std::nullopt;
  return axes;
}

std::optional<OtherAxes> agreeing_with_gravity(OtherAxes axes, const std::vector<ImuSample>& imu) {
  const Eigen::Matrix3d stated_R_imu = axes.imu_R_stated.transpose();
  const double alone = scatter_of_gravity(imu, stated_R_imu * axes.signs.asDiagonal());
  if (axes.has_signs()) {
    axes.of_gyroscope = true;
    return alone < kMostScatter ? std::optional(axes) : std::nullopt;
  }
  // A turn of both leaves them as they agree.
  const double both = scatter_of_gravity(imu, Eigen::Matrix3d::Identity());
  axes.of_gyroscope = alone < kClearly * both;
  return std::min(alone, both) < kMostScatter ? std::optional(axes) : std::nullopt;
}

void take_axes(const OtherAxes& axes, std::vector<ImuSample>& imu) {
  const Eigen::Matrix3d stated_R_imu = axes.imu_R_stated.transpose();
  for (ImuSample& sample : imu) {
    sample.angular_rate_imu = stated_R_imu * axes.signs.cwiseProduct(sample.angular_rate_imu);
    if (!axes.of_gyroscope) sample.specific_force_imu = stated_R_imu * sample.specific_force_imu;
  }
}

}  // namespace chasles
