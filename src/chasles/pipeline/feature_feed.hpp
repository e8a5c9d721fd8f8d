#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <chasles/pipeline/image_tracker.hpp>

namespace chasles {

/// What sensors deliver, in the order of time.
using SensorEvent = std::variant<ImuSample, FeatureFrame, ImageFrame>;

/// Samples and frames for a filter, the images among them turned into frames: on a thread of its
/// own, up to kLead frames ahead of the filter, or when asked for. The front end is told the
/// rotation that the gyroscope saw, less the bias that the filter had kLead frames before; so the
/// frames are the same bytes in both cases.
class FeatureFeed {
 public:
  static constexpr std::size_t kLead = 3;

  /// `next` gives the events, none at the end; with `ahead` it is called from the other thread, and
  /// what it throws is thrown by next() below. `masks` as for Frontend.
  FeatureFeed(std::function<std::optional<SensorEvent>()> next, const FrontendSettings& settings,
              std::vector<Camera> cameras, const ImuBuffer::Options& imu, bool ahead,
              std::vector<GrayImage> masks = {});
  ~FeatureFeed();

  /// FeatureFrames that came as such, and those of images as TrackedFrame.
  using Item = std::variant<ImuSample, FeatureFrame, TrackedFrame>;
  std::optional<Item> next();

  /// To be called once after every TrackedFrame: what the filter thinks of the gyroscope's bias by
  /// then [rad/s]; zero as long as it does not know.
  void learnt(const Eigen::Vector3d& gyroscope_bias);

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace chasles
