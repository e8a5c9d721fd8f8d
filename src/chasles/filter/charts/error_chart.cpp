#include <array>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

using MotionBlock = Eigen::Matrix<double, 9, 9>;

// A state that consists of a pose only.
State pose_only(const SE3& world_T_imu) {
  State x;
  x.world_T_imu = world_T_imu;
  return x;
}

// The calibration errors, the same in all charts. An anchored landmark uses the extrinsics of its
// camera.
void retract_calibration(State& x, const ErrorRef& xi) {
  for (std::size_t i = 0; i < x.imu_T_camera.size(); ++i) {
    const int row = *x.camera_row(static_cast<int>(i));
    SE3& imu_T_camera = x.imu_T_camera[i];
    imu_T_camera.R = so3::exp(xi.segment<3>(row)) * imu_T_camera.R;
    imu_T_camera.p += xi.segment<3>(row + 3);
  }
  if (x.time_offset) *x.time_offset += xi[x.time_offset_row()];
  for (std::size_t i = 0; i < x.intrinsics.size(); ++i) {
    const int row = *x.intrinsics_row(static_cast<int>(i));
    Intrinsics& one = x.intrinsics[i];
    if (one.has_readout) one.readout += xi[row + Intrinsics::kReadoutRow];
    if (!one.has_lens) continue;
    one.projection += xi.segment<4>(row);
    for (std::size_t k = 0; k < one.coefficients.size(); ++k) {
      one.coefficients[k] += xi[row + 6 + static_cast<int>(k)];
    }
  }
  if (x.imu) x.imu->add(xi.segment(x.imu_row(), x.imu->size()));
  for (Landmark& landmark : x.landmarks) {
    if (!landmark.anchor || !x.camera_row(landmark.camera)) continue;
    const SE3& imu_T_camera = x.imu_T_camera[static_cast<std::size_t>(landmark.camera)];
    landmark.cam_T_imu = face_T_imu(landmark.face, (landmark.imu_T_line * imu_T_camera).inverse());
  }
}

// One column, an error vector, needs no heap memory.
template <int Columns>
void push_columns(const ErrorChart& chart, const State& x,
                  Eigen::Ref<Eigen::Matrix<double, Eigen::Dynamic, Columns>> M) {
  if (chart.landmark_block) {
    for (const Landmark& landmark : x.landmarks) {
      if (landmark.anchor) continue;
      const Eigen::Matrix<double, 3, Columns> moved =
          chart.landmark_block(landmark.p_world) * M.template topRows<3>();
      M.template middleRows<3>(landmark.row) += moved;
    }
  }
  for (const Clone& clone : x.clones) {
    const Eigen::Matrix<double, 6, Columns> turned =
        pose_block(chart, clone.world_T_imu) * M.template middleRows<6>(clone.row);
    M.template middleRows<6>(clone.row) = turned;
  }
  const int n = x.motion_size();
  const MotionBlock T = chart.motion_block(x);
  const Eigen::Matrix<double, Eigen::Dynamic, Columns, 0, 9, Columns> motion =
      T.topLeftCorner(n, n) * M.topRows(n);
  M.topRows(n) = motion;
}

}  // namespace

std::span<const ErrorChart> error_charts() {
  static const std::array charts{kStandardChart, kLeftSe3Chart, kRightSe3Chart, kRightSen3Chart};
  return charts;
}

void retract(const ErrorChart& chart, State& x, const ErrorRef& xi) {
  chart.retract(x, xi);
  if (x.nav_T_world) {
    x.nav_T_world->R = so3::exp(xi.segment<3>(x.nav_row())) * x.nav_T_world->R;
    x.nav_T_world->p += xi.segment<3>(x.nav_row() + 3);
  }
  if (x.calibration_size() > 0) retract_calibration(x, xi);
  for (Clone& clone : x.clones) {
    State pose = pose_only(clone.world_T_imu);
    chart.retract(pose, xi.segment<6>(clone.row));
    clone.world_T_imu = pose.world_T_imu;
  }
}

Eigen::VectorXd local(const ErrorChart& chart, const State& x, const State& y) {
  Eigen::VectorXd xi = chart.local(x, y);
  if (x.nav_T_world) {
    xi.segment<3>(x.nav_row()) = so3::log(y.nav_T_world->R * x.nav_T_world->R.transpose());
    xi.segment<3>(x.nav_row() + 3) = y.nav_T_world->p - x.nav_T_world->p;
  }
  for (std::size_t i = 0; i < x.imu_T_camera.size(); ++i) {
    const int row = *x.camera_row(static_cast<int>(i));
    const SE3& from = x.imu_T_camera[i];
    xi.segment<3>(row) = so3::log(y.imu_T_camera[i].R * from.R.transpose());
    xi.segment<3>(row + 3) = y.imu_T_camera[i].p - from.p;
  }
  if (x.time_offset) xi[x.time_offset_row()] = *y.time_offset - *x.time_offset;
  for (std::size_t i = 0; i < x.intrinsics.size(); ++i) {
    const int row = *x.intrinsics_row(static_cast<int>(i));
    const Intrinsics &from = x.intrinsics[i], &to = y.intrinsics[i];
    xi.segment<4>(row) = to.projection - from.projection;
    xi[row + Intrinsics::kReadoutRow] = to.readout - from.readout;
    for (std::size_t k = 0; k < from.coefficients.size(); ++k) {
      xi[row + 6 + static_cast<int>(k)] = to.coefficients[k] - from.coefficients[k];
    }
  }
  if (x.imu) {
    xi.segment(x.imu_row(), x.imu->size()) = y.imu->parameters() - x.imu->parameters();
  }
  for (std::size_t i = 0; i < x.clones.size(); ++i) {
    xi.segment<6>(x.clones[i].row) =
        chart.local(pose_only(x.clones[i].world_T_imu), pose_only(y.clones[i].world_T_imu));
  }
  return xi;
}

Matrix6d pose_block(const ErrorChart& chart, const SE3& world_T_imu) {
  return chart.motion_block(pose_only(world_T_imu)).topLeftCorner<6, 6>();
}

void push(const ErrorChart& chart, const State& x, Eigen::Ref<Eigen::MatrixXd> M) {
  if (M.cols() == 1) {
    push_columns<1>(chart, x, M.col(0));
  } else {
    push_columns<Eigen::Dynamic>(chart, x, M);
  }
}

void pull(const ErrorChart& chart, const State& x, Eigen::Ref<Eigen::MatrixXd> M) {
  const int n = x.motion_size();
  const MotionBlock T = chart.motion_block(x);
  small::solve(T.topLeftCorner(n, n), M.topRows(n));
  for (const Clone& clone : x.clones) {
    small::solve(pose_block(chart, clone.world_T_imu), M.middleRows<6>(clone.row));
  }
  if (chart.landmark_block) {
    for (const Landmark& landmark : x.landmarks) {
      if (landmark.anchor) continue;
      M.middleRows<3>(landmark.row) -= chart.landmark_block(landmark.p_world) * M.topRows<3>();
    }
  }
}

Eigen::MatrixXd in_chart(const ErrorChart& chart, const Eigen::MatrixXd& F, const State& x,
                         const State& next) {
  Eigen::MatrixXd result = F;
  push(chart, next, result);
  // F T^-1 = (T^-T F^T)^T; T^-1 itself is small enough to be formed by pulling the identity.
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(F.cols(), F.cols());
  pull(chart, x, inverse);
  return result * inverse;
}

}  // namespace chasles
