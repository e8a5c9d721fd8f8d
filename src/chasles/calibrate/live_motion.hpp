#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/calibrate/growing_images.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// What a motion lacks to calibrate cameras with their IMU, one sentence each: turns about an axis,
/// and changes of the force along one. `gyroscope_bias` [rad/s]. Nothing without samples.
std::vector<std::string> missing_motion(std::span<const ImuSample> samples,
                                        const Eigen::Vector3d& gyroscope_bias);

/// The samples of a recording whose table another program is still writing.
class LiveMotion {
 public:
  explicit LiveMotion(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Reads the whole rows of the table, if it has grown. What cannot be read yet is no error.
  void poll();
  std::size_t samples() const { return samples_.size(); }
  /// As missing_motion() from the first to the last view; where these are by another clock, of all
  /// samples. The bias is the mean rate: turns go there and back. Without samples, that they are
  /// expected.
  std::vector<std::string> missing(Time first, Time last) const;

 private:
  std::filesystem::path folder_;
  FileState state_;  ///< of the table
  std::vector<ImuSample> samples_;
};

}  // namespace chasles
