#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/camera/track_noise.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/sim/inertial_imu.hpp>
#include <chasles/sim/inertial_path.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_tracks.hpp>
#include <chasles/sim/inertial_world.hpp>
#include <chasles/sim/walk_path.hpp>

namespace chasles {
namespace {

constexpr double kMostFrames = 1e6;

// The poses at the frames' times: all of the motion, or what the real samples cover.
Trajectory poses_at_frames(const InertialScene& scene, const Spline& motion) {
  const double rate = scene.settings.frame_rate;
  const double count = std::floor((motion.duration + 0.5e-9) * rate) + 1;
  if (count > kMostFrames) {
    throw UsageError(fmt::format(
        "simulation setting frame_rate = {} Hz: {:.3g} frames in {:.0f} s; expected at most {:.0g}",
        rate, count, motion.duration, kMostFrames));
  }
  Trajectory poses;
  for (double i = 0; i < count; ++i) {
    const Time since = from_seconds(i / rate);
    const Time time = motion.start + since;
    if (!scene.imu.empty() && (time < scene.imu.front().time || time > scene.imu.back().time)) {
      continue;
    }
    poses.push_back({time, motion_at(motion, to_seconds(since)).world_T_imu});
  }
  if (poses.empty()) {
    throw UsageError("the scene's IMU samples and its path have no time in common");
  }
  return poses;
}

// Errors depend on the point and the frame only, and not on the other tracks.
std::uint64_t error_index(std::size_t point, std::size_t frame) {
  return std::uint64_t{point} << 32 | frame;
}

void add_errors(const InertialSettings& settings, const std::vector<Camera>& cameras,
                const Random& random, std::uint64_t index, PixelObservation& seen) {
  const auto component = 2 * static_cast<std::uint32_t>(seen.camera);
  const Camera& camera = cameras[static_cast<std::size_t>(seen.camera)];
  if (random.uniform(Stream::kOutlier, index, 2 * component) < settings.outlier_fraction) {
    seen.pixel = {camera.width * random.uniform(Stream::kOutlier, index, 2 * component + 1),
                  camera.height * random.uniform(Stream::kOutlier, index, 2 * component + 2)};
    return;
  }
  seen.pixel += settings.pixel_sigma *
                Eigen::Vector2d(random.normal(Stream::kPixelNoise, index, component),
                                random.normal(Stream::kPixelNoise, index, component + 1));
}

// The random walk of each track's pixels: zero at its first observation, one step per frame.
class TrackWalks {
 public:
  TrackWalks(double drift, const Random& random, std::size_t tracks)
      : drift_(drift), random_(random), walks_(drift > 0 ? tracks : 0) {}

  Eigen::Vector2d at(LandmarkId landmark, Time time, std::uint64_t index) {
    if (walks_.empty()) return Eigen::Vector2d::Zero();
    Walk& walk = walks_[static_cast<std::size_t>(landmark)];
    if (walk.latest && time > *walk.latest) {
      const double sigma = drift_ * std::sqrt(to_seconds(time - *walk.latest));
      walk.at += sigma * Eigen::Vector2d(random_.normal(Stream::kTrackDrift, index, 0),
                                         random_.normal(Stream::kTrackDrift, index, 1));
    }
    walk.latest = time;
    return walk.at;
  }

 private:
  struct Walk {
    std::optional<Time> latest;
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
  };

