#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/bags/bag_contents.hpp>

namespace chasles {

/// A motion between two frames, and the topic that it comes from.
struct TreeTransform {
  SE3 to_T_from = {};
  const char* topic = "/tf_static";
};

/// By /tf_static; where that does not lead from one frame to the other, by the transforms of /tf
/// that are constant (MovingTransform::is_constant()) as well, with a remark on each: drivers
/// publish what is mounted firmly there too. None if the frames are not connected, or if one has no
/// name.
std::optional<TreeTransform> transform_between(const BagContents& contents, const std::string& to,
                                               const std::string& from,
                                               std::vector<std::string>& remarks);

/// For a message: which transforms of /tf lead from one frame to the other and move, as no `sensor`
/// ("camera") does. Empty where none do.
std::string moving_advice(const BagContents& contents, const std::string& to,
                          const std::string& from, const std::string& sensor);

}  // namespace chasles
