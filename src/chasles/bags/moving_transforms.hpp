#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <chasles/bags/ros_messages.hpp>

namespace chasles {

/// What the messages of /tf say of one frame against another.
struct MovingTransform {
  RosTransform first;
  std::size_t count = 0;  ///< how often it was published
  double shift = 0;       ///< the largest distance from the first one [m]
  double turn = 0;        ///< the largest rotation against the first one [rad]

  /// Whether it is that of sensors which are mounted firmly: it never differs by more than 0.1 mm
  /// or 0.01 deg, far below the errors of a calibration.
  bool is_constant() const;
};

/// Collects the transforms of /tf, in memory that does not grow with the length of a bag.
class MovingTransforms {
 public:
  /// A pair of frames beyond the first 10,000 is ignored.
  void add(RosTransform&& one);
  /// In the order of their first messages.
  std::vector<MovingTransform> all;

 private:
  std::map<std::pair<std::string, std::string>, std::size_t> of_frames_;  // parent, child
};

}  // namespace chasles
