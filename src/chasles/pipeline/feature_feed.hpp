#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <chasles/pipeline/delayed_bias.hpp>
#include <chasles/pipeline/image_tracker.hpp>
#include <chasles/pipeline/sensor_event.hpp>

namespace chasles {

/// Events for an estimator, with images replaced by frames of tracks: on a thread of its own, up to
/// kLead frames ahead of the estimator, or on demand. The front end predicts rotations from the
/// gyroscope, with the bias that the estimator had kLead frames before. So the frames are the same
/// bytes in both cases. Without cameras there is no front end, and an image is an error.
class FeatureFeed {
 public:
  static constexpr std::size_t kLead = DelayedBias::kLead;

  /// `next` returns the events, none at the end. With `ahead` it is called from the other thread,
  /// and its exceptions are rethrown by next(). `masks` as for Frontend.
  FeatureFeed(std::function<std::optional<SensorEvent>()> next, const FrontendSettings& settings,
              std::vector<Camera> cameras, const ImuBuffer::Options& imu, bool ahead,
              std::vector<GrayImage> masks = {});
  ~FeatureFeed();

  /// Images become TrackedFrames; other events stay as they are.
  using Item = EventsWith<TrackedFrame>;
  std::optional<Item> next();

  /// Call once after every TrackedFrame with the filter's present estimate of the gyroscope bias
  /// [rad/s]; zero while there is none.
  void note_bias(const Eigen::Vector3d& gyroscope_bias);

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace chasles
