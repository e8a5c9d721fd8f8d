#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <chasles/codec/image_source.hpp>
#include <chasles/reconstruct/undistortion.hpp>
#include <chasles/viewers/posed_images.hpp>

namespace chasles {

/// Receives the name and the content of a file.
using AddFile = std::function<void(const std::string& name, const std::string& bytes)>;

/// Images of a recording without the distortion of their lenses, as PNG. They are made one after
/// the other, when they are written: no more than the images of one frame are in memory.
class UndistortedImages {
 public:
  /// `lenses`: one a camera.
  UndistortedImages(std::shared_ptr<const ImageSource> images, std::vector<Undistortion> lenses)
      : images_(std::move(images)), lenses_(std::move(lenses)) {}

  /// That of a camera in the i-th frame of the source, under this name; in order of the frames.
  void want(std::size_t frame, std::size_t camera, std::string name) {
    wanted_.push_back({frame, camera, std::move(name)});
  }
  const Camera& camera(std::size_t i) const { return lenses_[i].pinhole(); }

  /// Throws InputError for an image that cannot be read.
  void write(const AddFile& add) const;

 private:
  struct Wanted {
    std::size_t frame = 0, camera = 0;
    std::string name;
  };
  std::shared_ptr<const ImageSource> images_;
  std::vector<Undistortion> lenses_;
  std::vector<Wanted> wanted_;
};

/// Of each camera.
std::vector<Undistortion> undistortions(const std::vector<Camera>& cameras);

/// "NS.png": the name of an image's file by its time.
std::string image_name(Time time);

/// The images of the run's first camera that have a pose, with a pinhole camera; their files are
/// to be written into `folder`/images. Throws InputError as poses_at_frames(), and for a recording
/// without images.
struct PosedUndistorted {
  PosedImages posed;
  UndistortedImages images;
};
PosedUndistorted posed_undistorted(const ReportRun& run, RunPath path, const Recording& recording,
                                   const std::filesystem::path& folder);

}  // namespace chasles
