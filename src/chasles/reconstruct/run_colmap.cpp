#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/reconstruct/keyframes.hpp>
#include <chasles/reconstruct/later_poses.hpp>
#include <chasles/reconstruct/recording_of_run.hpp>
#include <chasles/reconstruct/run_colmap.hpp>
#include <chasles/reconstruct/sharpness.hpp>
#include <chasles/reconstruct/sparse_points.hpp>
#include <chasles/reconstruct/track_again.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/viewers/path_at_frames.hpp>
#include <chasles/viewers/posed_images.hpp>

namespace chasles {
namespace {

// The file of each image, by camera of the run and by time.
using ImageNames = std::vector<std::map<Time, std::string>>;

std::string name_of_image(const std::filesystem::path& file, const std::filesystem::path& folder) {
  return std::filesystem::relative(file, folder).generic_string();
}

ImageNames image_names(const Recording& recording, const std::vector<std::size_t>& cameras,
                       const std::filesystem::path& folder) {
  ImageNames names;
  for (const std::size_t camera : cameras) {
    const CameraImages images = camera_images(recording, camera);
    auto& of_camera = names.emplace_back();
    for (std::size_t i = 0; i < images.stamps.size(); ++i) {
      of_camera.emplace(images.stamps[i], name_of_image(images.files[i], folder));
    }
  }
  return names;
}

// Those that will be written.
ImageNames made_names(const Recording& recording, const std::vector<std::size_t>& cameras) {
  ImageNames names(cameras.size());
  for (std::size_t i = 0; i < recording.images->size(); ++i) {
    const Time time = recording.images->time(i);
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      if (!recording.images->has_image(i, c)) continue;
      names[c].emplace(time, fmt::format("cam{}/{}", cameras[c], image_name(time)));
    }
  }
  return names;
}

// Moves the tracks to where they are in undistorted images.
void undistort(const std::vector<Undistortion>& lenses, std::vector<TrackedImages>& tracked) {
  for (TrackedImages& images : tracked) {
    std::erase_if(images.pixels, [&](TrackedPixel& p) {
      const auto moved = lenses[p.camera].pixel(p.pixel);
      if (moved) p.pixel = *moved;
      return !moved;
    });
  }
}

// The images of the model's frames, which have these times.
UndistortedImages undistorted_images(const Recording& recording, std::vector<Undistortion> lenses,
                                     const std::vector<PosedTracks>& keyframes,
                                     const ColmapModel& model) {
  UndistortedImages images(recording.images, std::move(lenses));
  std::size_t index = 0;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    while (recording.images->time(index) < keyframes[k].images->time) ++index;
    for (const ColmapImage& image : model.frames[k].images) {
      images.want(index, image.camera, "images/" + image.name);
    }
  }
  return images;
}

// A frame with tracks and a pose.
struct PosedFrame {
  PosedTracks tracks;
  Matrix6d pose_covariance = Matrix6d::Zero();
};

std::vector<PosedFrame> posed_frames(const ReportRun& run, RunPath path,
                                     const std::vector<TrackedImages>& tracked,
                                     const Camera& first) {
  std::vector<Time> stamps;
  for (const TrackedImages& images : tracked) stamps.push_back(images.time);
  const auto poses = poses_at_frames(run, path, stamps);
  const LaterPoses middle(run.run, path, first.shutter.readout / 2);
  std::vector<PosedFrame> frames;
  for (std::size_t i = 0; i < tracked.size(); ++i) {
    const auto pose = poses[i] ? middle.after(*poses[i]) : std::nullopt;
    if (!pose) continue;
    frames.push_back({.tracks = {.images = &tracked[i], .world_T_imu = *pose},
                      .pose_covariance = poses[i]->pose_covariance});
  }
  return frames;
}

