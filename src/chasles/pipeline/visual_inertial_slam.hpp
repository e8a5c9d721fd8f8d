#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include <chasles/pipeline/image_tracker.hpp>
#include <chasles/slam/inertial_session.hpp>

namespace chasles {

/// What a point of this front end counts as [px]; its errors are alike from frame to frame, so more
/// than they scatter by (docs/pixels.md).
inline constexpr double kFrontendPixelSigma = 0.4;

/// The settings as a run from the images of so many cameras takes them: where one camera alone has
/// to find the scale, after a rest with every depth guessed, `keep_scale: auto` is true; not with
/// the chart left-se3, which cannot.
InertialSlamSettings for_images(InertialSlamSettings settings, std::size_t cameras);

struct VisualInertialSettings {
  FrontendSettings frontend;
  InitialiserSettings start;
  InertialSlamSettings filter;  ///< pixel_sigma: kFrontendPixelSigma where none is given
};

/// SLAM from an IMU and images as they come: what a robot's own program calls. Samples and images
/// each in the order of their times; an image waits here until the samples reach up to it, so one
/// may come before samples that are older. The same samples and images give the same estimates as
/// `chasles run` gives, to the bit, if no sample comes that is later than the first at or after an
/// image's time before the image does; one thread, and nothing waits for anything.
///
/// Bad samples and times are recovered and counted by the session (InertialSession); images that
/// cannot be used, and those that are not later than the ones before, are frames without points.
class VisualInertialSlam {
 public:
  /// Throws UsageError for settings, cameras or masks that cannot be used. `masks` as for Frontend.
  VisualInertialSlam(const std::vector<Camera>& cameras, const ImuNoise& noise,
                     const VisualInertialSettings& settings = {},
                     const ImuBuffer::Options& imu = {}, std::vector<GrayImage> masks = {});

  /// The estimates of the images that waited for this sample: none before there is a start
  /// (session().requirements() says why), and then one an image, of the image's time.
  std::vector<InertialEstimate> process(const ImuSample& sample);
  /// The estimates that need no further sample. Another number of images than cameras, or an image
  /// of another size than its camera's, throws InputError, and all is as if they had not come.
  std::vector<InertialEstimate> process(ImageFrame images);
  /// The estimates of all images that still wait: no more samples will come.
  std::vector<InertialEstimate> finish();

  const InertialSession& session() const { return session_; }
  /// About the last image.
  const FrontendReport& report() const { return report_; }
  std::size_t waiting() const { return waiting_.size(); }  ///< images

 private:
  bool covered(Time image) const;
  void take_covered(std::vector<InertialEstimate>& estimates);
  void take_oldest(std::vector<InertialEstimate>& estimates);

  std::vector<Camera> cameras_;
  ImageTracker tracker_;
  InertialSession session_;
  FrontendReport report_;
  std::deque<ImageFrame> waiting_;
  std::optional<Time> last_sample_;
  /// What the filter thought of the gyroscope's bias after the last images, as a FeatureFeed tells.
  std::deque<Eigen::Vector3d> biases_;
};

}  // namespace chasles
