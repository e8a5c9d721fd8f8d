#include <algorithm>
#include <utility>

#include <chasles/recording/image_views.hpp>

namespace chasles {
namespace {

class Part : public ImageSource {
 public:
  Part(std::shared_ptr<const ImageSource> images, std::size_t first, std::size_t count,
       std::size_t cameras)
      : images_(std::move(images)), first_(first), count_(count), cameras_(cameras) {}

  std::size_t size() const override { return count_; }
  Time time(std::size_t i) const override { return images_->time(first_ + i); }
  ImageFrame read(std::size_t i) const override { return read_cameras(i, cameras_); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    return images_->read_cameras(first_ + i, std::min(cameras, cameras_));
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    return images_->read_undamaged(first_ + i, std::min(cameras, cameras_), damaged);
  }

  ImageFrame read_chosen(std::size_t i, const std::vector<std::size_t>& cameras,
                         const OnDamage& damaged) const override {
    return images_->read_chosen(first_ + i, cameras, damaged);
  }
  bool has_image(std::size_t i, std::size_t camera) const override {
    return images_->has_image(first_ + i, camera);
  }

 private:
  std::shared_ptr<const ImageSource> images_;
  std::size_t first_, count_, cameras_;
};

class Chosen : public ImageSource {
 public:
  Chosen(std::shared_ptr<const ImageSource> images, std::vector<std::size_t> cameras)
      : images_(std::move(images)), cameras_(std::move(cameras)) {
    for (std::size_t i = 0; i < images_->size(); ++i) {
      const bool any = std::ranges::any_of(
          cameras_, [&](std::size_t camera) { return images_->has_image(i, camera); });
      if (any) frames_.push_back(i);
    }
  }

  std::size_t size() const override { return frames_.size(); }
  Time time(std::size_t i) const override { return images_->time(frames_[i]); }
  ImageFrame read(std::size_t i) const override { return read_cameras(i, cameras_.size()); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    return read_undamaged(i, cameras, &throw_damage);
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    std::vector<std::size_t> first = cameras_;
    first.resize(std::min(cameras, first.size()));
    return images_->read_chosen(frames_[i], first, damaged);
  }
  bool has_image(std::size_t i, std::size_t camera) const override {
    return images_->has_image(frames_[i], cameras_[camera]);
  }

 private:
  std::shared_ptr<const ImageSource> images_;
  std::vector<std::size_t> cameras_;
  std::vector<std::size_t> frames_;  // of `images_`
};

}  // namespace

std::shared_ptr<const ImageSource> part_of(std::shared_ptr<const ImageSource> images, Time from,
                                           Time to, std::size_t cameras) {
  std::size_t first = 0;
  while (first < images->size() && images->time(first) < from) ++first;
  std::size_t end = first;
  while (end < images->size() && images->time(end) <= to) ++end;
  return std::make_shared<Part>(std::move(images), first, end - first, cameras);
}

std::shared_ptr<const ImageSource> chosen_cameras(std::shared_ptr<const ImageSource> images,
                                                  std::vector<std::size_t> cameras) {
  return std::make_shared<Chosen>(std::move(images), std::move(cameras));
}

}  // namespace chasles
