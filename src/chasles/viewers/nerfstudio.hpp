#pragma once

#include <filesystem>
#include <string>

#include <chasles/viewers/posed_images.hpp>

namespace chasles {

/// A data set of nerfstudio (docs/exports.md).
struct NerfstudioFiles {
  std::string transforms;  ///< transforms.json
  std::string points;      ///< sparse_pc.ply: the landmarks, all of one grey
};

/// Poses are camera to world in the axes of OpenGL: x right, y up, z backward. The centre of the
/// first pixel is (0.5, 0.5). File names are relative to `folder`, where the data set will be.
/// Throws InputError for a lens model that nerfstudio does not have.
NerfstudioFiles run_nerfstudio(const Run& run, const PosedImages& posed,
                               const std::filesystem::path& folder);

}  // namespace chasles
