#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include <chasles/pipeline/estimator.hpp>
#include <chasles/pipeline/image_tracker.hpp>
#include <chasles/slam/waiting_frames.hpp>

namespace chasles {

/// SLAM from an IMU and images as they come: for a robot's own program. Samples and images each in
/// the order of their times; an image waits here until the samples reach its time, so it may come
/// before older samples. The same samples and images give the same estimates as `chasles run`, to
/// the bit, if no sample later than the first at or after an image's time comes before the image.
/// One thread, and no call waits.
///
/// The session (InertialSession) recovers from bad samples and times, and counts them. Images that
/// cannot be used, and images that are not later than those before, are frames without points.
class VisualInertialSlam {
 public:
  /// `masks` as for Frontend. Throws UsageError for settings, cameras or masks that cannot be used.
  VisualInertialSlam(const std::vector<Camera>& cameras, const ImuNoise& noise,
                     const InertialRunSettings& settings = {}, const ImuBuffer::Options& imu = {},
                     std::vector<GrayImage> masks = {});

  /// The estimates of the images that waited for this sample: none before there is a start
  /// (estimator().why_not_started()), and then one an image, of the image's time.
  std::vector<Estimate> process(const ImuSample& sample);
  /// The estimates that need no further sample. Another number of images than cameras, or an image
  /// of another size than its camera's, throws InputError; the images are then ignored.
  std::vector<Estimate> process(ImageFrame images);
  /// The estimates of all images that still wait: no more samples come. Of batch estimation those
  /// of all keyframes, which replace the earlier ones.
  std::vector<Estimate> finish();

  const Estimator& estimator() const { return *estimator_; }
  /// About the last image.
  const FrontendReport& report() const { return report_; }
  std::size_t waiting() const { return waiting_.size(); }  ///< images

 private:
  void take_covered(std::vector<Estimate>& estimates);
  void take(const ImageFrame& images, std::vector<Estimate>& estimates);

  std::vector<Camera> cameras_;
  ImageTracker tracker_;
  std::unique_ptr<Estimator> estimator_;
  FrontendReport report_;
  WaitingFrames<ImageFrame> waiting_;
  std::optional<Time> last_sample_;
  /// The estimates of the gyroscope's bias after the last images, as a FeatureFeed has them.
  std::deque<Eigen::Vector3d> biases_;
};

}  // namespace chasles
