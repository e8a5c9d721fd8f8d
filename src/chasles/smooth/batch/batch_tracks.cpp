#include <algorithm>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include <chasles/smooth/batch/batch_graph_detail.hpp>

namespace chasles::smooth_detail {
namespace {

using ByLandmark = std::map<LandmarkId, std::vector<PointView>>;

// Collects the keyframes and their observations.
class Collector {
 public:
  Collector(const InertialBatchInput& input, const BatchSettings& settings, Time last_sample,
            BatchReport& report)
      : input_(input),
        settings_(settings),
        last_sample_(last_sample),
        report_(report),
        choice_(input, settings, report.dropped_frames) {
    result_.keyframes.push_back({.time = input.start.time});
  }

  void add(const FeatureFrame& frame) {
    const std::optional<Time> time = choice_.take(frame, last_sample_);
    if (!time) return;
    if (*time > result_.keyframes.back().time) result_.keyframes.push_back({.time = *time});
    keep(frame);
  }

  Tracked end() {
    for (auto& [id, views] : tracks_) finish(id, views);
    // By their first views, so that neighbours in time are neighbours in memory.
    std::ranges::stable_sort(result_.points, {}, [](const BatchPoint& p) {
      return std::tuple(p.views.front().keyframe, p.id);
    });
    return std::move(result_);
  }

 private:
  void keep(const FeatureFrame& frame) {
    const int now = result_.keyframes.last();
    for (const PixelObservation& o : usable(frame, input_.cameras, report_.unusable)) {
      std::vector<PointView>& views = tracks_[o.landmark];
      const auto camera = static_cast<std::size_t>(o.camera);
      if (!settings_.loops && !views.empty() && views.back().keyframe < last_observed_[camera]) {
        finish(o.landmark, views);
        views.clear();
      }
      views.push_back(
          {.keyframe = now, .camera = o.camera, .pixel = o.pixel, .match = o.is_match()});
    }
    const CameraSet looking = observing(frame);
    for (std::size_t c = 0; c < last_observed_.size(); ++c) {
      if ((looking & camera_bit(static_cast<int>(c))) != 0) last_observed_[c] = now;
    }
  }

  void finish(LandmarkId id, std::vector<PointView>& views) {
    if (views.size() < 2) {
      ++report_.landmarks_left_out;
    } else {
      result_.points.push_back({.id = id, .views = views});
    }
  }

  const InertialBatchInput& input_;
  const BatchSettings& settings_;
  Time last_sample_;
  BatchReport& report_;
  Tracked result_;
  KeyframeChoice choice_;
  ByLandmark tracks_;
  // Of each camera, as they may take turns: the keyframe of its last frame with observations.
  std::vector<int> last_observed_ = std::vector<int>(input_.cameras.size(), -1);
};

}  // namespace

std::optional<Time> KeyframeChoice::take(const FeatureFrame& frame, Time last_sample) {
  const Time time = frame.time + input_.time_offset;
  if (time < input_.start.time) return std::nullopt;
  const bool later = !last_ || time > *last_;
  if (!later || time - last_sample > kLongestGap) {
    ++dropped_;
    return std::nullopt;
  }
  last_ = time;
  if (frames_++ % settings_.frames_per_keyframe != 0) return std::nullopt;
  return time;
}

std::vector<PixelObservation> usable(const FeatureFrame& frame, const std::vector<Camera>& cameras,
                                     int& unusable) {
  std::map<std::pair<LandmarkId, int>, int> times;
  for (const PixelObservation& o : frame.pixels) ++times[{o.landmark, o.camera}];
  std::vector<PixelObservation> good;
  for (const PixelObservation& o : frame.pixels) {
    const bool known = o.camera >= 0 && o.camera < static_cast<int>(cameras.size());
    if (known && o.pixel.allFinite() && times[{o.landmark, o.camera}] == 1 &&
        bearing(cameras[static_cast<std::size_t>(o.camera)], o.pixel)) {
      good.push_back(o);
    } else {
      ++unusable;
    }
  }
  std::ranges::sort(good, {},
                    [](const PixelObservation& o) { return std::tuple(o.landmark, o.camera); });
  return good;
}

Tracked track(const InertialBatchInput& input, const BatchSettings& settings, Time last_sample,
              BatchReport& report) {
  Collector collector(input, settings, last_sample, report);
  for (const FeatureFrame& frame : input.frames) collector.add(frame);
  return collector.end();
}

}  // namespace chasles::smooth_detail
