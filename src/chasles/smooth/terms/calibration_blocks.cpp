#include <algorithm>

#include <Eigen/Cholesky>

#include <chasles/lie/so3.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// Of a positive definite matrix whose rows differ in scale.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& P) {
  const Eigen::VectorXd scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = scale.asDiagonal() * P * scale.asDiagonal();
  const Eigen::MatrixXd scaled = unit.ldlt().solve(Eigen::MatrixXd(scale.asDiagonal()));
  const Eigen::MatrixXd inverse = scale.asDiagonal() * scaled;
  return (inverse + inverse.transpose()) / 2;
}

}  // namespace

CalibrationBlocks::CalibrationBlocks(const std::optional<Calibration>& calibration) {
  if (!calibration) return;
  has_extrinsics_ = !calibration->imu_T_camera.empty();
  has_time_offset_ = calibration->time_offset.has_value();
  has_intrinsics_ = !calibration->intrinsics.empty();
  cameras_ =
      static_cast<int>(std::max(calibration->imu_T_camera.size(), calibration->intrinsics.size()));
  for (std::size_t i = 0; i < calibration->imu_T_camera.size(); ++i) add(kPoseErrors, true);
  if (has_time_offset_) add(1);
  for (const Intrinsics& one : calibration->intrinsics) add(6 * one.blocks());
  has_imu_ = calibration->imu.has_value();
  if (has_imu_) add(calibration->imu->size());
}

void CalibrationBlocks::add(int errors, bool is_pose) {
  all_.push_back({.numbers = is_pose ? kPoseNumbers : errors,
                  .errors = errors,
                  .number = numbers(),
                  .row = this->errors(),
                  .is_pose = is_pose});
}

std::vector<std::size_t> CalibrationBlocks::of_camera(int camera) const {
  std::vector<std::size_t> indices;
  const auto cameras = static_cast<std::size_t>(cameras_), own = static_cast<std::size_t>(camera);
  if (has_extrinsics_) indices.push_back(own);
  const std::size_t offset = has_extrinsics_ ? cameras : 0;
  if (has_time_offset_) indices.push_back(offset);
  if (has_intrinsics_) indices.push_back(offset + (has_time_offset_ ? 1 : 0) + own);
  return indices;
}

void write_intrinsics(const Intrinsics& intrinsics, double* x) {
  std::fill_n(x, 6 * intrinsics.blocks(), 0.0);
  Eigen::Map<Eigen::Vector4d>{x} = intrinsics.projection;
  x[Intrinsics::kReadoutRow] = intrinsics.readout;
  std::copy(intrinsics.coefficients.begin(), intrinsics.coefficients.end(), x + 6);
}

Intrinsics read_intrinsics(const double* x, Intrinsics like) {
  if (like.has_readout) like.readout = x[Intrinsics::kReadoutRow];
  if (!like.has_lens) return like;
  like.projection = Eigen::Map<const Eigen::Vector4d>(x);
  for (std::size_t i = 0; i < like.coefficients.size(); ++i) like.coefficients[i] = x[6 + i];
  return like;
}

ImuCorrection read_imu(const double* x, ImuCorrection like) {
  like.set(Eigen::Map<const Eigen::VectorXd>(x, like.size()));
  return like;
}

void write_calibration(const Calibration& calibration, double* x) {
  for (const SE3& imu_T_camera : calibration.imu_T_camera) {
    write_pose(imu_T_camera, x);
    x += kPoseNumbers;
  }
  if (calibration.time_offset) *x++ = *calibration.time_offset;
  for (const Intrinsics& one : calibration.intrinsics) {
    write_intrinsics(one, x);
    x += 6 * one.blocks();
  }
  if (calibration.imu) std::ranges::copy(calibration.imu->parameters(), x);
}

void read_calibration(const double* x, Calibration& calibration) {
  for (SE3& imu_T_camera : calibration.imu_T_camera) {
    imu_T_camera = read_pose(x);
    x += kPoseNumbers;
  }
  if (calibration.time_offset) calibration.time_offset = *x++;
  for (Intrinsics& one : calibration.intrinsics) {
    one = read_intrinsics(x, one);
    x += 6 * one.blocks();
  }
  if (calibration.imu) calibration.imu = read_imu(x, *calibration.imu);
}

Eigen::VectorXd difference(const CalibrationBlocks& blocks, const double* of,
                           const double* against) {
  Eigen::VectorXd e(blocks.errors());
  for (const auto& block : blocks.all()) {
    const double *a = of + block.number, *b = against + block.number;
    if (block.is_pose) {
      const SE3 at = read_pose(a), from = read_pose(b);
      e.segment<kPoseErrors>(block.row) << so3::log(at.R * from.R.transpose()), at.p - from.p;
    } else {
      for (int i = 0; i < block.errors; ++i) e[block.row + i] = a[i] - b[i];
    }
  }
  return e;
}

Eigen::VectorXd calibration_difference(const Calibration& of, const Calibration& against) {
  const CalibrationBlocks blocks(against);
  std::vector<double> a(static_cast<std::size_t>(blocks.numbers())), b(a.size());
  write_calibration(of, a.data());
  write_calibration(against, b.data());
  return difference(blocks, a.data(), b.data());
}

Eigen::MatrixXd widened(double factor, Eigen::MatrixXd covariance, const Eigen::MatrixXd& prior,
                        const std::vector<int>& considered) {
  std::vector<int> rows;
  for (int row = 0; row < static_cast<int>(prior.rows()); ++row) {
    if (std::ranges::find(considered, row) == considered.end()) rows.push_back(row);
  }
  const Eigen::MatrixXd before = inverse_of(prior(rows, rows));
  const Eigen::MatrixXd after = inverse_of(covariance(rows, rows));
  covariance(rows, rows) = inverse_of(before + (after - before) / factor);
  return covariance;
}

}  // namespace chasles::smooth_detail
