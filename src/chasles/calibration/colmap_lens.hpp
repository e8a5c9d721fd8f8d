#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// A camera model of COLMAP.
struct ColmapLens {
  int id = 0;                      ///< in its binary files
  std::string_view name;           ///< in its text files
  std::vector<double> parameters;  ///< in its order; the first pixel's centre is (0.5, 0.5)
};

/// The model that projects each point in front of the camera to the same place. Throws InputError
/// for a lens that COLMAP does not have: ds, omni, and radtan with prism terms.
ColmapLens colmap_lens(const Camera& camera);

/// The text of cameras.txt, with the ids 1, 2, ... Throws as colmap_lens().
std::string colmap_camera_lines(const std::vector<Camera>& cameras);

}  // namespace chasles
