#pragma once

#include <chasles/filter/readout.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/numbered_detail.hpp>
#include <chasles/smooth/terms/imu_link.hpp>

/// The states and terms of a batch problem. Private to this folder.
namespace chasles::smooth_detail {

/// One observation of a landmark.
struct PointView {
  int keyframe = 0, camera = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool match = false;  ///< PixelObservation::is_match()
};

/// A landmark: its views, sorted by keyframe and camera. Either anchored in the camera of the first
/// view, with parameters (x/z, y/z, 1/z) in the axes of a face, or a point of nav [m].
struct BatchPoint {
  LandmarkId id = 0;
  std::vector<PointView> views;
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
  AnchorFace face = AnchorFace::kFront;  ///< of an anchored landmark
};

/// The standard deviation of the next view of a point [px]. `matches`: of the point so far; counts
/// the view if it is one.
double sigma_of(const InertialBatchInput& input, const PointView& view, int& matches);

struct BatchKeyframe {
  Time time{};  ///< on the IMU's clock
  InertialState state = {};
  int observations = 0;
  MeasuredReadout readout = {};  ///< after this state
};

struct BatchGraph {
  Numbered<BatchKeyframe> keyframes;
  Numbered<ImuLink> links = {};  ///< between a keyframe and the next; terms hold pointers to them
  std::vector<BatchPoint> points = {};
  InertialState start = {};                            ///< the prior's mean
  Matrix15d start_whitening = Matrix15d::Identity();   ///< W^T W = covariance^-1
  Matrix15d start_covariance = Matrix15d::Identity();  ///< with the floors of InertialBatchInput
  /// InertialStart::by_imu, and the parameters at which the start is the prior's mean; empty: it
  /// does not depend on estimated parameters.
  Eigen::MatrixXd start_by_imu = {};
  Eigen::VectorXd imu_of_start = {};
  Eigen::Vector3d gravity = {0, 0, -kStandardGravity};
  bool anchored = true;
  std::vector<Camera> cameras = {};  ///< as calibrated at present
  /// What is estimated of the calibration, at present; with the covariance of its prior and the
  /// floors of InertialBatchInput. And the whitening of that.
  std::optional<Calibration> calibration = {};
  Eigen::MatrixXd calibration_whitening = {};

  /// The IMU's parameters at present; null: they are known.
  const ImuCorrection* imu() const {
    return calibration && calibration->imu ? &*calibration->imu : nullptr;
  }
  /// By which images were taken later than their keyframes, at the present time offset [s].
  double late(const InertialBatchInput& input) const {
    return calibration && calibration->time_offset
               ? *calibration->time_offset - to_seconds(input.time_offset)
               : 0;
  }
};

/// Longer gaps of samples leave the motion unknown (as in the filter).
inline constexpr Time kLongestGap = InertialSession::kLongestGap;

/// Chooses the keyframes: every batch.frames_per_keyframe-th of the frames that are not before the
/// start, later than the previous one and close enough to a sample. Counts dropped frames.
class KeyframeChoice {
 public:
  KeyframeChoice(const InertialBatchInput& input, const BatchSettings& settings, int& dropped)
      : input_(input), settings_(settings), dropped_(dropped) {}
  /// The frame's time on the IMU's clock; none: the frame is not used.
  std::optional<Time> take(const FeatureFrame& frame, Time last_sample);

 private:
  const InertialBatchInput& input_;
  const BatchSettings& settings_;
  int& dropped_;
  std::optional<Time> last_;
  int frames_ = 0;
};

/// The usable pixels of a frame: finite, of a known camera and with a ray, every landmark once in
/// each camera; sorted by landmark and camera. Counts the others.
std::vector<PixelObservation> usable(const FeatureFrame& frame, const std::vector<Camera>& cameras,
                                     int& unusable);

/// The keyframes without states, the start first, and the landmarks that they observe at least
/// twice, sorted by their first views, without parameters. Counts unusable data.
struct Tracked {
  Numbered<BatchKeyframe> keyframes;
  std::vector<BatchPoint> points;
};
Tracked track(const InertialBatchInput& input, const BatchSettings& settings, Time last_sample,
              BatchReport& report);

/// Keyframes with initial states, links, and landmarks with initial parameters. Counts into the
/// report; throws as smooth().
BatchGraph batch_graph(const InertialBatchInput& input, const BatchSettings& settings,
                       BatchReport& report);

/// The steps of batch_graph(). They throw as smooth().
void check(const InertialBatchInput& input);
[[noreturn]] void reject_gap(Time last, Time next);
void check_gaps(std::span<const ImuSample> measured, Time from, Time to);
void add_start(const InertialBatchInput& input, BatchGraph& graph);
/// Sets cameras and calibration to the values at which the search begins.
void add_calibration(const InertialBatchInput& input, BatchGraph& graph);
/// Adds a link from that keyframe to one at `to`; returns the state predicted there by the samples.
InertialState add_link(const InertialBatchInput& input, const BatchKeyframe& from, Time to,
                       ImuBuffer& buffer, BatchGraph& graph);
/// Sets the initial parameters from the states of the keyframes; false: the landmark cannot be used
/// in its form. With poor poses, the rays of an anchored landmark are not checked.
bool place(const InertialBatchInput& input, const BatchSettings& settings, bool good_poses,
           const BatchGraph& graph, BatchPoint& point);

/// The extrinsics of a view's camera, as given, at the line of its pixel
/// (camera/rolling_shutter.hpp).
SE3 cam_T_imu_of(const InertialBatchInput& input, const BatchGraph& graph, const PointView& view);
/// The same of an anchored landmark's first view, in the axes of its face. Its parameters refer to
/// these axes, which no estimated calibration moves.
SE3 anchor_T_imu(const InertialBatchInput& input, const BatchGraph& graph, const BatchPoint& point);
/// The motion of the IMU after a keyframe, at its present state.
ReadoutMotion motion_of(const BatchGraph& graph, const BatchKeyframe& keyframe);
/// How long after its keyframe an image may still be exposed: until then there must be samples.
Time readout_span(const InertialBatchInput& input);
/// Sets what the IMU measured in that time, at the biases of the keyframe's state. `imu`:
/// BatchGraph::imu.
void set_readout(const InertialBatchInput& input, const ImuCorrection* imu, ImuBuffer& buffer,
                 BatchKeyframe& keyframe);

/// The graph's landmark in the form of the filter's charts and measurements.
Clone anchor_of(const BatchGraph& graph, const BatchPoint& point);
Landmark landmark_of(const InertialBatchInput& input, const BatchGraph& graph,
                     const BatchPoint& point);

/// The errors [rotation, position, velocity, biases] of a state against the prior's mean, reference
/// chart.
Vector15d start_error(const BatchGraph& graph, const InertialState& state);
/// The same whitened, and their derivative by the state's own errors.
Vector15d start_residual(const BatchGraph& graph, const InertialState& state,
                         Matrix15d* derivative);

}  // namespace chasles::smooth_detail
