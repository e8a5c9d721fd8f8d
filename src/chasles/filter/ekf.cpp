#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>

#include <chasles/base/error.hpp>
#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/whitening.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxRows = 6;  // of one measurement, given by its types
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxRows>;

// visit(first error, derivative by it and those after it) for all errors that a measurement depends
// on.
template <class Visitor>
void for_each_block(const Measurement& z, const State& x, const Visitor& visit) {
  if (z.d_core.cols() == 6) {
    visit(z.core_column, z.d_core.leftCols<6>());
  } else if (z.d_core.cols() > 0) {
    visit(z.core_column, z.d_core);
  }
  if (z.landmark >= 0) {
    visit(x.landmarks[static_cast<std::size_t>(z.landmark)].row, z.d_landmark);
  }
  for (const Measurement::OfClone& clone : z.clones) visit(clone.row, clone.d);
}

}  // namespace

Ekf::Ekf(const ErrorChart& chart, State initial, const MatrixXd& core_covariance, Options options)
    : chart_(&chart),
      keep_scale_(options.keep_scale),
      considered_(std::move(options.considered)),
      state_(std::move(initial)),
      covariance_(core_covariance),
      past_(core_covariance,
            {.map = options.map, .past = options.past, .map_bytes = options.map_bytes}) {
  dense::prepare();
  if (state_.calibration_size() > 0) {
    past_.reject_with_history("estimated extrinsics and time offset need");
  }
  if (keep_scale_) past_.reject_with_history("keep_scale needs");
  if (keep_scale_ && !state_.v_world) throw UsageError("keep_scale needs an inertial filter");
  if (keep_scale_ && chart.name == kLeftSe3Chart.name) {
    throw UsageError(
        "keep_scale needs a chart other than left-se3, whose pose errors rotate with the body");
  }
}

MatrixXd Ekf::core_covariance() const {
  const int n = state_.core_size();
  return covariance_.all().topLeftCorner(n, n);
}

void Ekf::propagate(const Prediction& prediction) {
  past_.propagate(prediction.F, prediction.Q, covariance_);
  state_.world_T_imu = prediction.world_T_imu;
  state_.world_T_imu.R = so3::normalized(state_.world_T_imu.R);
  state_.v_world = prediction.v_world;
  state_.additive = prediction.additive;
  const int n = state_.core_size();
  auto P = covariance_.all();
  auto moved = work_.product.take(n, P.cols());
  moved.noalias() = prediction.F * P.topRows(n);
  P.topRows(n) = moved;
  auto core = work_.product.take(n, n);
  core.noalias() = P.topLeftCorner(n, n) * prediction.F.transpose();
  P.topLeftCorner(n, n) = core + prediction.Q;
  P.bottomLeftCorner(P.rows() - n, n) = P.topRightCorner(n, P.cols() - n).transpose();
}

void Ekf::add_noise(int landmark, const Eigen::Matrix3d& noise) {
  past_.reject_with_history("landmarks that move need");
  const int row = state_.landmarks[static_cast<std::size_t>(landmark)].row;
  covariance_.all().block<3, 3>(row, row) += noise;
}

Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> Innovation::whitened() const {
  const auto L = S.llt();
  if (L.info() == Eigen::Success) return L.matrixL().solve(residual);
  return decltype(residual)::Constant(residual.size(), std::numeric_limits<double>::quiet_NaN());
}

double Innovation::normalised_square() const { return whitened().squaredNorm(); }

Innovation Ekf::innovation(const Measurement& z) const {
  const auto P = covariance_.all();
  Innovation result{.residual = z.residual, .S = z.noise};
  for_each_block(z, state_, [&](Eigen::Index column, const auto& by_column) {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, Measurement::kMaxCoreColumns>
        HP = MatrixXd::Zero(z.residual.size(), by_column.cols());
    for_each_block(z, state_, [&](Eigen::Index row, const auto& by_row) {
      HP += by_row.lazyProduct(P.block(row, column, by_row.cols(), by_column.cols()));
    });
    result.S += HP.lazyProduct(by_column.transpose());
  });
  return result;
}

double Ekf::normalised_square(const Measurement& z) const {
  return innovation(z).normalised_square();
}

std::vector<double> Ekf::normalised_squares(std::span<const Measurement> measurements,
                                            const Measurement* given) const {
  std::vector<double> result;
  if (!given) {
    for (const Measurement& z : measurements) result.push_back(normalised_square(z));
    return result;
  }
  const Innovation known = innovation(*given);
  const SmallMatrix weight = small::inverse_symmetric(known.S);
  const MatrixXd PHt = covariance_.all().middleCols(given->core_column, given->d_core.cols()) *
                       given->d_core.transpose();
  for (const Measurement& z : measurements) {
    SmallMatrix cross = z.d_core * PHt.middleRows(z.core_column, z.d_core.cols());
    if (z.landmark >= 0) {
      const int row = state_.landmarks[static_cast<std::size_t>(z.landmark)].row;
      cross += z.d_landmark * PHt.middleRows<3>(row);
    }
    for (const Measurement::OfClone& clone : z.clones) {
      cross += clone.d * PHt.middleRows<6>(clone.row);
    }
    Innovation conditional = innovation(z);
    const SmallMatrix gain = cross * weight;
    conditional.residual -= gain * known.residual;
    conditional.S -= gain * cross.transpose();
    result.push_back(conditional.normalised_square());
  }
  return result;
}

double Ekf::joint_normalised_square(std::span<const Measurement> measurements) const {
  work_.accepted.clear();
  for (const Measurement& z : measurements) work_.accepted.push_back(&z);
  return chasles::normalised_square(work_.accepted, covariance_, state_, work_.whitening);
}

