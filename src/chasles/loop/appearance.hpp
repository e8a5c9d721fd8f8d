#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/loop/descriptor.hpp>

namespace chasles {

/// What a point of the map looks like from one place: patches of fixed sizes in metres, upright by
/// gravity, so that descriptors of the same size can be compared.
struct PatchView {
  static constexpr int kLevels = 3;

  Eigen::Vector3f from = Eigen::Vector3f::Zero();  ///< unit vector to the camera, axes of the map
  int level = 0;  ///< of the first: a pixel of its patch is 2^(level/2) mm at the point
  std::array<Descriptor, kLevels> descriptors = {};  ///< of this level and the next coarser ones

  /// About the distance from which a camera of focal length 500 px saw it [m].
  double distance() const { return 0.5 * std::exp2(level / 2.0); }
};

/// The patches of a view of a point: p_cam, in the camera's frame [m], not at its origin. The
/// camera's axes in those of the map, whose z points up. None if the point has no pixel.
struct ViewPatches {
  PatchView view;  ///< without its descriptors
  std::array<ImagePatch, PatchView::kLevels> patches;
};
std::optional<ViewPatches> view_patches(const Camera& camera, const Eigen::Matrix3d& map_R_cam,
                                        const Eigen::Vector3d& p_cam);

/// Hamming distance of the finest descriptors of the same size; none if there are none.
std::optional<int> distance(const PatchView& a, const PatchView& b);

/// The views of a point from several sides and distances.
class Appearance {
 public:
  static constexpr std::size_t kMostViews = 4;

  Appearance() = default;
  /// Of stored views, kMostViews at most.
  explicit Appearance(std::vector<PatchView> views) : views_(std::move(views)) {}

  /// Keeps the view if none of its views is similar in direction and distance.
  void add(const PatchView& view);
  /// In other axes, turned about the vertical. Views from steeply above or below are left out: they
  /// are upright by the old axes.
  Appearance turned(const Eigen::Matrix3d& new_R_old) const;
  bool empty() const { return views_.empty(); }
  const std::vector<PatchView>& views() const { return views_; }
  /// The smallest distance of a view from a similar direction; none if there is none.
  std::optional<int> distance(const PatchView& view) const;
  /// Whether the point has been seen from about there: a view of this direction and level.
  bool may_match(const PatchView& view) const;

 private:
  std::vector<PatchView> views_;
};

}  // namespace chasles
