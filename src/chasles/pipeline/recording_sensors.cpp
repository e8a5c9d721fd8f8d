#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/check/velocity_clock.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/recording/apply_calibration.hpp>

namespace chasles {
namespace {

// Observations of a landmark with an undelayed initialisation that count as one (docs/noise.md).
constexpr double kGuessedDepth = 20;
// Robust loss and gate of batch and window, in track_sigma. They assess a track against its
// scatter, which is far below it.
constexpr double kSmoothedLoss = 1, kSmoothedGate = 2;
// Data sheets state the noise of an IMU at a standstill.
constexpr double kImuInUse = 3;
// Of a readout, whose time and that of the frames are rounded.
constexpr double kLongestPartOfInterval = 1.02;

ImuNoise noise_of(const Recording& recording) {
  if (recording.imu_noise) return *recording.imu_noise;
  throw InputError(
      fmt::format("{}: states no IMU noise: write accelerometer_noise_density, "
                  "accelerometer_random_walk, gyroscope_noise_density and "
                  "gyroscope_random_walk into its calibration",
                  recording.name));
}

// A sensor reads out an image before it begins the next one.
void check_readout(const Recording& recording) {
  for (std::size_t i = 0; i < recording.cameras.size(); ++i) {
    const double readout = recording.cameras[i].shutter.readout;
    const auto interval = frame_interval(recording, i);
    if (!interval || readout <= *interval * kLongestPartOfInterval) continue;
    throw InputError(fmt::format(
        "{}: cam{} has a readout_time of {:.1f} ms, longer than the {:.1f} ms between its images; "
        "expected the time from the first line to the last, in seconds, of this mode of the camera",
        recording.name, i, 1e3 * readout, 1e3 * *interval));
  }
}

void check_recognition(const InertialRunSettings& settings, const Recording& recording) {
  if (settings.filter.recognise != Recognise::kAppearance) return;
  if (!recording.images) {
    throw UsageError(recording.name +
                     ": recognise=appearance needs images, and the recording has tracks alone: "
                     "expected none, or ids where a point has the same id whenever it is seen");
  }
  if (settings.estimator.is_window()) {
    throw UsageError(
        "recognise=appearance: a window keeps no past landmarks; expected the estimator filter or "
        "batch");
  }
}

}  // namespace

ImuBuffer::Options imu_options(const Recording& recording) {
  ImuBuffer::Options options{.convention = recording.imu_convention};
  const ImuRange range = range_of(recording);
  options.accelerometer_range = std::min(options.accelerometer_range, range.accelerometer);
  options.gyroscope_range = std::min(options.gyroscope_range, range.gyroscope);
  return options;
}

InertialSensors inertial_sensors(const Recording& recording) {
  if (recording.cameras.empty() && !recording.velocities.empty()) {
    throw InputError(
        recording.name +
        ": has body velocities and a rectified stereo pair, and no IMU samples with "
        "cameras; expected chasles::run(recording, chasles::VelocityRunSettings{}), or "
        "`chasles run`, which chooses by the recording");
  }
  if (recording.cameras.empty()) throw InputError(recording.name + ": has no camera");
  check_readout(recording);
  const double otherwise = recording.images ? kFrontendPixelSigma : 1;
  return {.cameras = recording.cameras,
          .noise = noise_of(recording),
          .imu = imu_options(recording),
          .pixel_sigma = recording.single_pixel_sigma.value_or(otherwise)};
}

InertialRunSettings for_images(InertialRunSettings settings, std::size_t cameras,
                               const ImuNoise& noise, bool exact_calibration) {
  InertialSlamSettings& filter = settings.filter;
  const bool can = filter.chart == kStandardChart.name || filter.chart == kRightSe3Chart.name ||
                   filter.chart == kRightSen3Chart.name;
  if (filter.keep_scale == Toggle::kAuto && cameras == 1 && can) filter.keep_scale = Toggle::kTrue;
  const bool filters = settings.estimator.is_filter();
  if (filters && filter.calibrate_time_offset == Calibrate::kAuto) {
    filter.calibrate_time_offset = Calibrate::kTrue;
  }
  const TrackNoise& real = filters ? kFrontendTrackNoise : kSmoothedTrackNoise;
  const bool rendered = noise.exact || exact_calibration;
  const TrackNoise& tracks = rendered ? kRenderedTrackNoise : real;
  if (!filter.track_drift) filter.track_drift = tracks.drift;
  if (!filter.match_sigma) filter.match_sigma = tracks.match;
  if (!filter.track_sigma && !filter.pixel_sigma) {
    filter.track_sigma = tracks.sigma;
    if (!rendered && !settings.batch.loss_width) settings.batch.loss_width = kSmoothedLoss;
    if (!rendered && !settings.batch.gate) settings.batch.gate = kSmoothedGate;
  }
  // The noise of rendered tracks stands for their walk: batch and window are consistent with it.
  if (rendered && !settings.batch.covariance_factor) settings.batch.covariance_factor = 1;
  if (!filter.guessed_depth_observations) filter.guessed_depth_observations = kGuessedDepth;
  if (!filter.imu_noise_scale) filter.imu_noise_scale = noise.exact ? 1 : kImuInUse;
  if (!filter.vibration_noise) filter.vibration_noise = noise.exact ? 0 : 1;
  return settings;
}

InertialRunSettings decided(InertialRunSettings settings, const Recording& recording) {
  check_recognition(settings, recording);
  Toggle& exact_map = settings.filter.exact_map;
  if (exact_map == Toggle::kAuto && settings.estimator.is_filter()) exact_map = Toggle::kTrue;
  if (!recording.images) return settings;
  std::optional<double>& pixel_sigma = settings.filter.pixel_sigma;
  if (!pixel_sigma) pixel_sigma = recording.single_pixel_sigma;
  return for_images(std::move(settings), cameras_in_stereo(recording.cameras), noise_of(recording),
                    recording.exact_calibration);
}

VelocitySensors velocity_sensors(const Recording& recording, const VelocityRunSettings& settings) {
  if (recording.velocities.empty() || !(recording.rig.fx > 0)) {
    throw InputError(
        fmt::format("{}: has {} body velocities and a stereo rig with a focal length "
                    "of {} px, expected both",
                    recording.name, recording.velocities.size(), recording.rig.fx));
  }
  return {.rig = recording.rig,
          .noise = choose_noise(
              settings.filter, recording.velocities, recording.frames,
              {.velocity = recording.velocity_sigma, .pixels = recording.pixel_sigma})};
}

ClockCorrection correct_clock(const VelocitySlamSettings& settings, Recording& recording) {
  ClockCorrection correction{.offset = settings.time_offset.value_or(0), .remark = {}};
  if (!settings.time_offset) {
    const std::optional<VelocityClock> clock = velocity_clock(recording);
    const bool corrected = clock && clock->stands_out();
    if (corrected) correction.offset = clock->offset;
    correction.remark =
        !clock || !clock->is_determined()
            ? "time_offset=auto: the tracks do not determine the velocities' time offset; their "
              "time stamps are not corrected"
            : fmt::format(
                  "time_offset=auto: the velocities are stamped {} by {:.0f} +- {:.0f} ms against "
                  "the frames, estimated from the tracks; their time stamps are {}",
                  clock->offset > 0 ? "late" : "early", 1e3 * std::abs(clock->offset),
                  1e3 * clock->sigma, corrected ? "corrected" : "not corrected");
  }
  shift_velocities(recording, correction.offset);
  return correction;
}

std::unique_ptr<Estimator> make_estimator(const InertialRunSettings& settings,
                                          const Recording& recording,
                                          std::optional<InertialStart> start) {
  return make_estimator(decided(settings, recording), inertial_sensors(recording),
                        std::move(start));
}

std::unique_ptr<Estimator> make_estimator(const VelocityRunSettings& settings,
                                          const Recording& recording) {
  return make_estimator(settings, velocity_sensors(recording, settings));
}

}  // namespace chasles
