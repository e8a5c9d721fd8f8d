#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/sim/street_drive.hpp>
#include <chasles/sim/street_tracks.hpp>
#include <chasles/sim/street_world.hpp>

namespace chasles {
namespace {

constexpr double kMostStreetSamples = 1e6;

// The number of frames: the first at time 0, none after the end of the motion.
std::uint64_t count_frames(const StreetSettings& settings, double duration) {
  const double frames = std::floor(duration * settings.frame_rate) + 1;
  const double samples = frames * settings.velocities_per_frame;
  if (samples > kMostStreetSamples) {
    throw UsageError(fmt::format(
        "simulation setting frame_rate = {} Hz: a run of {:.0f} s with {} velocities a frame has "
        "{:.3g} samples; expected at most {:.0g}",
        settings.frame_rate, duration, settings.velocities_per_frame, samples, kMostStreetSamples));
  }
  return static_cast<std::uint64_t>(frames);
}

Eigen::Vector3d noise(const Random& random, Stream stream, std::uint64_t index, double sigma) {
  return sigma * Eigen::Vector3d(random.normal(stream, index, 0), random.normal(stream, index, 1),
                                 random.normal(stream, index, 2));
}

std::vector<BodyVelocity> measure_velocities(const StreetSettings& settings,
                                             const StreetDrive& drive, std::uint64_t count) {
  const Random random{settings.seed};
  const double rate = settings.frame_rate * settings.velocities_per_frame;
  const Eigen::Vector3d bias(settings.gyro_bias_x, settings.gyro_bias_y, settings.gyro_bias_z);
  std::vector<BodyVelocity> velocities;
  velocities.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const Time time = from_seconds(static_cast<double>(i) / rate);
    const DriveState state = state_at(drive, to_seconds(time));
    velocities.push_back(
        {.time = time,
         .linear_imu = settings.velocity_scale * state.linear_imu +
                       noise(random, Stream::kLinearNoise, i, settings.linear_sigma),
         .angular_imu = state.angular_imu + bias +
                        noise(random, Stream::kAngularNoise, i, settings.angular_sigma)});
  }
  return velocities;
}

bool is_outlier(const StreetSettings& settings, LandmarkId id, std::uint32_t frame) {
  return Random{settings.seed}.uniform(Stream::kOutlier, static_cast<std::uint64_t>(id),
                                       5 * frame) < settings.outlier_fraction;
}

// The reported pixels of the visible landmarks.
Eigen::Vector4d measure_pixels(const StreetSettings& settings, const StreetTrack& track,
                               std::uint32_t frame) {
  const Random random{settings.seed};
  const auto index = static_cast<std::uint64_t>(track.id);
  const Eigen::Vector4d size(settings.image_width, settings.image_height, settings.image_width,
                             settings.image_height);
  const bool outlier = is_outlier(settings, track.id, frame);
  Eigen::Vector4d pixels = track.pixels;
  for (std::uint32_t i = 0; i < 4; ++i) {
    if (outlier) {
      pixels[i] = size[i] * random.uniform(Stream::kOutlier, index, 5 * frame + 1 + i);
    } else {
      pixels[i] += settings.pixel_sigma * random.normal(Stream::kPixelNoise, index, 4 * frame + i);
    }
  }
  if (!outlier)
    pixels[2] -= settings.disparity_sigma * random.normal(Stream::kDisparityError, index);
  return pixels;
}

struct Counts {
  std::size_t observations = 0, outliers = 0, dropped = 0, moving = 0;
};

FeatureFrame measure_frame(const StreetSettings& settings, const Tracks& tracks, Time time,
                           std::uint64_t number, Counts& counts) {
  const auto frame = static_cast<std::uint32_t>(number);
  FeatureFrame result{.time = time, .observations = {}};
  result.observations.reserve(tracks.alive.size());
  for (const StreetTrack& track : tracks.alive) {
    result.observations.push_back(
        {.landmark = track.id, .pixels = measure_pixels(settings, track, frame)});
    counts.outliers += is_outlier(settings, track.id, frame);
  }
  counts.observations += tracks.alive.size();
  return result;
}

std::vector<TrueLandmark> standing(const std::vector<StreetTrack>& born, Counts& counts) {
  std::vector<TrueLandmark> landmarks;
  for (const StreetTrack& track : born) {
    if (track.v_world.isZero(0)) {
      landmarks.push_back({.id = track.id, .p_world = track.p_world});
    } else {
      ++counts.moving;
    }
  }
  return landmarks;
}

}  // namespace

StereoRig make_street_rig(const StreetSettings& settings) {
  Eigen::Matrix3d imu_R_straight;  // a camera along x: its right is -y, its down is -z
  imu_R_straight << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Vector3d tilt(settings.camera_tilt_x, settings.camera_tilt_y,
                             settings.camera_tilt_z);
  const SE3 imu_T_cam0{so3::exp(tilt) * imu_R_straight,
                       {settings.camera_x, settings.camera_y, settings.camera_z}};
  return {.fx = settings.focal_length,
          .fy = settings.focal_length,
          .cx = settings.center_u,
          .cy = settings.center_v,
          .baseline = settings.baseline,
          .cam0_T_imu = imu_T_cam0.inverse()};
}

Recording simulate_street(const StreetSettings& settings) {
  validate(settings);
  const StreetDrive drive = make_street_drive(settings);
  const StreetWorld world = make_street_world(settings, drive);
  const std::uint64_t count = count_frames(settings, drive.duration);

  Recording recording;
  recording.name = settings.name;
  recording.rig = make_street_rig(settings);
  const auto per_frame = static_cast<std::uint64_t>(settings.velocities_per_frame);
  recording.velocities = measure_velocities(settings, drive, (count - 1) * per_frame + 1);

  const StreetView view{settings, drive, world, recording.rig};
  Tracks tracks;
  Counts counts;
  for (std::uint64_t i = 0; i < count; ++i) {
    interruption_point(i, count);
    const Time time = from_seconds(static_cast<double>(i) / settings.frame_rate);
    recording.truth.push_back(
        {.time = time, .pose = state_at(drive, to_seconds(time)).world_T_imu});
    if (Random{settings.seed}.uniform(Stream::kDropped, i) < settings.dropped_fraction) {
      tracks.alive.clear();
      ++counts.dropped;
    } else {
      follow(tracks, view, i, to_seconds(time));
    }
    recording.frames.push_back(measure_frame(settings, tracks, time, i, counts));
  }
  recording.true_landmarks = standing(tracks.born, counts);
  // Stated as in a data sheet: the white noise, and only if there is any.
  if (settings.linear_sigma > 0 && settings.angular_sigma > 0) {
    recording.velocity_sigma =
        BodyVelocitySigma{.linear = Eigen::Vector3d::Constant(settings.linear_sigma),
                          .angular = Eigen::Vector3d::Constant(settings.angular_sigma)};
  }
  if (settings.pixel_sigma > 0) {
    recording.pixel_sigma = Eigen::Vector4d::Constant(settings.pixel_sigma);
  }
  recording.remarks.push_back(fmt::format(
      "simulated with seed {}: {:.1f} m in {:.1f} s, {} of {} observations are outliers, {} of {} "
      "landmarks move, {} of {} frames were dropped",
      settings.seed, drive.path.length, to_seconds(recording.truth.back().time), counts.outliers,
      counts.observations, counts.moving, tracks.born.size(), counts.dropped, count));
  return recording;
}

}  // namespace chasles
