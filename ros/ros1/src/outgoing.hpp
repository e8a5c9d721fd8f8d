#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

// What the node publishes, in plain types. The headers of ROS 1 messages need C++17, those of the
// libraries C++20: this header is for both.
namespace chasles::ros1 {

struct OutPose {
  std::array<double, 3> position{};                   ///< [m]
  std::array<double, 4> quaternion_xyzw{0, 0, 0, 1};  ///< of unit length
};

/// The time of a message [ns since 1970; 0 or more] and its frame.
struct OutHeader {
  std::int64_t stamp = 0;
  std::string frame;
};

/// parent_T_child.
struct OutTransform {
  OutHeader parent;
  std::string child;
  OutPose pose;
};

/// Covariances are row by row, of [x, y, z, rotations about the fixed axes x, y, z].
struct OutPoseWithCovariance {
  OutHeader header;
  OutPose pose;
  std::array<double, 36> covariance{};
};

struct OutOdometry {
  OutPoseWithCovariance pose;
  std::string child;  ///< its axes are those of the twist
  std::array<double, 3> linear{}, angular{};
  std::array<double, 36> twist_covariance{};
};

/// Poses by their stamps; all have the frame of the header.
struct OutPath {
  OutHeader header;
  std::vector<std::pair<std::int64_t, OutPose>> poses;
};

/// x, y, z and the sigma of each point [m].
struct OutPoints {
  OutHeader header;
  std::vector<std::array<float, 4>> points;
};

enum class DiagnosisLevel { kOk, kWarning, kError };  ///< by the numbers of ROS

struct OutDiagnosis {
  DiagnosisLevel level = DiagnosisLevel::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace chasles::ros1
