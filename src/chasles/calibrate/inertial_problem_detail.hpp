#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/calibrate/inertial_calibration.hpp>
#include <chasles/calibrate/rig_problem_detail.hpp>
#include <chasles/smooth/terms/imu_link.hpp>

/// The cost of a calibration of cameras with an IMU. Private to the calibrate folder.
namespace chasles::calibrate_detail {

/// Without views for longer than this the chain of states is cut [s].
inline constexpr double kLongestLink = 1;

/// The views of an instant of the cameras, with a state of the IMU.
struct InertialInstant {
  Time time{};  ///< of the state, IMU's clock
  std::vector<const TargetView*> views;
  std::size_t recording = 0;
  ImuSample sample;  ///< at that time, as measured
  /// Half of its change, while lines are read [rad/s^2].
  Eigen::Vector3d rate_change = Eigen::Vector3d::Zero();
};

struct InertialRig {
  std::vector<Camera> cameras;
  std::vector<double> offsets;
  std::vector<Eigen::Vector3d> gravity;  ///< in the target's frame, of each recording [m/s^2]
  ImuCorrection imu = {};
  Eigen::VectorXd shape;
  std::vector<InertialState> states;  ///< of each instant; world: the target's frame
};

/// The motion of the IMU some seconds after the time of a state.
struct InertialMotion {
  Eigen::Vector3d rate, acceleration;  ///< [rad/s] in the IMU's axes, [m/s^2]
  SE3 world_T_imu;                     ///< then
  Eigen::Vector3d v_world;             ///< then [m/s]
  double delay = 0;                    ///< [s]

  InertialMotion(const InertialState& x, const InertialRig& rig, const InertialInstant& at,
                 double seconds);
};

/// Two directions across gravity, in which it turns.
Eigen::Matrix<double, 3, 2> across(const Eigen::Vector3d& gravity);

/// Of each parameter before any view; infinite where nothing is known.
Eigen::VectorXd prior_sigmas(const InertialCalibrationInput& input, const InertialLayout& layout,
                             const ImuCorrection& imu);

/// The pixels of all corners at their lines, and the samples between the instants.
class InertialProblem {
 public:
  /// `input` must outlive it.
  InertialProblem(const InertialCalibrationInput& input, const InertialLayout& layout,
                  std::vector<InertialInstant> instants, double pixel_sigma)
      : input_(input),
        corners_(input.cameras.corners, input.cameras.shape),
        layout_(layout),
        instants_(std::move(instants)),
        sigma_(pixel_sigma) {}

  const std::vector<InertialInstant>& instants() const { return instants_; }
  void set_sigma(double sigma) { sigma_ = sigma; }  ///< of a pixel
  void set_instants(std::vector<InertialInstant> instants) { instants_ = std::move(instants); }

  /// The samples between the instants as links, at the biases of the states. Before all others.
  void make_links(const InertialRig& x, double gyroscope_factor, double accelerometer_factor);

  /// None where a corner has no pixel.
  std::optional<LinearisedRig> linearised(const InertialRig& x) const;
  /// The pixels alone, as if the poses were free.
  std::optional<LinearisedRig> pixels_alone(const InertialRig& x) const;
  /// None outside of the limits of a lens.
  std::optional<InertialRig> moved(const InertialRig& x, const ChainEquations::Step& step) const;

  /// Measured minus projected, at the lines of the corners. Empty where a corner has no pixel.
  std::vector<Eigen::Vector2d> errors(const InertialRig& x, std::size_t k,
                                      const TargetView& view) const;
  /// Mean squares of the whitened residuals of rotation, and of position and velocity.
  std::pair<double, double> link_squares(const InertialRig& x) const;

 private:
  /// From the time of the state until the line of a pixel [s].
  double delay(const InertialRig& x, std::size_t k, const TargetView& view,
               const Eigen::Vector2d& pixel) const;
  bool add_view(const InertialRig& x, std::size_t k, const TargetView& view,
                LinearisedRig& result) const;
  /// What is known of a state at which a chain begins.
  void add_first(const InertialRig& x, std::size_t k, LinearisedRig& result) const;
  void add_link(const InertialRig& x, std::size_t k, LinearisedRig& result) const;
  void add_prior(int row, double value, double sigma, LinearisedRig& result) const;
  void add_priors(const InertialRig& x, LinearisedRig& result) const;

  const InertialCalibrationInput& input_;
  ShapedCorners corners_;
  InertialLayout layout_;
  std::vector<InertialInstant> instants_;
  std::vector<std::optional<ImuLink>> links_;
  /// Of the noise of InertialInstant's rate and rate_change, an axis.
  Eigen::Matrix2d rate_root_ = Eigen::Matrix2d::Zero();
  double sigma_;
};

}  // namespace chasles::calibrate_detail
