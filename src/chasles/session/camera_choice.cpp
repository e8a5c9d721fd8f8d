#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/all_cameras.hpp>
#include <chasles/recording/image_views.hpp>
#include <chasles/session/camera_choice.hpp>

namespace chasles {
namespace {

constexpr const char* kExpected =
    "expected mono, stereo, or the numbers of different cameras between commas, as in 0,2,3";

[[noreturn]] void reject_choice(const std::string& text, const std::string& found) {
  throw UsageError(fmt::format("--cameras: found '{}'{}, {}", text, found, kExpected));
}

std::vector<std::size_t> numbers_in(const std::string& text) {
  std::vector<std::size_t> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string number = text.substr(begin, end - begin);
    const bool digits = !number.empty() && number.size() <= 3 &&
                        std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
    if (!digits) reject_choice(text, "");
    numbers.push_back(std::stoul(number));
    begin = end + 1;
  }
  return numbers;
}

// The place of a camera among those that were read. Without a list they are all there.
std::size_t place_of_camera(const Recording& r, std::size_t camera) {
  if (r.camera_numbers.empty()) {
    if (camera < r.cameras.size()) return camera;
  } else {
    const auto place = std::ranges::find(r.camera_numbers, camera);
    if (place != r.camera_numbers.end()) {
      return static_cast<std::size_t>(place - r.camera_numbers.begin());
    }
    throw UsageError(fmt::format("--cameras: camera {} of {} has no images, expected some of {}",
                                 camera, r.name, fmt::join(r.camera_numbers, ", ")));
  }
  throw UsageError(fmt::format(
      "--cameras: there is no camera {}: {} has {} single cameras, expected at least {}", camera,
      r.name, r.cameras.size(), camera + 1));
}

void choose_tracks_of(const std::vector<std::size_t>& places, FeatureFrame& frame) {
  std::erase_if(frame.pixels, [&](PixelObservation& o) {
    const auto place = std::ranges::find(places, static_cast<std::size_t>(o.camera));
    if (place == places.end()) return true;
    o.camera = static_cast<int>(place - places.begin());
    return false;
  });
}

// The camera that finds a track may be left out.
void clear_missing_finders(FeatureFrame& frame) {
  std::set<LandmarkId> found;
  for (const PixelObservation& o : frame.pixels) {
    if (o.match && !*o.match) found.insert(o.landmark);
  }
  for (PixelObservation& o : frame.pixels) {
    if (!found.contains(o.landmark)) o.match.reset();
  }
}

}  // namespace

std::optional<std::vector<std::size_t>> camera_choice(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text == "mono") return std::vector<std::size_t>{0};
  if (text == "stereo") return std::vector<std::size_t>{0, 1};
  std::vector<std::size_t> numbers = numbers_in(text);
  const std::set<std::size_t> different(numbers.begin(), numbers.end());
  if (different.size() < numbers.size()) reject_choice(text, ", which has a camera twice");
  if (numbers.size() > kMostCameras) {
    reject_choice(text, fmt::format(", which are more than {} cameras", kMostCameras));
  }
  return numbers;
}

std::size_t cameras_to_read(const std::optional<std::vector<std::size_t>>& choice) {
  return choice ? std::ranges::max(*choice) + 1 : kAllCameras;
}

void choose_cameras(Recording& r, const std::vector<std::size_t>& choice) {
  std::vector<std::size_t> places;
  for (const std::size_t camera : choice) places.push_back(place_of_camera(r, camera));
  std::vector<Camera> cameras;
  for (const std::size_t place : places) cameras.push_back(r.cameras[place]);
  const bool changes = !std::ranges::is_sorted(places) || places.back() + 1 != places.size();
  r.cameras = std::move(cameras);
  if (changes || !r.camera_numbers.empty()) r.camera_numbers = choice;
  for (FeatureFrame& frame : r.frames) {
    const std::size_t before = frame.pixels.size();
    choose_tracks_of(places, frame);
    if (changes) std::ranges::stable_sort(frame.pixels, {}, &PixelObservation::camera);
    if (frame.pixels.size() < before) clear_missing_finders(frame);
  }
  if (!r.images) return;
  r.images = changes ? chosen_cameras(r.images, places)
                     : part_of(r.images, Time::min(), Time::max(), places.size());
  if (r.images->size() > 0) return;
  throw UsageError(fmt::format(
      "--cameras: no frame of {} has an image of camera {}; expected cameras that were recorded "
      "together with camera 0",
      r.name, fmt::join(choice, ", ")));
}

}  // namespace chasles