const UpdateReport& Ekf::update(std::span<const Measurement> measurements) {
  gate(measurements);
  const std::vector<const Measurement*>& accepted = work_.accepted;
  UpdateReport& report = work_.report;
  if (accepted.empty()) return report;

  const std::optional<Whitened> z =
      whiten(accepted, covariance_, past_.Z(), state_, work_.whitening);
  report.failed = !z;
  if (!z) return report;
  report.nis = z->nis;
  report.dof = static_cast<int>(rows_of(accepted));
  auto delta = work_.delta.take<VectorXd>(z->W.rows());
  delta.noalias() = z->W * z->w;
  dense::downdate_lower(z->W, covariance_.all());
  if (state_.considered) leave_unused(*z, delta);
  leave_considered(*z, delta);
  past_.correct(accepted, *z, delta);

  State& before = work_.before;
  before.landmarks.reserve(state_.landmarks.capacity());
  before.clones.reserve(state_.clones.capacity());
  before = state_;
  correct_mean(state_, delta);
  change_chart(before);
  dense::mirror_lower(covariance_.all());
  past_.end_correction();
  for (const Measurement* used : accepted) {
    if (used->landmark >= 0) {
      ++state_.landmarks[static_cast<std::size_t>(used->landmark)].observations;
    }
  }
  return report;
}

std::optional<State> Ekf::updated_mean(std::span<const Measurement> measurements) const {
  gate(measurements);
  if (work_.accepted.empty()) return std::nullopt;
  const MatrixXd no_past(0, covariance_.size());
  const auto z = whiten(work_.accepted, covariance_, no_past, state_, work_.whitening);
  if (!z) return std::nullopt;
  State mean = state_;
  VectorXd delta = z->W * z->w;
  delta(considered_).setZero();
  if (state_.considered) {
    const UnusedGain unused = unused_gain(state_, past_.left(), *z);
    delta(unused.rows) -= unused.D * z->w;
  }
  correct_mean(mean, delta);
  return mean;
}

namespace {

// residual^T S^-1 residual of the latest measurement in the report, without what the gate leaves
// out.
double gate_square(const Measurement& z, const UpdateReport& report) {
  if (z.shared_variance <= 0) return report.whitened.back().squaredNorm();
  Innovation own{.residual = z.residual, .S = report.covariances.back()};
  own.S.diagonal().array() -= z.shared_variance;
  return own.normalised_square();
}

}  // namespace

void Ekf::gate(std::span<const Measurement> measurements) const {
  UpdateReport& report = work_.report;
  report.nis = 0;
  report.dof = 0;
  report.accepted.clear();
  report.whitened.clear();
  report.covariances.clear();
  report.failed = false;
  work_.accepted.clear();
  for (const Measurement& z : measurements) {
    const bool gated = !std::isinf(z.gate);  // without a gate, no test is computed
    report.whitened.emplace_back();
    report.covariances.emplace_back();
    if (gated) {
      const Innovation own = innovation(z);
      report.whitened.back() = own.whitened();
      report.covariances.back() = own.S;
    }
    // Written so that a NaN is rejected.
    const bool inside = gated ? gate_square(z, report) < z.gate : z.residual.allFinite();
    report.accepted.push_back(inside);
    if (inside) work_.accepted.push_back(&z);
  }
}

void Ekf::add(std::span<const NewLandmark> landmarks) {
  if (landmarks.empty()) return;
  const int old_size = covariance_.size();
  const int rows = 3 * static_cast<int>(landmarks.size());
  covariance_.append(rows);
  past_.add(landmarks, old_size);
  auto P = covariance_.all();
  auto d_pose = work_.B.take(rows, 6);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    d_pose.middleRows<3>(3 * static_cast<int>(i)) = landmarks[i].d_pose;
  }
  auto cross = work_.Z.take(rows, old_size);
  cross.noalias() = d_pose * P.topLeftCorner(6, old_size);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (const NewLandmark::OfClone& clone : landmarks[i].clones) {
      auto more = work_.product.take<Eigen::Matrix<double, 3, Eigen::Dynamic>>(3, old_size);
      more.noalias() = clone.d * P.block(clone.row, 0, 6, old_size);
      cross.middleRows<3>(3 * static_cast<int>(i)) += more;
    }
  }
  P.block(old_size, 0, rows, old_size) = cross;
  P.block(0, old_size, old_size, rows) = cross.transpose();
  auto own = work_.other.take(rows, rows);
  own.noalias() = cross.leftCols<6>() * d_pose.transpose();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    for (const NewLandmark::OfClone& clone : landmarks[i].clones) {
      auto more = work_.product.take<Eigen::Matrix<double, Eigen::Dynamic, 3>>(rows, 3);
      more.noalias() = cross.middleCols<6>(clone.row) * clone.d.transpose();
      own.middleCols<3>(3 * static_cast<int>(i)) += more;
    }
  }
  P.block(old_size, old_size, rows, rows) = own;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const int row = old_size + 3 * static_cast<int>(i);
    P.block<3, 3>(row, row) += landmarks[i].noise;
    state_.landmarks.push_back({.id = landmarks[i].id,
                                .p_world = landmarks[i].p_world,
                                .row = row,
                                .observations = landmarks[i].observations,
                                .anchor = landmarks[i].anchor,
                                .cam_T_imu = landmarks[i].cam_T_imu,
                                .inverse_depth = landmarks[i].inverse_depth,
                                .camera = landmarks[i].camera,
                                .imu_T_line = landmarks[i].imu_T_line,
                                .face = landmarks[i].face});
    state_.landmarks.back().first = state_.p_world(state_.landmarks.back());
  }
}

}  // namespace chasles
