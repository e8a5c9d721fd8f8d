#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/check/camera_fit.hpp>
#include <chasles/check/other_axes.hpp>

namespace chasles {
namespace {

constexpr double kAligned = 0.985;               // cosine of 10 degrees
constexpr double kUncertainTurn = 2 * kRadians;  // of the camera's rotation

void append(std::string& list, std::string_view sign, Eigen::Index axis) {
  list += fmt::format("{}{}{}", list.empty() ? "" : ", ", sign, "xyz"[axis]);
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
  const OtherAxes axes{
      .signs = fit.signs,
      .imu_R_stated = nearest_turn(fit.gyroscope->cam_R_imu.transpose() * camera.cam_T_imu.R)};
  if (!axes.has_signs() && !axes.has_turn()) return std::nullopt;
  return axes;
}

void take_axes(const OtherAxes& axes, std::vector<ImuSample>& imu, std::vector<Camera>& cameras) {
  for (ImuSample& sample : imu) {
    sample.angular_rate_imu = axes.signs.cwiseProduct(sample.angular_rate_imu);
  }
  for (Camera& camera : cameras) {
    camera.cam_T_imu.R = camera.cam_T_imu.R * axes.imu_R_stated.transpose();
  }
}

}  // namespace chasles
