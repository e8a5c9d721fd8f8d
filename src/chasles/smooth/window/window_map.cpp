#include <cmath>

#include <chasles/filter/dense.hpp>
#include <chasles/smooth/window/window_detail.hpp>

// Uncertainties from the factor of a window's last step.
namespace chasles::smooth_detail {

void update_axes(const Window& window, WindowPoint& point) {
  if (!point.camera) return;
  const auto& block = window.sizes.calibration.all()[point.extrinsics];
  point.cam_T_imu = point.camera->axes_T_imu(read_pose(window.calibration.data() + block.number));
}

void update_axes(Window& window) {
  for (auto& [number, point] : window.points) update_axes(window, point);
}

Landmark landmark_of(const WindowPoint& point) {
  Landmark landmark{.id = point.id};
  landmark.anchor = point.anchor;
  landmark.cam_T_imu = point.cam_T_imu;
  if (point.camera) landmark.imu_T_line = point.camera->imu_T_line;
  landmark.inverse_depth = point.parameters;
  return landmark;
}

Clone clone_of(const Window& window, int keyframe) {
  return {.id = keyframe, .world_T_imu = read_pose(window.keyframe(keyframe).motion.data())};
}

namespace {

// What considered errors add to the covariance of x: `by` its derivative by them with all other
// errors fixed, `whitened` L^-1 times the transposed one by the others, of the last rows.
Eigen::MatrixXd added(const Window& window, const WindowFactor& factor,
                      const Eigen::MatrixXd& whitened, Eigen::MatrixXd by) {
  by.noalias() -= whitened.transpose() * factor.by_considered.bottomRows(whitened.rows());
  return by * window.considered.covariance * by.transpose();
}

}  // namespace

Eigen::MatrixXd newest_covariance(const Window& window, const WindowFactor& factor,
                                  double covariance_factor) {
  const int n = window.sizes.errors();
  if (!factor.rows) return Eigen::MatrixXd::Constant(n, n, std::nan(""));
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(n, n);
  factor.L.bottomRightCorner(n, n).triangularView<Eigen::Lower>().solveInPlace(inverse);
  Eigen::MatrixXd P = covariance_factor * (inverse.transpose() * inverse);
  const auto considered = std::ssize(window.considered.rows);
  if (considered > 0) P += added(window, factor, inverse, Eigen::MatrixXd::Zero(n, considered));
  return P;
}

Eigen::MatrixXd calibration_covariance(const Window& window, const WindowFactor& factor) {
  const WindowRows& rows = *factor.rows;
  const int n = rows.calibration_errors, count = rows.size - rows.calibration;
  const std::vector<int>& considered = window.considered.rows;
  Eigen::MatrixXd C = Eigen::MatrixXd::Identity(count, n);
  Eigen::MatrixXd by_considered = Eigen::MatrixXd::Zero(n, std::ssize(considered));
  for (std::size_t i = 0; i < considered.size(); ++i) {
    C.col(considered[i]).setZero();
    by_considered(considered[i], static_cast<Eigen::Index>(i)) = 1;
  }
  dense::solve_lower(factor.L.bottomRightCorner(count, count), C);
  Eigen::MatrixXd P = C.transpose() * C;
  if (!considered.empty()) P += added(window, factor, C, by_considered);
  return P;
}

std::optional<WindowLandmark> map_landmark(const Window& window, const WindowFactor& factor,
                                           int number) {
  if (!factor.rows) return std::nullopt;
  const WindowPoint& point = window.points.at(number);
  const WindowRows& rows = *factor.rows;
  WindowLandmark result{.landmark = {.id = point.id,
                                     .p_world = point.parameters,
                                     .observations = point.observations}};
  MapLandmark& landmark = result.landmark;
  Eigen::Matrix3d by_point = Eigen::Matrix3d::Identity();
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(rows.size, 3);  // d p_world / d errors, transposed
  if (window.anchored) {
    if (!(point.parameters.z() > 0)) return std::nullopt;
    const Clone anchor = clone_of(window, point.anchor);
    const HomogeneousPoint at = homogeneous(anchor, landmark_of(point));
    landmark.p_world = at.p_world / at.w;
    const Eigen::Matrix<double, 3, 9> d = anchored_derivative(anchor, landmark_of(point));
    by_point = d.rightCols<3>();
    C.middleRows<6>(rows.keyframe(point.anchor)) = d.leftCols<6>().transpose();
    if (point.camera) {
      C.middleRows<6>(rows.calibration + extrinsics_row(window, point)) =
          anchored_derivative_by_camera(anchor, landmark_of(point)).transpose();
    }
  }
  landmark.covariance.setZero();
  if (point.in_prior) {
    C.middleRows<3>(rows.points.at(number)) = by_point.transpose();
  } else {
    const Eigen::Matrix3d by_information = by_point * point.linear.V_inverse;
    for (const PointLinear::PoseBlock& pose_block : point.linear.pose_blocks) {
      C.middleRows<6>(rows.keyframe(pose_block.keyframe)) -=
          pose_block.W * by_information.transpose();
    }
    if (rows.calibration_errors > 0) {
      C.middleRows(rows.calibration, rows.calibration_errors) -=
          point.linear.calibration.W * by_information.transpose();
    }
    landmark.covariance = by_information * by_point.transpose();
  }
  const std::vector<int>& considered = window.considered.rows;
  Eigen::MatrixXd by_considered(3, std::ssize(considered));
  for (std::size_t i = 0; i < considered.size(); ++i) {
    auto row = C.row(rows.calibration + considered[i]);
    by_considered.col(static_cast<Eigen::Index>(i)) = row.transpose();
    row.setZero();
  }
  // Rows above the first nonzero row stay zero.
  const int first = point.in_prior ? rows.points.at(number) : rows.calibration;
  const int count = rows.size - first;
  dense::solve_lower(factor.L.bottomRightCorner(count, count), C.bottomRows(count));
  landmark.covariance += C.bottomRows(count).transpose() * C.bottomRows(count);
  if (!considered.empty()) result.added = added(window, factor, C.bottomRows(count), by_considered);
  return result;
}

}  // namespace chasles::smooth_detail
