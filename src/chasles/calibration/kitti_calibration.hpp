#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <Eigen/Core>

#include <chasles/lie/se3.hpp>

namespace chasles {

/// A calibration file of KITTI: lines "KEY: number number …". Errors are InputError with file and
/// key.
class KittiCalibration {
 public:
  explicit KittiCalibration(const std::filesystem::path& file);

  bool has(const std::string& key) const { return rows_.contains(key); }
  std::string where(const std::string& key) const { return file_ + ": key '" + key + "'"; }
  Eigen::VectorXd numbers(const std::string& key, std::size_t size) const;
  Eigen::Matrix3d rotation(const std::string& key) const;
  /// The motion of the keys R and T.
  SE3 motion() const { return {rotation("R"), numbers("T", 3)}; }

 private:
  std::string file_;
  std::map<std::string, std::string> rows_;
};

/// Focal lengths, principal point and place of a rectified camera: P = K [I | t].
struct KittiProjection {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [px]
  Eigen::Vector3d t;                      ///< maps rectified coordinates: p_cam = p + t [m]
};
KittiProjection kitti_projection(const KittiCalibration& calibration, const std::string& key);

}  // namespace chasles
