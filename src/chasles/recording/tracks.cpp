#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/recording/tracks.hpp>

namespace chasles {
namespace {

constexpr double kMissing = -1;
constexpr std::size_t kBytesOfPoint = 400;  // in this table, then in the frames

bool stands_before(const TrackPoint& a, const TrackPoint& b) {
  return a.track != b.track ? a.track < b.track : a.frame < b.frame;
}

bool repeats(const TrackPoint& point, const TrackPoint& before) {
  return point.track == before.track && point.frame == before.frame + 1 &&
         point.pixels == before.pixels;
}

// Whether point i is an isolated repetition.
bool is_stale(const std::vector<TrackPoint>& points, std::size_t i) {
  if (i == 0 || !repeats(points[i], points[i - 1])) return false;
  const bool before = i >= 2 && repeats(points[i - 1], points[i - 2]);
  const bool after = i + 1 < points.size() && repeats(points[i + 1], points[i]);
  return !before && !after;
}

/// Counts of what make_frames() left out.
struct LeftOut {
  std::size_t stale = 0;         // observations
  std::size_t not_positive = 0;  // disparities
  std::set<std::uint32_t> stale_frames;
};

void remark(const TrackTable& table, const std::vector<FeatureFrame>& frames, const LeftOut& left,
            std::vector<std::string>& remarks) {
  if (table.partial > 0) {
    remarks.push_back(fmt::format(
        "{} observations have some of their four numbers missing (-1): left out", table.partial));
  }
  if (left.stale > 0) {
    remarks.push_back(fmt::format(
        "{} observations in {} frames repeat the numbers of the frame before exactly: left out as "
        "stale, their tracks go on as new landmarks",
        left.stale, left.stale_frames.size()));
  }
  if (left.not_positive > 0) {
    remarks.push_back(
        fmt::format("{} of {} observations have a disparity that is not positive: left out",
                    left.not_positive, table.points.size()));
  }
  const auto empty = std::count_if(frames.begin(), frames.end(),
                                   [](const FeatureFrame& f) { return f.observations.empty(); });
  if (empty > 0) {
    remarks.push_back(fmt::format("{} of {} frames have no observation", empty, frames.size()));
  }
}

}  // namespace

TrackCollector::TrackCollector(std::size_t tracks, std::size_t frames, Order order,
                               std::string where)
    : table_{.tracks = tracks, .frames = frames, .points = {}},
      order_(order),
      where_(std::move(where)),
      most_points_(read_budget().bytes / kBytesOfPoint) {}

void TrackCollector::fail_not_finite(std::size_t pixel, std::size_t track, std::size_t frame,
                                     double value) const {
  const bool frame_first = order_ == Order::kTrackFramePixel;
  throw InputError(fmt::format(
      "{}: value {} at index [{}, {}, {}] (number {} of track {} in frame {}), expected finite "
      "pixels, or -1 without an observation",
      where_, value, pixel, frame_first ? frame : track, frame_first ? track : frame, pixel, track,
      frame));
}

void TrackCollector::add(std::span<const double> values) {
  order_ == Order::kPixelTrackFrame ? add_plane(values) : add_points(values);
}

void TrackCollector::keep(std::size_t track, std::size_t frame, const Eigen::Vector4d& pixels) {
  if (table_.points.size() == most_points_) {
    check_memory(fmt::format("{}: has more than {} observations", where_, most_points_),
                 (most_points_ + 1) * kBytesOfPoint);
  }
  table_.points.push_back({.track = static_cast<std::uint32_t>(track),
                           .frame = static_cast<std::uint32_t>(frame),
                           .pixels = pixels});
}

// The numbers belong to one or more of the four planes; the first plane determines which points
// exist.
void TrackCollector::add_plane(std::span<const double> values) {
  const std::size_t plane_size = table_.tracks * table_.frames;
  while (!values.empty()) {
    const std::size_t begin = position_ % plane_size;
    const auto piece = values.first(std::min(values.size(), plane_size - begin));
    if (position_ < plane_size) {
      begin_points(piece, begin);
    } else {
      if (begin == 0) next_ = 0;
      fill_points(piece, begin, position_ / plane_size);
    }
    position_ += piece.size();
    values = values.subspan(piece.size());
  }
}

void TrackCollector::begin_points(std::span<const double> piece, std::size_t begin) {
  for (std::size_t k = 0; k < piece.size(); ++k) {
    if (piece[k] == kMissing) continue;
    const std::size_t track = (begin + k) / table_.frames, frame = (begin + k) % table_.frames;
    if (!std::isfinite(piece[k])) fail_not_finite(0, track, frame, piece[k]);
    keep(track, frame, Eigen::Vector4d(piece[k], 0, 0, 0));
  }
}

void TrackCollector::fill_points(std::span<const double> piece, std::size_t begin,
                                 std::size_t pixel) {
  for (; next_ < table_.points.size(); ++next_) {
    TrackPoint& point = table_.points[next_];
    const std::size_t flat = point.track * table_.frames + point.frame;
    if (flat >= begin + piece.size()) return;
    const double value = piece[flat - begin];
    if (!std::isfinite(value)) fail_not_finite(pixel, point.track, point.frame, value);
    point.pixels[static_cast<Eigen::Index>(pixel)] = value;
  }
}

void TrackCollector::add_points(std::span<const double> values) {
  const std::size_t fast = order_ == Order::kFrameTrackPixel ? table_.tracks : table_.frames;
  for (const double value : values) {
    const std::size_t pixel = position_ % 4;
    pixels_[static_cast<Eigen::Index>(pixel)] = value;
    ++position_;
    if (pixel != 3 || (pixels_.array() == kMissing).all()) continue;
    const std::size_t entry = position_ / 4 - 1;
    std::size_t track = entry / fast, frame = entry % fast;
    if (order_ == Order::kFrameTrackPixel) std::swap(track, frame);
    for (std::size_t k = 0; k < 4; ++k) {
      const double number = pixels_[static_cast<Eigen::Index>(k)];
      if (!std::isfinite(number)) fail_not_finite(k, track, frame, number);
    }
    keep(track, frame, pixels_);
  }
}

TrackTable TrackCollector::finish() && {
  auto& points = table_.points;
  table_.partial = std::erase_if(
      points, [](const TrackPoint& point) { return (point.pixels.array() == kMissing).any(); });
  if (order_ == Order::kFrameTrackPixel) std::sort(points.begin(), points.end(), stands_before);
  return std::move(table_);
}

std::vector<FeatureFrame> make_frames(const TrackTable& table, const std::vector<Time>& times,
                                      StalePixels stale_pixels, std::vector<std::string>& remarks) {
  std::vector<FeatureFrame> frames(times.size());
  for (std::size_t k = 0; k < times.size(); ++k) frames[k].time = times[k];
  LeftOut left;
  std::size_t segment = 0;
  const auto& points = table.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TrackPoint& point = points[i];
    if (i == 0 || point.track != points[i - 1].track) segment = 0;
    if (stale_pixels == StalePixels::kCut && is_stale(points, i)) {
      ++left.stale;
      ++segment;
      left.stale_frames.insert(point.frame);
    } else if (!(point.pixels[0] - point.pixels[2] > 0)) {
      ++left.not_positive;
    } else {
      const auto landmark = static_cast<LandmarkId>(point.track + segment * table.tracks);
      frames[point.frame].observations.push_back({.landmark = landmark, .pixels = point.pixels});
    }
  }
  for (FeatureFrame& frame : frames) {
    std::sort(frame.observations.begin(), frame.observations.end(),
              [](const auto& a, const auto& b) { return a.landmark < b.landmark; });
  }
  remark(table, frames, left, remarks);
  return frames;
}

}  // namespace chasles
