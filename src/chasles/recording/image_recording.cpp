#include <cstdlib>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/sample_batches.hpp>
#include <chasles/recording/time_order.hpp>
#include <chasles/recording/time_spans.hpp>

namespace chasles {

void tidy_samples(const std::filesystem::path& file, Recording& recording) {
  if (recording.imu.empty()) {
    throw InputError(fmt::format("{}: holds no sample, expected an IMU's", file.string()));
  }
  spread_batches(recording.imu, "IMU samples", recording.remarks);
  std::vector<Time> times;
  for (const ImuSample& sample : recording.imu) times.push_back(sample.time);
  check_distinct(file.string(), "IMU samples", std::move(times));
  bring_into_order(recording.imu, "IMU samples", recording.remarks);
  leave_out_not_finite(file, recording);
}

void leave_out_not_finite(const std::filesystem::path& file, Recording& recording) {
  const auto known = [](const ImuSample& s) {
    return s.specific_force_imu.allFinite() && s.angular_rate_imu.allFinite();
  };
  leave_out_unknown(file, known, "IMU samples", recording.imu, recording.remarks);
}

Time by_imu_clock(Time stamp, Time offset, const std::string& where) {
  const Time time = stamp + offset;  // either is below half of the largest number
  if (std::abs(time.count()) < kLastNanosecond) return time;
  throw InputError(fmt::format("{}: a stamp of {} ns with the time offset of {} s is no time",
                               where, stamp.count(), to_seconds(offset)));
}

void open_cameras(std::vector<std::optional<CameraFiles>> files, const std::vector<Time>& offsets,
                  const std::filesystem::path& first, Recording& recording) {
  std::vector<CameraFiles> kept;
  std::vector<Camera> cameras;
  std::vector<std::size_t> numbers;
  for (std::size_t c = 0; c < files.size(); ++c) {
    if (!files[c]) {
      if (c == 0) {
        throw InputError(fmt::format("{}: no such folder, expected the images of a camera there",
                                     first.string()));
      }
      recording.remarks.push_back(
          fmt::format("cam{} is calibrated, but has no images: left out", c));
      continue;
    }
    for (StampedFile& image : files[c]->images) {
      image.time = by_imu_clock(image.time, offsets.empty() ? Time::zero() : offsets[c],
                                files[c]->folder.string());
    }
    kept.push_back(std::move(*files[c]));
    cameras.push_back(recording.cameras[c]);
    numbers.push_back(c);
  }
  if (kept.size() < files.size()) recording.camera_numbers = std::move(numbers);
  recording.cameras = std::move(cameras);
  // The cameras of a rig are triggered together: EuRoC's have identical times.
  recording.images =
      open_image_files(std::move(kept), recording.cameras, kSameInstant, recording.remarks);
}

void remark_on_further_camera(const std::filesystem::path& folder, Recording& recording) {
  const std::size_t next = recording.cameras.size();
  std::error_code ignored;
  if (!std::filesystem::exists(folder / fmt::format("cam{}", next), ignored)) return;
  recording.remarks.push_back(fmt::format("cam{} is not read: the calibration has {} camera{}",
                                          next, next, next == 1 ? "" : "s"));
}

void remark_on_coverage(Recording& recording) {
  const std::size_t frames = recording.images->size();
  const Time begin = recording.imu.front().time, end = recording.imu.back().time;
  std::size_t outside = 0;
  for (std::size_t k = 0; k < frames; ++k) {
    const Time time = recording.images->time(k);
    outside += time < begin || time > end ? 1 : 0;
  }
  if (outside > 0) {
    recording.remarks.push_back(
        fmt::format("{} of {} frames are before the first IMU sample or after the last: kept",
                    outside, frames));
  }
  constexpr double kTail = 2;  // [s]
  const double tail = frames == 0 ? 0 : to_seconds(end - recording.images->time(frames - 1));
  if (tail > kTail) {
    recording.remarks.push_back(fmt::format(
        "the images end {:.1f} s before the last IMU sample: no estimate comes after them", tail));
  }
}

}  // namespace chasles
