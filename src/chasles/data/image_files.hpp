#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/data/image_source.hpp>

namespace chasles {

/// An image of one camera: when, and in which file of its folder.
struct StampedFile {
  Time time{};
  std::string file;
};

/// The images of one camera, in any order, in one folder.
struct CameraFiles {
  std::filesystem::path folder;
  std::vector<StampedFile> images;
};

/// Where a folder has no table of its images: those named after their time in nanoseconds
/// (1403636584763555584.png). Throws InputError for an image whose name is no number.
std::vector<StampedFile> files_named_by_time(const std::filesystem::path& folder);

/// The images of a rig, read when they are asked for. Images whose times differ by at most
/// `tolerance` make one frame, at the time of the first camera that has one. Corrected and counted
/// in `remarks`: what is not in order of time, a time that is there twice (the first stays), files
/// that are missing, and images that only some of the cameras have. Throws InputError where a
/// camera's folder is missing or none of its images is there.
///
/// `cameras`: one entry a camera of the rig, whose images must have its size.
std::shared_ptr<const ImageSource> open_image_files(std::vector<CameraFiles> cameras,
                                                    const std::vector<Camera>& rig, Time tolerance,
                                                    std::vector<std::string>& remarks);

}  // namespace chasles
