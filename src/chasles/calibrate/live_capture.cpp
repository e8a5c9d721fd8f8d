#include <algorithm>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/live_capture.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {

namespace fs = std::filesystem;

LiveCapture::LiveCapture(fs::path folder, const Target& target, std::vector<LensForm> candidates)
    : images_(std::move(folder)), detector_(target), candidates_(std::move(candidates)) {}

bool LiveCapture::search() {
  const std::optional<GrowingImages::Shot> taken = images_.take();
  if (!taken) return false;
  std::optional<Shot> shot = searched(*taken);
  if (!shot) {
    images_.put_back(*taken);
    return true;
  }
  for (std::size_t c = 0; c < shot->images.size(); ++c) {
    if (shot->images[c]) places_[shot->images[c]->file] = {shots_.size(), c};
  }
  shots_.push_back(std::move(*shot));
  // The first names do not show yet in which unit they are, and cameras may come later.
  constexpr std::size_t kFirst = 5;
  const auto has_size = [](const Camera& a, const Camera& b) { return a.width == b.width; };
  if (shots_.size() <= kFirst || !std::ranges::equal(guide_->input().cameras, sizes_, has_size)) {
    restart();
  } else {
    guide_by(shots_.back());
  }
  return true;
}

std::pair<Time, Time> LiveCapture::span() const {
  if (!guide_ || guide_->input().views.empty()) return {};
  const auto [first, last] =
      std::ranges::minmax_element(guide_->input().views, {}, &TargetView::time);
  return {first->time, last->time};
}

std::string LiveCapture::seen() const {
  if (shots_.empty()) return "";
  const std::size_t all = guide_->input().corners.size();
  std::string text;
  for (std::size_t c = 0; c < shots_.back().images.size(); ++c) {
    const std::optional<Image>& image = shots_.back().images[c];
    if (!image) continue;
    text += fmt::format("{}cam{} ", text.empty() ? "" : ", ", c);
    const TargetDetection& found = image->detection;
    text += found.view.ids.empty() ? std::string("no target")
                                   : fmt::format("{} of {} corners", found.view.ids.size(), all);
    if (!found.view.ids.empty() && BlurCount::is_blurred(found.blur)) {
      text += fmt::format(", blurred over {:.1f} px: move more slowly", found.blur);
    }
  }
  return text;
}

std::string LiveCapture::found() const {
  if (!guide_) return "";
  std::size_t views = 0;
  std::string lenses;
  for (std::size_t c = 0; c < guide_->input().cameras.size(); ++c) {
    views += guide_->views(c);
    if (const auto& estimate = guide_->estimate(c)) {
      lenses +=
          fmt::format(", cam{} fx {:.1f} +- {:.2g} px", c, estimate->focal_length, estimate->sigma);
    }
  }
  return fmt::format("{} views, {} independent{}", views, guide_->pieces(), lenses);
}

std::vector<std::string> LiveCapture::missing() const {
  return guide_ ? guide_->missing() : std::vector<std::string>{"there are no images yet"};
}

const TargetDetection* LiveCapture::known(const fs::path& file) const {
  const auto place = places_.find(file);
  if (place == places_.end()) return nullptr;
  const Image& image = *shots_[place->second.first].images[place->second.second];
  return !image.deep && FileState::of(file) == image.state ? &image.detection : nullptr;
}

// None where an image is not whole.
std::optional<LiveCapture::Shot> LiveCapture::searched(const GrowingImages::Shot& shot) {
  Shot result{.name = shot.name, .images = {}};
  sizes_.resize(std::max(sizes_.size(), shot.files.size()), Camera{.cam_T_imu = {}});
  for (std::size_t c = 0; c < shot.files.size(); ++c) {
    result.images.emplace_back();
    const fs::path& file = shot.files[c];
    if (file.empty()) continue;
    try {
      const std::string bytes = read_file(file);
      const StatedImage stated = stated_image(bytes, file.string());
      const ImageSize size = sizes_[c].width > 0
                                 ? ImageSize{.width = sizes_[c].width, .height = sizes_[c].height}
                                 : stated.size;
      const GrayImage image = decode_image(bytes, size, file.string());
      sizes_[c].width = size.width;
      sizes_[c].height = size.height;
      result.images[c] = Image{.file = file,
                               .state = shot.states[c],
                               .detection = detector_.detect(image),
                               .deep = stated.deep};
    } catch (const InputError&) {
      return std::nullopt;
    }
  }
  return result;
}

void LiveCapture::restart() {
  CamerasInput input{.corners = detector_.target().corners(),
                     .views = {},
                     .cameras = sizes_,
                     .lenses = {},
                     .shape = printed_shape(detector_.target())};
  for (const Camera& camera : sizes_) input.lenses.push_back(guiding_lens(camera, candidates_));
  guide_.emplace(std::move(input));
  for (const Shot& shot : shots_) guide_by(shot);
}

void LiveCapture::guide_by(const Shot& shot) {
  const std::vector<std::string> names(images_.names().begin(), images_.names().end());
  const auto place = std::ranges::lower_bound(names, shot.name) - names.begin();
  const Time time = times_of_names(names)[static_cast<std::size_t>(place)];
  for (std::size_t c = 0; c < shot.images.size(); ++c) {
    if (!shot.images[c]) continue;
    const TargetDetection& found = shot.images[c]->detection;
    TargetView view = found.view;
    view.time = time;
    view.camera = static_cast<int>(c);
    guide_->add(view, found.view.ids.empty() ? kNaN : found.blur);
  }
}

}  // namespace chasles
