#pragma once

#include <optional>
#include <vector>

#include <chasles/filter/calibration.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

/// An estimated calibration as parameter blocks. Private to the smooth folder.
namespace chasles::smooth_detail {

/// The blocks of a calibration, in the order of its errors (filter/calibration.hpp): the extrinsics
/// of each camera as the numbers of a pose, the time offset, the intrinsics of each camera, whose
/// numbers are their rows, and the IMU's parameters.
class CalibrationBlocks {
 public:
  struct Block {
    int numbers = 0, errors = 0;
    int number = 0, row = 0;  ///< the first of them
    bool is_pose = false;
  };

  CalibrationBlocks() = default;  ///< nothing is estimated
  explicit CalibrationBlocks(const std::optional<Calibration>& calibration);

  const std::vector<Block>& all() const { return all_; }
  bool empty() const { return all_.empty(); }
  int numbers() const { return empty() ? 0 : all_.back().number + all_.back().numbers; }
  int errors() const { return empty() ? 0 : all_.back().row + all_.back().errors; }
  /// The indices of those on which the pixels of a camera depend; they rise.
  std::vector<std::size_t> of_camera(int camera) const;
  /// The index of that of the IMU's parameters; none: they are known.
  std::optional<std::size_t> of_imu() const {
    return has_imu_ ? std::optional(all_.size() - 1) : std::nullopt;
  }

 private:
  void add(int errors, bool is_pose = false);

  std::vector<Block> all_;
  int cameras_ = 0;
  bool has_extrinsics_ = false, has_time_offset_ = false, has_intrinsics_ = false, has_imu_ = false;
};

void write_intrinsics(const Intrinsics& intrinsics, double* x);
/// `like`: of the same lens model; what is known of them stays.
Intrinsics read_intrinsics(const double* x, Intrinsics like);
/// `like`: with the same parameters.
ImuCorrection read_imu(const double* x, ImuCorrection like);

void write_calibration(const Calibration& calibration, double* x);
/// Replaces the values of a calibration with the same parts.
void read_calibration(const double* x, Calibration& calibration);

/// The errors of these numbers against others.
Eigen::VectorXd difference(const CalibrationBlocks& blocks, const double* of,
                           const double* against);
/// The errors of a calibration against another one with the same parts.
Eigen::VectorXd calibration_difference(const Calibration& of, const Calibration& against);

/// The covariance if the information of all measurements, but not that of the prior, is smaller by
/// that factor. Rows that are `considered` do not depend on measurements and stay.
Eigen::MatrixXd widened(double factor, Eigen::MatrixXd covariance, const Eigen::MatrixXd& prior,
                        const std::vector<int>& considered);

}  // namespace chasles::smooth_detail
