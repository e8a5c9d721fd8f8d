#include <algorithm>
#include <atomic>
#include <mutex>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/in_parallel.hpp>
#include <chasles/calibrate/capture_guide.hpp>
#include <chasles/calibrate/recorded_views.hpp>
#include <chasles/calibrate/target_images.hpp>

namespace chasles {
namespace {

constexpr std::size_t kCornersOfPose = 4;

// What a frame shows.
struct FrameViews {
  std::vector<TargetView> views;
  std::vector<double> blur;
  std::vector<std::string> lacks, damaged;
};

void add(TargetDetection found, Time time, std::size_t camera, FrameViews& result) {
  if (found.view.ids.empty()) return;
  found.view.time = time;
  found.view.camera = static_cast<int>(camera);
  result.views.push_back(std::move(found.view));
  result.blur.push_back(found.blur);
  result.lacks.push_back(std::move(found.lack));
}

// What is known of each image of a frame; null: nothing.
std::vector<const TargetDetection*> known_of(const Recording& recording, std::size_t index,
                                             const ViewOptions& options) {
  std::vector<const TargetDetection*> known(recording.cameras.size(), nullptr);
  for (std::size_t c = 0; options.known && c < known.size(); ++c) {
    const std::filesystem::path file = target_image_file(*recording.images, index, c);
    if (!file.empty()) known[c] = options.known(file);
  }
  return known;
}

// Sources are read by one thread at a time.
FrameViews detected(const Recording& recording, std::mutex& reading, std::size_t index,
                    const TargetDetector& detector, const ViewOptions& options) {
  FrameViews result;
  const ImageSource& images = *recording.images;
  const std::vector<const TargetDetection*> known = known_of(recording, index, options);
  std::vector<std::size_t> unknown;
  for (std::size_t c = 0; c < known.size(); ++c) {
    if (!known[c]) unknown.push_back(c);
  }
  ImageFrame frame;
  if (!unknown.empty()) {
    const std::lock_guard lock(reading);
    frame = images.read_chosen(
        index, unknown, [&](const InputError& error) { result.damaged.push_back(error.what()); });
  }
  std::size_t next = 0;
  for (std::size_t c = 0; c < known.size(); ++c) {
    if (known[c]) {
      add(*known[c], images.time(index), c, result);
    } else if (const GrayImage& image = frame.images[next++]; !image.empty()) {
      add(detector.detect(image), images.time(index), c, result);
    }
  }
  return result;
}

// The frames, in any order by several threads.
std::vector<FrameViews> detected_all(const Recording& recording, const Target& target,
                                     const ViewOptions& options) {
  const TargetDetector detector(target);
  std::vector<FrameViews> frames(searched_frames(recording, options));
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stop = false;
  std::mutex reading;
  in_parallel(frames.size(), options.threads, [&](std::size_t i) {
    if (stop) return;
    frames[i] = detected(recording, reading, i * static_cast<std::size_t>(options.every), detector,
                         options);
    if (const std::size_t count = ++done; options.progress && !options.progress(count)) {
      stop = true;
    }
  });
  return frames;
}

std::vector<FrameViews> tracked(const Recording& recording, const Target& target,
                                const ViewOptions& options) {
  const std::size_t corners = target.corners().size();
  std::vector<FrameViews> frames;
  for (std::size_t i = 0; i < recording.frames.size();
       i += static_cast<std::size_t>(options.every)) {
    const FeatureFrame& frame = recording.frames[i];
    FrameViews result;
    std::vector<PixelObservation> pixels = frame.pixels;
    std::ranges::stable_sort(
        pixels, {}, [](const PixelObservation& o) { return std::pair(o.camera, o.landmark); });
    for (const PixelObservation& o : pixels) {
      if (o.landmark < 0 || static_cast<std::size_t>(o.landmark) >= corners) {
        throw InputError(fmt::format(
            "{}: found a track of landmark {} at {:.3f} s, expected ids of corners from 0 to {}: "
            "are these tracks the corners of this target?",
            recording.name, o.landmark, to_seconds(frame.time), corners - 1));
      }
      if (result.views.empty() || result.views.back().camera != o.camera) {
        result.views.push_back({frame.time, o.camera, {}, {}});
        result.blur.push_back(kNaN);
        result.lacks.emplace_back();
      }
      result.views.back().ids.push_back(static_cast<int>(o.landmark));
      result.views.back().pixels.push_back(o.pixel);
    }
    frames.push_back(std::move(result));
    if (options.progress && !options.progress(frames.size())) break;
  }
  return frames;
}

}  // namespace

std::size_t searched_frames(const Recording& recording, const ViewOptions& options) {
  const auto every = static_cast<std::size_t>(options.every);
  const std::size_t all = recording.images ? recording.images->size() : recording.frames.size();
  return (all + every - 1) / every;
}

RecordedViews recorded_views(const Recording& recording, const Target& target,
                             const ViewOptions& options) {
  if (!recording.images && recording.frames.empty()) {
    throw InputError(fmt::format("{}: found no images and no tracks of corners", recording.name));
  }
  std::vector<FrameViews> frames = recording.images ? detected_all(recording, target, options)
                                                    : tracked(recording, target, options);
  RecordedViews result{.views = {},
                       .frames = frames.size(),
                       .seen = std::vector<std::size_t>(recording.cameras.size(), 0),
                       .blur = {},
                       .lacks = {},
                       .damaged = {}};
  for (FrameViews& frame : frames) {
    for (const TargetView& view : frame.views) {
      if (view.ids.size() >= kCornersOfPose) ++result.seen[static_cast<std::size_t>(view.camera)];
    }
    std::ranges::move(frame.views, std::back_inserter(result.views));
    std::ranges::move(frame.blur, std::back_inserter(result.blur));
    std::ranges::move(frame.lacks, std::back_inserter(result.lacks));
    std::ranges::move(frame.damaged, std::back_inserter(result.damaged));
  }
  return result;
}

std::vector<std::string> blurred_views(const RecordedViews& views) {
  std::vector<BlurCount> counts(views.seen.size());
  for (std::size_t i = 0; i < views.views.size(); ++i) {
    counts[static_cast<std::size_t>(views.views[i].camera)].add(views.blur[i]);
  }
  std::vector<std::string> sentences;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    if (std::string one = counts[c].sentence(c); !one.empty()) sentences.push_back(std::move(one));
  }
  return sentences;
}

}  // namespace chasles
