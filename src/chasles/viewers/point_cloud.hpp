#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include <chasles/base/time.hpp>
#include <chasles/viewers/colours.hpp>

namespace chasles {

/// A point of a cloud.
struct CloudPoint {
  Eigen::Vector3d p;  ///< [m]
  double sigma;       ///< [m]
  Rgb colour;
  std::vector<std::uint8_t> more = {};  ///< values of the cloud's further fields
};

/// A foxglove.PointCloud with float x, y, z, sigma and uint8 red, green, blue, alpha, and further
/// fields of type uint8.
class PointCloud {
 public:
  explicit PointCloud(std::string frame, std::vector<std::string> more = {});
  /// Throws std::invalid_argument where `more` has not one value for each further field.
  void add(const CloudPoint& point);
  nlohmann::json message(Time time) const;

 private:
  std::string frame_;
  std::vector<std::string> more_;
  std::string bytes_;
};

}  // namespace chasles
