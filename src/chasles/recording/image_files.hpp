#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/codec/image_source.hpp>

namespace chasles {

/// An image of one camera: its time and its file name within the camera's folder.
struct StampedFile {
  Time time{};
  std::string file;
};

/// The images of one camera, in any order, in one folder.
struct CameraFiles {
  std::filesystem::path folder;
  std::vector<StampedFile> images;
};

/// The images of a rig, read on request. Each image of the first camera makes a frame, with those
/// of the others within `tolerance` (pair_images). The function corrects, and counts in `remarks`:
/// images that are not in order of time, repeated times (the first image stays), missing files, and
/// images that only some of the cameras have. Throws InputError if a camera's folder is
/// missing or none of its images is there.
///
/// `cameras`: one entry for each camera of the rig; its images must have the camera's size.
std::shared_ptr<const ImageSource> open_image_files(std::vector<CameraFiles> cameras,
                                                    const std::vector<Camera>& rig, Time tolerance,
                                                    std::vector<std::string>& remarks);

/// The file of a camera's image in the i-th frame of such a source; empty for a camera without an
/// image there, and for a source whose images are no files.
std::filesystem::path image_file(const ImageSource& images, std::size_t i, std::size_t camera);

}  // namespace chasles
