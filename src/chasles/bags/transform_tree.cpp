#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/camera_info.hpp>
#include <chasles/bags/transform_tree.hpp>

namespace chasles {
namespace {

std::string moving_text(const MovingTransform& moving) {
  return fmt::format("'{}' to '{}', published {} times, moves by up to {:.2g} m and {:.2g} deg",
                     moving.first.parent, moving.first.child, moving.count, moving.shift,
                     moving.turn * 180 / M_PI);
}

// The transforms of /tf on the way between two frames, of all or of the constant ones; none if they
// do not connect them even with those of /tf_static.
std::optional<std::vector<const MovingTransform*>> moving_between(const BagContents& contents,
                                                                  const std::string& to,
                                                                  const std::string& from,
                                                                  bool constant) {
  std::vector<RosTransform> all = contents.transforms;
  std::vector<const MovingTransform*> of_tf;
  for (const MovingTransform& moving : contents.moving) {
    if (constant && !moving.is_constant()) continue;
    all.push_back(moving.first);
    of_tf.push_back(&moving);
  }
  const auto chain = find_chain(all, to, from);
  if (!chain) return std::nullopt;
  std::vector<const MovingTransform*> between;
  for (const std::size_t i : *chain) {
    if (i >= contents.transforms.size()) between.push_back(of_tf[i - contents.transforms.size()]);
  }
  return between;
}

std::optional<SE3> transform_by_tf(const BagContents& contents, const std::string& to,
                                   const std::string& from, std::vector<std::string>& remarks) {
  const auto between = moving_between(contents, to, from, true);
  if (!between) return std::nullopt;
  std::vector<RosTransform> all = contents.transforms;
  for (const MovingTransform* moving : *between) {
    all.push_back(moving->first);
    std::string remark = fmt::format(
        "the transform of {}: it is constant, and taken from /tf because /tf_static has none",
        moving_text(*moving));
    if (std::ranges::find(remarks, remark) == remarks.end()) remarks.push_back(std::move(remark));
  }
  return find_transform(all, to, from);
}

}  // namespace

std::optional<TreeTransform> transform_between(const BagContents& contents, const std::string& to,
                                               const std::string& from,
                                               std::vector<std::string>& remarks) {
  if (to.empty() || from.empty()) return std::nullopt;
  if (const auto known = find_transform(contents.transforms, to, from)) {
    return TreeTransform{.to_T_from = *known};
  }
  const auto by_tf = transform_by_tf(contents, to, from, remarks);
  if (!by_tf) return std::nullopt;
  return TreeTransform{.to_T_from = *by_tf, .topic = "/tf"};
}

std::string moving_advice(const BagContents& contents, const std::string& to,
                          const std::string& from, const std::string& sensor) {
  const auto between = moving_between(contents, to, from, false);
  if (!between || from.empty() || to.empty()) return "";
  std::string text = "; /tf leads there, but ";
  for (const MovingTransform* moving : *between) {
    if (!moving->is_constant()) text += moving_text(*moving) + ", ";
  }
  return text + fmt::format("as no {} does that is mounted firmly", sensor);
}

}  // namespace chasles
