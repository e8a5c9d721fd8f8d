#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/codec/image_source.hpp>
#include <chasles/lie/truth_pairing.hpp>
#include <chasles/recording/events.hpp>
#include <chasles/recording/georeference.hpp>
#include <chasles/recording/plan.hpp>

namespace chasles {

/// A landmark with a known position.
struct TrueLandmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m], in the frame of the true trajectory
};

/// The true motion at an instant, with the states that only an inertial filter estimates besides
/// the pose.
struct TrueMotion {
  Time time{};
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();             ///< [m/s]
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d::Zero();      ///< [rad/s]
};

/// The measurements of the sensors and, where known, the truth. Times rise strictly within
/// velocities, IMU samples, frames and truth; every number is finite. The readers and the simulator
/// guarantee this.
///
/// There are two kinds: body velocities with a rectified stereo pair, and IMU samples with any
/// cameras.
struct Recording {
  std::string name;
  StereoRig rig;
  std::vector<BodyVelocity> velocities;
  std::vector<Camera> cameras;
  /// Their numbers in the calibration, if some of it are left out or in another order; empty: 0, 1,
  /// 2, ...
  std::vector<std::size_t> camera_numbers;
  std::vector<ImuSample> imu;
  ImuConvention imu_convention = ImuConvention::kInstant;
  std::optional<ImuNoise> imu_noise;  ///< as the recording states it
  ImuRange imu_range;                 ///< as the recording states it; infinite: not stated
  std::vector<FeatureFrame> frames;
  std::shared_ptr<const ImageSource> images;  ///< the input of a front end, instead of `frames`
  /// One for each camera, of its size: black (0) where nothing is to be tracked; empty: none. A
  /// setting of a run takes their place (masks_of()).
  std::vector<GrayImage> masks;
  Trajectory truth;  ///< world_T_imu; empty where unknown
  /// Whether the z axis of the truth's world points up, as the recording states it.
  std::optional<bool> truth_level;
  bool truth_attitudes = true;  ///< false: it has positions alone, and its rotations are identities
  /// Of positions alone: the point whose positions they are, in IMU axes [m].
  Eigen::Vector3d truth_point_imu = Eigen::Vector3d::Zero();
  TruthPairing pairing = {};                 ///< of estimates with the truth
  std::vector<TrueMotion> true_motion;       ///< at the times of `truth`; empty where unknown
  std::vector<TrueLandmark> true_landmarks;  ///< empty where unknown
  Plan plan;                                 ///< of the place, in the truth's world
  std::optional<Georeference> georeference;  ///< of the truth's world, where known
  /// Standard deviations that the recording states; none if it does not.
  std::optional<BodyVelocitySigma> velocity_sigma;
  std::optional<Eigen::Vector4d> pixel_sigma;  ///< of (uL, vL, uR, vR) [px]
  std::optional<double> single_pixel_sigma;    ///< of u and of v of a PixelObservation [px]
  /// Whether the images are rendered with this calibration of the cameras, which then has no error.
  bool exact_calibration = false;
  /// One sentence for the user on each correction, omission or count of the reader.
  std::vector<std::string> remarks;
};

/// The number of frames, of tracks or of images.
std::size_t frame_count(const Recording& recording);
/// The time of the i-th of them; those of tracks come first.
Time frame_time(const Recording& recording, std::size_t i);

/// The median time between two frames that show this camera's image or tracks [s]; none of fewer
/// than two.
std::optional<double> frame_interval(const Recording& recording, std::size_t camera);

/// The earliest time of a frame, an image, a velocity or an IMU sample.
Time first_event(const Recording& recording);

/// Images are due for reading: recording.images->read(index).
struct ImagesDue {
  Time time{};
  std::size_t index = 0;
};

/// One measurement of any sensor.
using Event = EventsWith<ImagesDue>;

/// The recording in order of time. At the same instant, a velocity precedes a frame and a frame
/// precedes images. Of the IMU, all samples up to the first one that is not earlier precede the
/// frame, so that the motion up to the frame can be interpolated and need not be extrapolated.
class EventStream {
 public:
  /// The recording must outlive the stream.
  explicit EventStream(const Recording& recording) : recording_(&recording) {}

  /// The next event; none at the end.
  std::optional<Event> next();

 private:
  const Recording* recording_;
  std::size_t velocity_ = 0;
  std::size_t imu_ = 0;
  std::size_t frame_ = 0;
  std::size_t image_ = 0;
};

}  // namespace chasles
