#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/feature_feed.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Real recordings with inserted faults, and the result of the run.
namespace chasles::test {

/// The images of a source, decoded once.
class DecodedImages {
 public:
  explicit DecodedImages(std::shared_ptr<const ImageSource> images) : images_(std::move(images)) {}

  const ImageSource& source() const { return *images_; }
  ImageFrame read(std::size_t i) const {
    auto found = decoded_.find(i);
    if (found == decoded_.end()) found = decoded_.emplace(i, images_->read(i)).first;
    return found->second;
  }

 private:
  std::shared_ptr<const ImageSource> images_;
  mutable std::map<std::size_t, ImageFrame> decoded_;
};

/// A part of a recording as lists that a fault may change arbitrarily, also out of order; next()
/// returns them as the events of a sensor.
class FaultySensors {
 public:
  struct Due {
    Time time{};
    std::size_t index = 0;                         ///< of the images
    std::function<void(ImageFrame&)> change = {};  ///< none: unchanged
    bool unreadable = false;                       ///< reading throws InputError
  };

  /// From `from` seconds after the first frame on.
  FaultySensors(const Recording& recording, const DecodedImages& images, double from,
                double seconds, std::size_t rig)
      : cameras(recording.cameras.begin(), recording.cameras.begin() + static_cast<long>(rig)),
        images_(&images),
        begin_(images.source().time(0) + from_seconds(from)) {
    const Time end = begin_ + from_seconds(seconds);
    for (std::size_t i = 0; i < images.source().size(); ++i) {
      const Time time = images.source().time(i);
      if (time >= begin_ && time <= end) frames.push_back({.time = time, .index = i});
    }
    for (const ImuSample& sample : recording.imu) {
      const Time slack = std::chrono::milliseconds(50);
      if (sample.time >= begin_ - slack && sample.time <= end + slack) imu.push_back(sample);
    }
  }

  std::vector<Camera> cameras;
  std::vector<ImuSample> imu;
  std::vector<Due> frames;
  std::function<void(FeatureFrame&)>
      spoil;  ///< changes the output of the front end; none: unchanged

  double seconds(Time time) const { return to_seconds(time - begin_); }
  Time at(double seconds) const { return begin_ + from_seconds(seconds); }
  bool within(Time time, double from, double to) const {
    return seconds(time) >= from && seconds(time) < to;
  }

  /// In the order of the lists, samples up to the first that is not earlier than a frame before it.
  std::optional<SensorEvent> next() {
    if (frame_ == frames.size()) return std::nullopt;
    const Due& due = frames[frame_];
    if (imu_ < imu.size() && (imu_ == 0 || imu[imu_ - 1].time < due.time)) return imu[imu_++];
    ++frame_;
    return read(due);
  }
  int unreadable() const { return unreadable_; }

 private:
  // As in the program: images that cannot be read count as missing.
  ImageFrame read(const Due& due) {
    ImageFrame frame;
    try {
      if (due.unreadable) throw InputError("torn");
      frame = images_->read(due.index);
      frame.images.resize(cameras.size());
      if (due.change) due.change(frame);
    } catch (const InputError&) {
      ++unreadable_;
      frame.images.assign(cameras.size(), {});
    }
    frame.time = due.time;
    return frame;
  }

  const DecodedImages* images_;
  Time begin_;
  std::size_t frame_ = 0, imu_ = 0;
  int unreadable_ = 0;
};

/// The result of a run.
struct FaultOutcome {
  int frames = 0, estimates = 0, resets = 0, dropped = 0, unreadable = 0;
  int degraded = 0, lost = 0;      ///< estimates with that health
  int false_ok = 0;                ///< estimates that claim to be ok and are not, as false_claims()
  bool sound = true;               ///< all finite, times rise, variances not negative
  bool running = false;            ///< at the end
  double started = std::nan("");   ///< [s]
  double ate = std::nan("");       ///< aligned by position and heading, of all parts together [m]
  double last_ate = std::nan("");  ///< of the end of the run alone [m]
  double latest = std::nan("");    ///< time of the last estimate [s]
  std::vector<Requirement> requirements;
  ImuBuffer::Counts imu;
};

/// Numbers the `ok` estimates whose position is wrong by more than four of their sigmas and 0.2 m.
/// Origin and heading are those of the truth at the first estimate.
inline int false_claims(const std::vector<Estimate>& estimates, const Trajectory& truth) {
  std::optional<SE3> true_T_world;
  int count = 0;
  for (const Estimate& e : estimates) {
    const auto true_pose = pose_at(truth, e.time);
    if (!true_pose) continue;
    if (!true_T_world) {
      const Eigen::Matrix3d R = true_pose->R * e.world_T_imu.R.transpose();
      const double heading = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
      const SE3 turn{.R = so3::exp({0, 0, heading}), .p = Eigen::Vector3d::Zero()};
      true_T_world = SE3{.R = turn.R, .p = true_pose->p - turn.R * e.world_T_imu.p};
    }
    const double error = ((*true_T_world * e.world_T_imu).p - true_pose->p).norm();
    count += e.health == Health::kOk && error > std::max(0.2, 4 * position_sigma(e));
  }
  return count;
}

/// Front end and session over the sensors, as in the program. `recording`: for its noise and its
/// truth; `end`: length of the end of the run [s].
inline FaultOutcome run(FaultySensors& sensors, const Recording& recording, double end) {
  FaultOutcome outcome;
  const ImuBuffer::Options imu{.convention = recording.imu_convention,
                               .accelerometer_range = 175,
                               .gyroscope_range = 17.3};  // that of EuRoC's sensor
  const InertialSlamSettings filter =
      for_images({}, sensors.cameras.size(), *recording.imu_noise).filter;
  InertialSession session(
      filter, {},
      {.cameras = sensors.cameras,
       .noise = *recording.imu_noise,
       .imu = imu,
       .pixel_sigma = recording.single_pixel_sigma.value_or(kFrontendPixelSigma)});
  FeatureFeed feed([&] { return sensors.next(); }, {}, sensors.cameras, imu, false);
  std::vector<Estimate> estimates;
  Trajectory own;
  std::optional<Time> before;
  const auto add = [&](const std::vector<Estimate>& some) {
    for (const Estimate& e : some) {
      ++outcome.estimates;
      outcome.degraded += e.health == Health::kDegraded;
      outcome.lost += e.health == Health::kLost;
      outcome.sound = outcome.sound && is_sound(e, before);
      if (!before) outcome.started = sensors.seconds(e.time);
      before = e.time;
      own.push_back({.time = e.time, .pose = e.world_T_imu});
      estimates.push_back(e);
    }
  };
  while (auto item = feed.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*item)) add(session.process(*sample));
    auto* tracked = std::get_if<TrackedFrame>(&*item);
    if (!tracked) continue;
    ++outcome.frames;
    if (sensors.spoil) sensors.spoil(tracked->frame);
    add(session.process(tracked->frame));
    feed.note_bias(session.gyroscope_bias());
  }
  outcome.resets = session.report().resets;
  outcome.dropped = session.report().dropped_frames;
  outcome.unreadable = sensors.unreadable();
  outcome.running = session.running();
  outcome.requirements = session.requirements();
  outcome.imu = session.report().imu;
  if (!before) return outcome;
  outcome.latest = sensors.seconds(*before);
  outcome.false_ok = false_claims(estimates, recording.truth);
  outcome.ate = error_from(own, recording.truth);
  outcome.last_ate = error_from(own, recording.truth, *before - from_seconds(end));
  return outcome;
}

}  // namespace chasles::test
