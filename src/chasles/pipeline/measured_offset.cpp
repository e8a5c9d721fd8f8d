#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/pipeline/liveliest_part.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/recording/masks.hpp>

namespace chasles {
namespace {

std::string offset_remark(const CameraClock& clock) {
  return fmt::format(
      "the images are stamped {} by {:.1f} +- {:.1f} ms against the gyroscope, measured from the "
      "rotation of the tracks: the run starts from this offset (time_offset=auto; "
      "--set time_offset=0 starts from none)",
      clock.offset < 0 ? "late" : "early", 1e3 * std::abs(clock.offset), 1e3 * clock.sigma);
}

// What tracks and gyroscope show is good to one or two milliseconds. A filter can do better.
bool estimates_measured_readout(const InertialRunSettings& settings) {
  return settings.estimator.is_filter() && !settings.filter.numeric_jacobians &&
         settings.filter.calibrate_readout == Calibrate::kAuto;
}

std::string readout_remark(const Measured& readout, bool is_estimated) {
  return fmt::format(
      "the shutter rolls: its readout takes {:.1f} +- {:.1f} ms, {}, measured from the tracks and "
      "the gyroscope; the run {} (readout_time=auto; --set readout_time=0 takes the shutter for a "
      "global one)",
      1e3 * std::abs(readout.value), 1e3 * readout.sigma,
      readout.value < 0 ? "from the last row to the first" : "from the first row to the last",
      is_estimated ? "estimates it from there" : "takes it as stated");
}

std::string what_axes(const OtherAxes& axes) {
  if (!axes.has_signs()) {
    return fmt::format(
        "{} samples have other axes than the extrinsics state: {} where these have x, y, z",
        axes.of_gyroscope ? "the gyroscope's" : "the IMU's", axes.turned());
  }
  const bool all = axes.signs.maxCoeff() < 0;
  return fmt::format("the gyroscope{} has the wrong sign", all ? "" : "'s " + axes.mirrored());
}

std::string axes_remark(const TracksEvidence& evidence) {
  constexpr double kMuch = 2 * kRadians;
  if (!evidence.taken) {
    return fmt::format(
        "{}, by the rotation of the tracks, but then the accelerometer's gravity would not keep "
        "its "
        "direction: the run takes the samples as they are; check the axes of both sensors",
        what_axes(*evidence.axes));
  }
  const std::string rest =
      evidence.taken->rest > kMuch
          ? fmt::format("; {:.0f} deg are left: calibrate the camera against the IMU",
                        evidence.taken->rest / kRadians)
          : "";
  return fmt::format(
      "{}, by the rotation of the tracks: the run changes it (--as-recorded takes the samples as "
      "they are){}",
      what_axes(*evidence.taken), rest);
}

std::string lens_remark(const LensGuess& mistake) {
  return fmt::format(
      "cam0, by tracks and gyroscope: {}; {} (`chasles check`); all frames are degraded for it",
      mistake.what, mistake.advice);
}

// The image of the first camera; empty if it cannot be read, which the run counts.
ImageFrame first_image(const ImageSource& images, std::size_t i) {
  try {
    return images.read_undamaged(i, 1, [](const InputError&) {});
  } catch (const InputError&) {
    return {.time = images.time(i), .images = std::vector<GrayImage>(1)};
  }
}

}  // namespace

std::vector<FeatureFrame> tracks_of_first_camera(const Recording& recording,
                                                 const FrontendSettings& settings, double seconds,
                                                 const StopRequest& stop) {
  if (!recording.images || recording.cameras.empty()) return recording.frames;
  std::vector<GrayImage> masks = masks_of(settings.mask, recording);
  masks.resize(std::min<std::size_t>(masks.size(), 1));
  FrontendSettings alone = settings;
  alone.stereo = false;
  std::vector<FeatureFrame> frames;
  try {
    Frontend frontend(alone, {recording.cameras.front()}, std::move(masks));
    const auto images = liveliest_part(recording, seconds);
    for (std::size_t i = 0; i < images->size(); ++i) {
      if (stop && stop()) return {};
      frames.push_back(frontend.process(first_image(*images, i)));
    }
  } catch (const Error&) {  // of the calibration: the run itself ends with it
    return {};
  }
  return frames;
}

TracksEvidence evidence_of(const CameraFit& fit, const std::vector<Camera>& cameras,
                           const std::vector<ImuSample>& imu, const InertialRunSettings& settings) {
  TracksEvidence evidence{.clock = camera_clock(fit), .mistake = fit.mistake};
  const auto& given = settings.filter.readout_time;
  const bool open = !given && std::ranges::none_of(cameras, [](const Camera& camera) {
    return camera.shutter.is_rolling();
  });
  if (open && fit.lens && fit.lens->is_rolling()) evidence.readout = fit.lens->readout;
  // The offset is that of the first line by the shutter as it is stated.
  const double readout =
      evidence.readout ? evidence.readout->value : given.value_or(fit.shutter.readout);
  if (evidence.clock) evidence.clock->offset += (fit.shutter.readout - std::abs(readout)) / 2;
  evidence.axes = other_axes(fit, cameras.front());
  if (evidence.axes) evidence.taken = agreeing_with_gravity(*evidence.axes, imu);
  return evidence;
}

TracksEvidence examine_tracks(const Recording& recording, const InertialRunSettings& settings,
                              const StopRequest& stop) {
  const bool wanted =
      recording.images || (!settings.filter.time_offset && settings.filter.has_time_offset());
  if (!wanted || recording.imu.empty() || recording.cameras.empty()) return {};
  const auto tracks = tracks_of_first_camera(recording, settings.frontend, kExaminedSeconds, stop);
  const auto rates = gyroscope_rates(recording.imu);
  std::vector<Camera> cameras = recording.cameras;
  const auto fit = fit_camera(tracks, cameras, 0, rates);
  if (!fit) return {};
  TracksEvidence evidence = evidence_of(*fit, cameras, recording.imu, settings);
  if (!evidence.readout) return evidence;
  // A sensor reads out an image before it begins the next one.
  const double longest =
      std::min(frame_interval(recording, 0).value_or(kLongestReadout), kLongestReadout);
  Measured readout = *evidence.readout;
  readout.value = std::clamp(readout.value, -longest, longest);
  // Lines that are taken for those of a global shutter look like another lens.
  set_readout(readout.value, cameras);
  if (const auto undone = fit_camera(tracks, cameras, 0, rates)) {
    evidence = evidence_of(*undone, cameras, recording.imu, settings);
  }
  evidence.readout = readout;
  return evidence;
}

void start_from_measured(InertialRunSettings& settings, const TracksEvidence& evidence) {
  InertialSlamSettings& filter = settings.filter;
  if (evidence.readout) {
    filter.readout_time = evidence.readout->value;
    if (estimates_measured_readout(settings)) filter.calibrate_readout = Calibrate::kTrue;
  }
  if (filter.time_offset) return;
  filter.time_offset = 0;
  if (!evidence.clock_stands_out()) return;
  filter.time_offset = evidence.clock->offset;
  filter.initial_time_offset_sigma = evidence.clock->sigma;
  if (settings.estimator.is_filter() && filter.calibrate_time_offset == Calibrate::kAuto) {
    filter.calibrate_time_offset = Calibrate::kTrue;
  }
}

void mend(Recording& recording, const InertialSlamSettings& settings,
          const TracksEvidence& evidence) {
  if (evidence.taken) take_axes(*evidence.taken, recording.imu);
  if (settings.readout_time) set_readout(*settings.readout_time, recording.cameras);
}

std::vector<std::string> remarks_of(const TracksEvidence& evidence,
                                    const InertialRunSettings& settings) {
  std::vector<std::string> remarks;
  if (evidence.axes) remarks.push_back(axes_remark(evidence));
  if (!settings.filter.time_offset && evidence.clock_stands_out()) {
    remarks.push_back(offset_remark(*evidence.clock));
  }
  if (evidence.readout) {
    remarks.push_back(readout_remark(*evidence.readout, estimates_measured_readout(settings)));
  }
  if (evidence.mistake) remarks.push_back(lens_remark(*evidence.mistake));
  return remarks;
}

}  // namespace chasles
