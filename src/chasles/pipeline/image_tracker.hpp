#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/imu/imu_buffer.hpp>

namespace chasles {

/// A frame that the front end made, and how.
struct TrackedFrame {
  FeatureFrame frame;
  FrontendReport report;
  double seconds = 0;  ///< that the front end took
};

/// A front end that is told the rotation that the gyroscope saw. Images that are not later than
/// those before become a frame without points, of their time; the front end does not see them.
class ImageTracker {
 public:
  /// `masks` and what is thrown: as for Frontend.
  ImageTracker(const FrontendSettings& settings, std::vector<Camera> cameras,
               const ImuBuffer::Options& imu, std::vector<GrayImage> masks = {});

  void process(const ImuSample& sample) { imu_.add(sample); }
  /// After the samples up to its time; `gyroscope_bias` [rad/s].
  TrackedFrame process(const ImageFrame& images, const Eigen::Vector3d& gyroscope_bias);

 private:
  Frontend frontend_;
  ImuBuffer imu_;
  std::optional<Time> last_;
};

}  // namespace chasles
