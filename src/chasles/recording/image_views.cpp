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

 private:
  std::shared_ptr<const ImageSource> images_;
  std::size_t first_, count_, cameras_;
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

}  // namespace chasles
