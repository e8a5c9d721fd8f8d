#include <cmath>
#include <optional>

#include <chasles/filter/ekf.hpp>

// The change of scale in an update (docs/filter.md, section 3).

namespace chasles {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector = Eigen::Ref<VectorXd>;

// Direction in the error state that pixels do not see: d/ds at s = 0 if all distances are scaled by
// e^s about the world's origin. No pixel depends on the velocity, so its error is no part of it.
void scale_direction(const State& x, Vector s) {
  s.setZero();
  s.segment<3>(3) = x.world_T_imu.p;
  for (const Clone& clone : x.clones) s.segment<3>(clone.row + 3) = clone.world_T_imu.p;
  for (const Landmark& landmark : x.landmarks) {
    if (landmark.anchor) {
      s[landmark.row + 2] = -landmark.inverse_depth.z();
    } else {
      s.segment<3>(landmark.row) = landmark.p_world;
    }
  }
}

// c with c^T error = an error of scale: the mean of the landmarks' relative errors of distance from
// the IMU, or of depth, weighted by their variances. False if no landmark is accurate enough for
// its error to be an error of scale.
bool scale_functional(const SE3& world_T_imu, std::span<const Landmark> landmarks,
                      const Covariance& covariance, Vector c) {
  // Of the relative error. The error of an assumed depth may be several times the depth. Simulated
  // flights had a NEES per degree of freedom of 2.3 without a limit, 1.5 with 0.3, and 1.2 with
  // 0.1, which is the value without keep_scale.
  constexpr double kMostVariance = 0.1 * 0.1;
  const auto P = covariance.all();
  c.setZero();
  double sum = 0;
  for (const Landmark& landmark : landmarks) {
    const int row = landmark.row;
    if (landmark.anchor) {
      const double w = landmark.inverse_depth.z();
      const double variance = P(row + 2, row + 2) / (w * w);
      if (!(variance < kMostVariance)) continue;
      c[row + 2] = -1 / (w * variance);
      sum += 1 / variance;
    } else {
      const Vector3d from_imu = landmark.p_world - world_T_imu.p;
      const Vector3d d = from_imu / from_imu.squaredNorm();
      const Eigen::Matrix3d own = P.block<3, 3>(row, row).selfadjointView<Eigen::Lower>();
      const Eigen::Matrix3d imu = P.block<3, 3>(3, 3).selfadjointView<Eigen::Lower>();
      const double variance =
          d.dot(own * d) + d.dot(imu * d) - 2 * d.dot(P.block<3, 3>(row, 3) * d);
      if (!(variance > 0 && variance < kMostVariance)) continue;
      c.segment<3>(row) = d / variance;
      c.segment<3>(3) -= d / variance;
      sum += 1 / variance;
    }
  }
  if (sum > 0) c /= sum;
  return sum > 0;
}

}  // namespace

std::optional<VectorXd> Ekf::scale_error(std::span<const Landmark> landmarks) const {
  VectorXd c(covariance_.size());
  if (!scale_functional(state_.world_T_imu, landmarks, covariance_, c)) return std::nullopt;
  return c;
}

std::optional<double> Ekf::scale_sigma() const {
  if (!keep_scale_) return std::nullopt;
  const auto P = covariance_.all();
  auto c = work_.xi.take<VectorXd>(P.rows());
  if (!scale_functional(state_.world_T_imu, state_.landmarks, covariance_, c)) return std::nullopt;
  auto Pc = work_.other.take<VectorXd>(P.rows());
  Pc.noalias() = P * c;
  return std::sqrt(c.dot(Pc));
}

// A = I + by c^T with by = s(x+) - s(x): an error along s(x), unobservable to the pixels so far,
// becomes one along s(x+), unobservable to later pixels. False where no scale is known.
bool Ekf::change_of_scale(const State& before, Vector by, Vector c) const {
  if (!scale_functional(before.world_T_imu, before.landmarks, covariance_, c)) return false;
  auto s = work_.xi.take<VectorXd>(c.size());
  scale_direction(before, s);
  scale_direction(state_, by);
  by -= s;
  return true;
}

}  // namespace chasles
