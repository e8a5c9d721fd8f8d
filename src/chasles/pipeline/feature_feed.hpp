#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <chasles/pipeline/image_tracker.hpp>
#include <chasles/pipeline/sensor_event.hpp>

namespace chasles {

/// Events for an estimator, images turned into frames of tracks: on a thread of its own, up to
/// kLead frames ahead of the estimator, or when asked for. The front end predicts rotations from
/// the gyroscope, with the bias that the estimator had kLead frames before; so the frames are the
/// same bytes in both cases. Without cameras there is no front end, and an image is an error.
class FeatureFeed {
 public:
  static constexpr std::size_t kLead = 3;

  /// `next` gives the events, none at the end; with `ahead` it is called from the other thread, and
  /// what it throws is thrown by next() below. `masks` as for Frontend.
  FeatureFeed(std::function<std::optional<SensorEvent>()> next, const FrontendSettings& settings,
              std::vector<Camera> cameras, const ImuBuffer::Options& imu, bool ahead,
              std::vector<GrayImage> masks = {});
  ~FeatureFeed();

  /// Images become TrackedFrames; other events stay as they are.
  using Item = std::variant<BodyVelocity, ImuSample, FeatureFrame, TrackedFrame>;
  std::optional<Item> next();

  /// To be called once after every TrackedFrame: what the filter thinks of the gyroscope's bias by
  /// then [rad/s]; zero as long as it does not know.
  void learnt(const Eigen::Vector3d& gyroscope_bias);

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace chasles