std::vector<std::size_t> keyframes_of(const std::vector<PosedFrame>& frames,
                                      const ColmapSettings& settings) {
  std::vector<double> sharp;
  for (const PosedFrame& frame : frames) sharp.push_back(frame.tracks.images->sharpness);
  sharp = relative_sharpness(sharp);
  std::vector<KeyframeCandidate> candidates;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const PosedTracks& tracks = frames[i].tracks;
    KeyframeCandidate& candidate = candidates.emplace_back(
        KeyframeCandidate{.world_T_imu = tracks.world_T_imu, .sharpness = sharp[i]});
    for (const TrackedPixel& p : tracks.images->pixels) candidate.tracks.push_back(p.track);
    std::ranges::sort(candidate.tracks);
    candidate.tracks.erase(std::unique(candidate.tracks.begin(), candidate.tracks.end()),
                           candidate.tracks.end());
  }
  return choose_keyframes(candidates, settings);
}

// The frame with its images; those of a camera that has none are missing.
ColmapFrame empty_frame(const PosedFrame& frame, const ImageNames& names) {
  ColmapFrame empty{.world_T_imu = frame.tracks.world_T_imu,
                    .pose_covariance = frame.pose_covariance};
  for (std::size_t camera = 0; camera < names.size(); ++camera) {
    const auto name = names[camera].find(frame.tracks.images->time);
    if (name != names[camera].end()) {
      empty.images.push_back({.camera = camera, .name = name->second});
    }
  }
  return empty;
}

void check_has_images(const Recording& recording) {
  if (recording.images) return;
  throw InputError(
      fmt::format("recording '{}' has no images, expected the run's recording", recording.name));
}

void add_points(SparsePoints points, ColmapModel& model) {
  model.points = std::move(points.points);
  for (const SparsePoints::Observation& o : points.observations) {
    auto& images = model.frames[o.keyframe].images;
    std::ranges::find(images, o.camera, &ColmapImage::camera)
        ->observations.push_back({.pixel = o.pixel, .point = o.point});
  }
}

std::string remark_of(const SparsePoints& points, std::size_t keyframes, std::size_t frames) {
  double errors = 0;
  for (const ColmapPoint& point : points.points) errors += point.error;
  return fmt::format(
      "{} keyframes of {} frames with a pose; {} points with {} observations, mean reprojection "
      "error {:.2f} px. Tracks that are no point: {} with fewer than min_observations, {} with "
      "less than min_parallax or not in front of the cameras, {} with more than max_error",
      keyframes, frames, points.points.size(), points.observations.size(),
      errors / static_cast<double>(std::max<std::size_t>(points.points.size(), 1)),
      points.too_short, points.too_uncertain, points.too_wrong);
}

}  // namespace

RunColmap run_colmap(const ReportRun& run, RunPath path, Recording recording,
                     const ModelImages& images, const ColmapSettings& settings) {
  const std::vector<std::size_t> numbers = cameras_of_run(run.summary);
  check_has_images(recording);
  ImageNames names;
  if (!images.undistort) names = image_names(recording, numbers, images.folder);
  const InertialRunSettings run_settings = inertial_run_settings_of(run.summary);
  recording = as_in_run(std::move(recording), run.summary, run_settings);
  std::vector<TrackedImages> tracked = track_again(recording, run.run, run_settings.frontend);
  std::vector<Undistortion> lenses;
  if (images.undistort) {
    names = made_names(recording, numbers);
    lenses = undistortions(recording.cameras);
    undistort(lenses, tracked);
    std::ranges::transform(lenses, recording.cameras.begin(), &Undistortion::pinhole);
  }
  const auto frames = posed_frames(run, path, tracked, recording.cameras.front());
  RunColmap result{.model = {.cameras = recording.cameras, .is_level = is_level(run.run)}};
  std::vector<PosedTracks> keyframes;
  for (const std::size_t i : keyframes_of(frames, settings)) {
    keyframes.push_back(frames[i].tracks);
    result.model.frames.push_back(empty_frame(frames[i], names));
  }
  SparsePoints points = sparse_points(keyframes, recording.cameras, settings);
  const std::string remark = remark_of(points, keyframes.size(), frames.size());
  if (points.points.empty()) {
    throw InputError(fmt::format("run '{}': no track is a point: {}", run.run.name, remark));
  }
  result.remarks.push_back(remark);
  add_points(std::move(points), result.model);
  if (images.undistort) {
    result.images = undistorted_images(recording, std::move(lenses), keyframes, result.model);
  }
  return result;
}

}  // namespace chasles
