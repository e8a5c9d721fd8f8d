#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/imu/imu_buffer.hpp>

namespace chasles {

/// A frame of the front end, and its report.
struct TrackedFrame {
  FeatureFrame frame;
  FrontendReport report;
  double seconds = 0;  ///< time of the front end
};

/// A front end with rotations predicted from the gyroscope. Images that are not later than the
/// previous ones give an empty frame of their time; the front end does not receive them. The frames
/// contain the images.
class ImageTracker {
 public:
  /// `masks` and exceptions as for Frontend.
  ImageTracker(const FrontendSettings& settings, std::vector<Camera> cameras,
               const ImuBuffer::Options& imu, std::vector<GrayImage> masks = {});

  void process(const ImuSample& sample) { imu_.add(sample); }
  /// Call after the samples up to the image's time; `gyroscope_bias` [rad/s].
  TrackedFrame process(std::shared_ptr<const ImageFrame> images,
                       const Eigen::Vector3d& gyroscope_bias);

 private:
  Frontend frontend_;
  ImuBuffer imu_;
  std::optional<Time> last_;
};

}  // namespace chasles
