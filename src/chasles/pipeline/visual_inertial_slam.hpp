#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <chasles/pipeline/arrival_order.hpp>
#include <chasles/pipeline/delayed_bias.hpp>
#include <chasles/pipeline/estimator.hpp>
#include <chasles/pipeline/image_tracker.hpp>
#include <chasles/slam/state_predictor.hpp>

namespace chasles {

/// SLAM from an IMU and images in real time, for a robot's own program. Samples and images may come
/// in any order: ArrivalOrder says within which bounds, and arrivals() counts what was beyond them.
/// An image waits until the samples reach its time. The same samples and images give the same
/// estimates as `chasles run`, to the bit. One thread: process() returns when the estimates are
/// there. RealtimeSlam is the same on a thread of its own.
///
/// With the filter, the session (InertialSession) recovers from invalid samples and times, and
/// counts them; for windows and batch estimation see Estimator::process() and complete(). Images
/// that cannot be used are frames without points.
class VisualInertialSlam {
 public:
  /// `masks` as for Frontend. `prior`: a map in which the filter finds its place, with
  /// recognise=appearance; Estimate::in_map then has the pose there, and the frame of the map in
  /// the world. Throws UsageError for settings, cameras or masks that cannot be used.
  VisualInertialSlam(const std::vector<Camera>& cameras, const ImuNoise& noise,
                     const InertialRunSettings& settings = {}, const ImuBuffer::Options& imu = {},
                     std::vector<GrayImage> masks = {},
                     std::shared_ptr<const LandmarkMap> prior = nullptr);

  /// The estimates of the images that waited for this sample: none before there is a start
  /// (estimator().why_not_started()), then one per image, at the image's time.
  std::vector<Estimate> process(const ImuSample& sample);
  /// The estimates that need no further sample. A number of images other than that of the cameras,
  /// or an image of another size than its camera's, throws InputError; the images are then ignored.
  std::vector<Estimate> process(ImageFrame images);
  /// The estimates of all images that still wait; no more samples come. For batch estimation those
  /// of all keyframes, which replace the earlier ones. Where `stop` returns true it ends early, and
  /// some of them are missing.
  std::vector<Estimate> finish(const StopRequest& stop = {});

  /// The state at any time since the last estimate, by the samples: for controllers, which need it
  /// more often than images come (StatePredictor). Its time is on the IMU's clock. None before a
  /// start, before the last estimate's time, StatePredictor::kLongest after it, where it is lost,
  /// and where samples are missing.
  std::optional<PredictedState> predicted(Time time) { return predictor_.at(time); }
  const StatePredictor& predictor() const { return predictor_; }

  /// Sets a callback for each frame of tracks, before the estimator takes it.
  using FrameObserver = std::function<void(const FeatureFrame&)>;
  void set_frame_observer(FrameObserver observer) { on_frame_ = std::move(observer); }

  const Estimator& estimator() const { return *estimator_; }
  const std::vector<Camera>& cameras() const { return cameras_; }
  /// Report of the last image.
  const FrontendReport& report() const { return report_; }
  std::size_t waiting() const { return order_.waiting_frames(); }  ///< images
  const ArrivalCounts& arrivals() const { return order_.counts(); }

 private:
  std::vector<Estimate> take_due();
  void take(SensorEvent event, std::vector<Estimate>& estimates);
  void take(ImageFrame images, std::vector<Estimate>& estimates);
  void note(const std::vector<Estimate>& estimates);

  std::vector<Camera> cameras_;
  ImageTracker tracker_;
  std::unique_ptr<Estimator> estimator_;
  StatePredictor predictor_;
  FrameObserver on_frame_;
  FrontendReport report_;
  ArrivalOrder order_;
  DelayedBias biases_;
};

}  // namespace chasles
