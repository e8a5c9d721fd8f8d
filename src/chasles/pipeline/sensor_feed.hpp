#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/ahead.hpp>
#include <chasles/pipeline/feature_feed.hpp>
#include <chasles/pipeline/playback.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

struct SensorFeedOptions {
  /// 2: the front end has its own thread; 3: reading the images as well. The results are the same
  /// bytes.
  int threads = 3;
  std::optional<double> realtime;  ///< recorded seconds per second; none: as fast as possible
  std::function<bool()> stop = [] {
    return false;
  };  ///< polled while the feed waits for a live sensor
  /// Called with the frames in which a camera that finds tracks (are_finders()) has an image that
  /// can be read, maybe from another thread, until close().
  std::function<void(const ImageFrame&)> see = [](const ImageFrame&) {};
  /// Called once for each frame with images that cannot be read, with the error of the first one;
  /// these images count as missing.
  std::function<void(const InputError&)> unreadable = [](const InputError&) {};
};

/// The events of a recording as the input of an estimator: its samples and frames, its images
/// through the front end. As fast as they are taken, or at the recording's own speed; then some may
/// be dropped. An image that cannot be read counts as missing; next() throws InputError if that
/// holds for all images of the cameras that find tracks, or for the first twenty frames.
class SensorFeed {
 public:
  /// The recording must outlive the feed.
  SensorFeed(const Recording& recording, const FrontendSettings& frontend,
             const ImuBuffer::Options& imu, std::vector<GrayImage> masks,
             const SensorFeedOptions& options);
  SensorFeed(const SensorFeed&) = delete;
  SensorFeed& operator=(const SensorFeed&) = delete;
  ~SensorFeed() { close(); }

  /// None at the end, and after a stop.
  std::optional<FeatureFeed::Item> next() { return feed_->next(); }
  /// As for FeatureFeed.
  void note_bias(const Eigen::Vector3d& gyroscope_bias) { feed_->note_bias(gyroscope_bias); }

  /// For a recording that is played at its own speed: time since the data of that recorded time
  /// were due [s].
  std::optional<double> seconds_since(Time recorded) const;

  /// Ends all threads. After it only counts() and unreadable() may be called.
  void close();
  int unreadable() const { return unreadable_; }       ///< frames with an image that cannot be read
  Playback::Counts counts() const { return counts_; }  ///< zero, if not played in real time

 private:
  std::optional<SensorEvent> next_event();
  ImageFrame read(const ImagesDue& due);
  /// Whether a camera that finds tracks has an image.
  bool shows_tracks(const ImageFrame& frame) const;
  /// Throws InputError if many frames have no such image, because they cannot be read, and none
  /// has.
  void give_up_if_hopeless() const;

  const Recording* recording_;
  EventStream stream_;
  std::vector<bool> finders_;  // whether a camera finds tracks; one a camera
  std::function<void(const ImageFrame&)> see_;
  std::function<void(const InputError&)> unreadable_image_;
  int unreadable_ = 0, without_ = 0;  // frames
  bool any_read_ = false;
  std::string first_error_;  // of the first of those frames
  Playback::Counts counts_;
  std::optional<Playback> playback_;
  std::optional<Ahead<SensorEvent>> ahead_;
  std::optional<FeatureFeed> feed_;
};

}  // namespace chasles
