#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/calibrate/cameras_calibration.hpp>
#include <chasles/calibrate/chain_equations.hpp>

/// The cost of a calibration of cameras. Private to the calibrate folder.
namespace chasles::calibrate_detail {

/// The views of an instant, whose target has one pose.
struct Instant {
  Time time{};
  std::vector<const TargetView*> views;
};

/// By time, and each by camera.
std::vector<Instant> instants_of(std::vector<const TargetView*> views);

struct RigState {
  std::vector<Camera> cameras;     ///< cam_T_imu: cam_T_cam0
  std::vector<SE3> cam0_T_target;  ///< of each instant
  Eigen::VectorXd shape = Eigen::VectorXd(0);
};

/// Equations at a state, and half of the sum of squares under the loss.
struct LinearisedRig {
  ChainEquations equations;
  double cost = 0;

  std::optional<ChainEquations::Step> solve(double damping) const {
    return equations.solve(damping);
  }
};

/// R = Exp(d[0..2]) Rhat, p = phat + d[3..5].
void move(SE3& pose, const Vector6d& d);

/// first, first + 1, ...: `count` of them.
std::vector<int> columns_from(int first, int count);

/// The pixels of all corners, by cameras, poses of the target and its shape.
class RigProblem {
 public:
  /// `corners` must outlive it.
  RigProblem(const ShapedCorners& corners, std::vector<Instant> instants,
             const CamerasLayout& layout)
      : corners_(corners), instants_(std::move(instants)), layout_(layout) {}

  const ShapedCorners& corners() const { return corners_; }
  const std::vector<Instant>& instants() const { return instants_; }
  double sigma() const { return sigma_; }  ///< of a pixel
  void set_sigma(double sigma) { sigma_ = sigma; }

  /// None where a corner has no pixel.
  std::optional<LinearisedRig> linearised(const RigState& x) const;
  /// None outside of the limits of a lens.
  std::optional<RigState> moved(const RigState& x, const ChainEquations::Step& step) const;

 private:
  bool add(const RigState& x, std::size_t instant, const TargetView& view,
           LinearisedRig& result) const;
  void add_priors(const RigState& x, LinearisedRig& result) const;

  const ShapedCorners& corners_;
  std::vector<Instant> instants_;
  CamerasLayout layout_;
  double sigma_ = 1;
};

}  // namespace chasles::calibrate_detail
