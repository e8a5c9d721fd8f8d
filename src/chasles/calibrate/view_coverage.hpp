#pragma once

#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/target/target.hpp>

namespace chasles {

/// What views of a target show of the cameras of a rig, and what they do not show.
class ViewCoverage {
 public:
  /// Of the cameras the sizes of their images are used. `corners`: of the target, p_target [m].
  ViewCoverage(const std::vector<Camera>& cameras, const std::vector<Eigen::Vector3d>& corners);

  /// Where the corners of a view are. Views in any order.
  void add(const TargetView& view);
  /// How the target leans in a view of a camera, and how far away it is.
  void add_pose(int camera, const SE3& cam_T_target);
  /// As if no pose of this camera had been added: for a lens that is known better.
  void clear_poses(int camera);

  /// Which views would make a calibration better, one sentence each, the most important first:
  /// cameras without views, cameras that no others share instants with, parts of images without
  /// corners, tilts, and distances.
  std::vector<std::string> missing() const;

 private:
  static constexpr int kColumns = 6, kRows = 4;  ///< parts of an image

  struct OfCamera {
    int width = 0, height = 0;
    std::size_t views = 0;
    std::array<std::array<bool, kColumns>, kRows> covered = {};
    std::array<double, 4> tilts = {};  ///< largest about x and y, both signs [rad]
    double nearest = 0, farthest = 0;  ///< distances of the target [m]; 0: no pose
  };

  std::vector<std::string> unlinked() const;
  static std::string open_parts(std::size_t camera, const OfCamera& seen);
  static void add_missing_poses(std::size_t camera, const OfCamera& seen,
                                std::vector<std::string>& missing);

  std::vector<OfCamera> cameras_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();  ///< of the target [m]
  std::map<Time, std::set<std::size_t>> instants_;    ///< the cameras that see the target then
};

}  // namespace chasles