  double drift_;
  const Random& random_;
  std::vector<Walk> walks_;
};

Eigen::Vector2d match_error(double sigma, const Random& random, const PixelObservation& seen) {
  if (!seen.is_match()) return Eigen::Vector2d::Zero();
  const auto track = static_cast<std::uint64_t>(seen.landmark);
  return sigma * Eigen::Vector2d(random.normal(Stream::kMatchError, track, 0),
                                 random.normal(Stream::kMatchError, track, 1));
}

void add_errors(const InertialSettings& settings, const std::vector<Camera>& cameras,
                std::uint64_t run, InertialTracks& tracks) {
  const Random random = random_of_run(settings.seed, run);
  TrackWalks walks(settings.track_drift, random, tracks.points.size());
  for (std::size_t i = 0; i < tracks.frames.size(); ++i) {
    auto& pixels = tracks.frames[i].pixels;
    if (random.uniform(Stream::kDropped, i) < settings.dropped_fraction) pixels.clear();
    for (PixelObservation& seen : pixels) {
      const std::size_t point = tracks.points[static_cast<std::size_t>(seen.landmark)];
      seen.pixel += walks.at(seen.landmark, tracks.frames[i].time, error_index(point, i));
      seen.pixel += match_error(settings.match_sigma, random, seen);
      add_errors(settings, cameras, random, error_index(point, i), seen);
    }
  }
}

// The velocity of the instant and the biases of the latest sample.
std::vector<TrueMotion> motion_at_frames(const Trajectory& poses, const Spline& motion,
                                         const std::vector<TrueMotion>& samples) {
  std::vector<TrueMotion> result;
  for (const auto& [time, pose] : poses) {
    const auto next = std::ranges::upper_bound(samples, time, {}, &TrueMotion::time);
    TrueMotion now = *std::prev(next);
    now.time = time;
    now.v_world = motion_at(motion, to_seconds(time - motion.start)).v_world;
    result.push_back(now);
  }
  return result;
}

std::vector<TrueLandmark> observed_landmarks(const InertialTracks& tracks,
                                             const InertialWorld& world) {
  std::vector<bool> observed(tracks.points.size(), false);
  for (const FeatureFrame& frame : tracks.frames) {
    for (const auto& seen : frame.pixels) observed[static_cast<std::size_t>(seen.landmark)] = true;
  }
  std::vector<TrueLandmark> landmarks;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (!observed[i]) continue;
    landmarks.push_back({static_cast<LandmarkId>(i), world.points[tracks.points[i]]});
  }
  return landmarks;
}

void add_imu(const InertialScene& scene, const Spline& motion, std::uint64_t run,
             Recording& recording) {
  recording.imu_convention = scene.settings.imu_convention;
  recording.imu_noise = imu_noise(scene.settings);
  if (!scene.imu.empty()) {
    recording.imu = scene.imu;
    return;
  }
  SimulatedImu imu = simulate_imu(scene.settings, motion, run);
  recording.imu = std::move(imu.samples);
  recording.imu_noise->exact = true;
  recording.true_motion = motion_at_frames(recording.truth, motion, imu.truth);
}

}  // namespace

Spline inertial_motion(const InertialScene& scene) {
  const InertialSettings& settings = scene.settings;
  validate(settings);
  if (settings.geometry == Geometry::kHallway) {
    return fit_spline(hallway_path(settings), settings.knot_interval);
  }
  if (settings.geometry == Geometry::kTurntable) {
    return fit_spline(turntable_path(settings), settings.knot_interval);
  }
  if (settings.geometry == Geometry::kWalk) {
    return fit_spline(walk_path(settings), settings.knot_interval);
  }
  if (scene.path.empty()) {
    throw UsageError("the scene 'trajectory' needs the poses of a trajectory, and has none");
  }
  return fit_spline(scene.path, settings.knot_interval);
}

Recording simulate_sensors(const InertialScene& scene, const Spline& motion, std::uint64_t run) {
  const InertialSettings& settings = scene.settings;
  Recording recording;
  recording.name = settings.name;
  recording.cameras = scene.cameras.empty() ? make_cameras(settings) : scene.cameras;
  recording.truth = poses_at_frames(scene, motion);
  if (scene.imu.empty()) recording.truth_level = true;  // gravity is along its z axis
  if (settings.geometry == Geometry::kWalk) recording.plan = drawn_walk_plan(settings);
  add_imu(scene, motion, run, recording);
  return recording;
}

Recording simulate_inertial(const InertialScene& scene, std::uint64_t run) {
  const InertialSettings& settings = scene.settings;
  const Spline motion = inertial_motion(scene);
  Recording recording = simulate_sensors(scene, motion, run);
  recording.single_pixel_sigma = settings.pixel_sigma;
  const InertialWorld world = make_world(settings, motion, recording.cameras);
  InertialTracks tracks = follow(settings, world, recording.cameras, recording.truth, motion);
  add_errors(settings, recording.cameras, run, tracks);
  recording.true_landmarks = observed_landmarks(tracks, world);
  recording.frames = std::move(tracks.frames);
  return recording;
}

}  // namespace chasles
