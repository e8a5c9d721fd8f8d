#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/base/constants.hpp>
#include <chasles/eval/truth_tilt.hpp>

namespace chasles {
namespace {

constexpr double kRounding = 1e-6;  // [m], [rad]: six decimals of a file

// The rotation R that maximises trace(R^T M).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

bool begins_at_identity(const Trajectory& truth) {
  if (truth.empty()) return false;
  const SE3& first = truth.front().pose;
  return first.p.norm() <= kRounding && so3::log(first.R).norm() <= kRounding;
}

TruthTilt truth_tilt(const MatchedTrajectories& matched) {
  if (matched.truth.empty()) return {};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    sum += matched.truth[i].pose.R * matched.estimate[i].pose.R.transpose();
  }
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_truth = nearest_rotation(sum) * up;
  return {.level_R_truth = so3::between(up_truth, up),
          .degrees = kDegrees * std::atan2(up_truth.head<2>().norm(), up_truth.z())};
}

TruthTilt turn_to_level(Trajectory& truth, const Trajectory& estimate,
                        const TruthPairing& pairing) {
  TruthTilt tilt = truth_tilt(associate(estimate, truth, pairing));
  const SE3 level_T_truth{tilt.level_R_truth, Eigen::Vector3d::Zero()};
  for (StampedPose& row : truth) row.pose = level_T_truth * row.pose;
  return tilt;
}

}  // namespace chasles
