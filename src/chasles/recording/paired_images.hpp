#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include <chasles/codec/image_source.hpp>
#include <chasles/recording/pair_images.hpp>

namespace chasles {

/// The images of cameras that were recorded one by one, and paired to frames.
class PairedImages : public ImageSource {
 public:
  PairedImages(std::vector<PairedFrame> frames, std::size_t cameras)
      : frames_(std::move(frames)), cameras_(cameras) {}

  std::size_t size() const override { return frames_.size(); }
  Time time(std::size_t i) const override { return frames_[i].time; }
  ImageFrame read(std::size_t i) const override { return read_cameras(i, cameras_); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    return read_undamaged(i, cameras, &throw_damage);
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    ImageFrame frame{.time = frames_[i].time, .images = {}};
    for (std::size_t c = 0; c < std::min(cameras, cameras_); ++c) {
      frame.images.push_back(read_member(i, c, damaged));
    }
    return frame;
  }
  ImageFrame read_chosen(std::size_t i, const std::vector<std::size_t>& cameras,
                         const OnDamage& damaged) const override {
    ImageFrame frame{.time = frames_[i].time, .images = {}};
    for (const std::size_t c : cameras) frame.images.push_back(read_member(i, c, damaged));
    return frame;
  }
  bool has_image(std::size_t i, std::size_t camera) const override {
    return member(i, camera).has_value();
  }
  /// The index of the camera's image in the frame, among all of that camera; none without one.
  const std::optional<std::size_t>& member(std::size_t i, std::size_t camera) const {
    return frames_[i].members[camera];
  }

 private:
  GrayImage read_member(std::size_t i, std::size_t camera, const OnDamage& damaged) const {
    const auto& image = member(i, camera);
    return read_or_empty([&] { return image ? read_one(camera, *image) : GrayImage{}; }, damaged);
  }
  /// Decodes an image of a camera. Throws InputError.
  virtual GrayImage read_one(std::size_t camera, std::size_t image) const = 0;

  std::vector<PairedFrame> frames_;
  std::size_t cameras_;
};

}  // namespace chasles
