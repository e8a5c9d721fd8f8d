#include <algorithm>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/floors_detail.hpp>
#include <chasles/smooth/terms/imu_link.hpp>

namespace chasles {
namespace {

// The noise of a few samples does not span pose and velocity: position and velocity would be tied
// exactly. An interval is therefore divided; its noise is white within it.
constexpr std::size_t kManyIntervals = 6;
constexpr int kPieces = 6;

std::vector<ImuInterval> cut(const std::vector<ImuInterval>& intervals) {
  std::vector<ImuInterval> pieces;
  for (ImuInterval interval : intervals) {
    interval.tau /= kPieces;
    pieces.insert(pieces.end(), kPieces, interval);
  }
  return pieces;
}

// Rows [rotation, position, velocity] of the residual in the earlier keyframe's axes.
struct Moved {
  Eigen::Vector3d phi, u, w;  // rotation; changes of position and velocity beyond inertia, world
};

}  // namespace

Matrix15d link_covariance(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                          const ImuNoise& noise) {
  InertialState state;
  state.accelerometer_bias = biases.head<3>();
  state.gyroscope_bias = biases.tail<3>();
  Matrix15d P = Matrix15d::Zero();
  for (const ImuInterval& interval : intervals) {
    const StrapdownStep step = strapdown(state, interval, Eigen::Vector3d::Zero(), noise);
    P = (step.F * P * step.F.transpose() + step.Q).eval();
    state = step.state;
  }
  return (P + P.transpose()) / 2;
}

ImuLink imu_link(std::vector<ImuInterval> intervals, const Vector6d& biases,
                 const ImuNoise& noise) {
  ImuNoise used = noise;
  used.accelerometer_random_walk =
      std::max(used.accelerometer_random_walk, smooth_detail::kLeastWalk);
  used.gyroscope_random_walk = std::max(used.gyroscope_random_walk, smooth_detail::kLeastWalk);
  const bool few = intervals.size() < kManyIntervals;
  const Matrix15d P = link_covariance(few ? cut(intervals) : intervals, biases, used);
  const bool noisy = noise.accelerometer_noise_density > 0 && noise.gyroscope_noise_density > 0;
  const std::optional<Eigen::MatrixXd> whitening = whitening_of(P);
  if (!noisy || !whitening) {
    throw InputError(
        "the IMU's noise has no invertible covariance between two frames: expected "
        "accelerometer_noise_density and gyroscope_noise_density above 0 and finite samples; state "
        "the sensor's noise in the recording's calibration");
  }
  return {.intervals = std::move(intervals), .whitening = *whitening};
}

Vector15d link_residual(const ImuLink& link, const InertialState& now, const InertialState& next,
                        const Eigen::Vector3d& gravity, LinkDerivatives* derivatives) {
  const Preintegration p = preintegrate(link.intervals, now.biases(), ImuNoise{});
  const Eigen::Matrix3d Rt = now.world_T_imu.R.transpose();
  const double t = p.seconds;
  const Moved m{.phi = so3::log(Rt * next.world_T_imu.R * p.delta.world_T_imu.R.transpose()),
                .u = next.world_T_imu.p - now.world_T_imu.p - t * now.v_world - t * t / 2 * gravity,
                .w = next.v_world - now.v_world - t * gravity};
  Vector15d r;
  r << m.phi, Rt * m.u - p.delta.world_T_imu.p, Rt * m.w - p.delta.v_world,
      next.biases() - now.biases();
  if (derivatives != nullptr) {
    Matrix15d J = Matrix15d::Zero();
    J.block<3, 3>(0, 0) = -so3::left_jacobian_inverse(m.phi) * Rt;
    J.block<3, 3>(3, 0) = Rt * hat(m.u);
    J.block<3, 3>(3, 3) = -Rt;
    J.block<3, 3>(3, 6) = -t * Rt;
    J.block<3, 3>(6, 0) = Rt * hat(m.w);
    J.block<3, 3>(6, 6) = -Rt;
    J.block<9, 6>(0, 9) = -p.d_bias;
    J.block<3, 6>(0, 9) = -so3::right_jacobian_inverse(m.phi) * p.d_bias.topRows<3>();
    J.block<6, 6>(9, 9) = -Matrix6d::Identity();
    derivatives->now.noalias() = link.whitening * J;
    J.setZero();
    J.block<3, 3>(0, 0) = so3::left_jacobian_inverse(m.phi) * Rt;
    J.block<3, 3>(3, 3) = Rt;
    J.block<3, 3>(6, 6) = Rt;
    J.block<6, 6>(9, 9).setIdentity();
    derivatives->next.noalias() = link.whitening * J;
  }
  return link.whitening * r;
}

ImuLink corrected(const ImuCorrection& imu, const ImuLink& measured) {
  ImuLink link = measured;
  for (ImuInterval& interval : link.intervals) interval = corrected(imu, interval);
  return link;
}

LinkByImu link_by_imu(const ImuLink& measured, const ImuCorrection& imu, const InertialState& now,
                      const InertialState& next) {
  InertialState delta;
  delta.accelerometer_bias = now.accelerometer_bias;
  delta.gyroscope_bias = now.gyroscope_bias;
  LinkByImu d = LinkByImu::Zero(15, imu.size());
  for (const ImuInterval& interval : measured.intervals) {
    const StrapdownStep step =
        strapdown(delta, corrected(imu, interval), Eigen::Vector3d::Zero(), ImuNoise{});
    const auto by_sample = imu.derivative(interval.specific_force_imu, interval.angular_rate_imu);
    d.topRows<9>() =
        (step.F.topLeftCorner<9, 9>() * d.topRows<9>() - step.F.topRightCorner<9, 6>() * by_sample)
            .eval();
    delta = step.state;
  }
  const Eigen::Vector3d phi = so3::log(now.world_T_imu.R.transpose() * next.world_T_imu.R *
                                       delta.world_T_imu.R.transpose());
  d.topRows<3>() = (so3::right_jacobian_inverse(phi) * d.topRows<3>()).eval();
  return -(measured.whitening * d);
}

}  // namespace chasles
