#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <chasles/base/constants.hpp>
#include <chasles/initialise/dynamic_refine.hpp>
#include <chasles/initialise/dynamic_start.hpp>
#include <chasles/initialise/gyroscope_bias.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

constexpr double kAtBestFit = 0.3;  // posterior standard deviations

Vector6d bias_sigma(const InitialiserSettings& s) {
  Vector6d sigma;
  sigma.head<3>().setConstant(s.accelerometer_bias_sigma);
  sigma.tail<3>().setConstant(s.gyroscope_bias_sigma);
  return sigma;
}

bool has_stereo(const MotionWindow& window, const InitialiserSettings& s) {
  return window.stereo_tracks >= s.min_tracks;
}

// The rotations of the keyframes, by the gyroscope and by the refined motion.
using Rotations = std::vector<Eigen::Matrix3d>;
Rotations rotations_of(const std::vector<Preintegration>& between) {
  Rotations R(1, Eigen::Matrix3d::Identity());
  for (const Preintegration& p : between) R.push_back(R.back() * p.delta.world_T_imu.R);
  return R;
}
Rotations rotations_of(const MotionUnknowns& motion) {
  Rotations R;
  for (const InertialState& state : motion.keyframes) R.push_back(state.world_T_imu.R);
  return R;
}

// Median over the tracks of the largest angle between the rays of one camera, without the rotation.
struct Parallax {
  double angle = 0, pixels = 0;
};
Parallax median_parallax(const MotionWindow& window, const Rotations& R) {
  std::vector<std::pair<double, double>> all;
  for (const PlaneTrack& track : window.tracks) {
    const PlaneView& first = track.front();
    const Eigen::Vector3d u = R[static_cast<std::size_t>(first.keyframe)] * first.ray_imu;
    double angle = 0;
    for (const PlaneView& view : track) {
      if (view.camera != first.camera) continue;
      const Eigen::Vector3d v = R[static_cast<std::size_t>(view.keyframe)] * view.ray_imu;
      angle = std::max(angle, std::asin(std::min(1.0, u.cross(v).norm())));
    }
    all.emplace_back(angle, angle * window.focal[static_cast<std::size_t>(first.camera)]);
  }
  if (all.empty()) return {};
  const auto middle = all.begin() + std::ssize(all) / 2;
  std::ranges::nth_element(all, middle);
  return {.angle = middle->first, .pixels = middle->second};
}

double rms_speed(const MotionUnknowns& motion) {
  double sum = 0;
  for (const InertialState& state : motion.keyframes) sum += state.v_world.squaredNorm();
  return std::sqrt(sum / static_cast<double>(motion.keyframes.size()));
}

double largest_sigma(const Eigen::MatrixXd& covariance) {
  return std::sqrt(symmetric_eigen(covariance).values.maxCoeff());
}

void require_parallax(const Parallax& parallax, const InitialiserSettings& s,
                      std::vector<Requirement>& requirements) {
  requirements.push_back(at_least("parallax", parallax.pixels, s.min_parallax, "px"));
  requirements.push_back(at_least("parallax angle", kDegrees * parallax.angle,
                                  kDegrees * s.min_parallax_angle, "deg"));
}

void assess(const RefinedMotion& refined, const LinearMotion& linear, double offered,
            const InitialiserSettings& s, std::vector<Requirement>& requirements) {
  const double speed = std::max(rms_speed(refined.motion), 1e-6);
  const double v_sigma = largest_sigma(refined.covariance.block<3, 3>(2, 2));
  const double tilt = largest_sigma(refined.covariance.topLeftCorner<2, 2>());
  requirements.push_back(
      at_most("error of gravity's magnitude", std::abs(linear.free_gravity - s.gravity),
              std::hypot(s.max_gravity_deviation, 3 * linear.free_gravity_sigma), "m/s^2"));
  requirements.push_back(
      at_most("uncertainty of the scale (of velocity, against the speed)", 100 * v_sigma / speed,
              100 * std::max(s.max_scale_sigma, s.least_velocity_sigma / speed), "%"));
  requirements.push_back(at_most("uncertainty of roll and pitch", kDegrees * tilt,
                                 kDegrees * s.max_tilt_sigma, "deg"));
  requirements.push_back(
      at_most("squared residual per degree of freedom", refined.misfit, s.max_misfit, ""));
  requirements.push_back(
      at_most("distance from the best fit", refined.distance, kAtBestFit, "sigma"));
  requirements.push_back(
      at_most("largest bias against its prior",
              refined.motion.biases.cwiseQuotient(bias_sigma(s)).cwiseAbs().maxCoeff(), kBiasReach,
              "sigma"));
  requirements.push_back(at_least("observations that fit the motion", 100 * refined.views / offered,
                                  100 * s.min_inliers, "%"));
  requirements.push_back(at_least("tracks that fit the motion", refined.tracks, s.min_tracks, ""));
}

// The information of the priors and a fraction of the data's; never less certain than the priors.
Matrix15d start_covariance(const RefinedMotion& refined, const InitialiserSettings& s) {
  Eigen::Matrix<double, 11, 1> prior = Eigen::Matrix<double, 11, 1>::Zero();
  prior.tail<6>() = bias_sigma(s).cwiseAbs2().cwiseInverse();
  Matrix11d information = inverse_symmetric(refined.covariance);
  information.diagonal() -= prior;
  information /= s.inflation;
  prior.head<2>().setConstant(1 / (s.tilt_sigma * s.tilt_sigma));
  prior.segment<3>(2).setConstant(1 / (s.velocity_sigma * s.velocity_sigma));
  information.diagonal() += prior;
  information = (information + information.transpose()).eval() / 2;
  const Matrix11d P = inverse_symmetric(information);
  Eigen::Matrix<double, 15, 11> J = Eigen::Matrix<double, 15, 11>::Zero();
  J.topLeftCorner<2, 2>().setIdentity();
  J.bottomRightCorner<9, 9>().setIdentity();
  const Matrix15d full = congruence(J, P);
  return (full + full.transpose()) / 2;
}

// A gyroscope bias and the linear motion with it.
struct Candidate {
  MotionWindow window;
  Vector6d biases = Vector6d::Zero();
  std::vector<Preintegration> between;
  std::optional<LinearMotion> linear;
  double cost = 0;  // of the views; dropped views count with the maximum cost
};
Candidate candidate(const MotionWindow& window, const Eigen::Vector3d& bias, const ImuNoise& noise,
                    double gravity) {
  Candidate c{.window = window, .between = {}, .linear = {}};
  c.biases.tail<3>() = bias;
  drop_mismatched(c.window, bias);
  for (const auto& intervals : window.intervals) {
    c.between.push_back(preintegrate(intervals, c.biases, noise));
  }
  c.linear = linear_motion(c.window, c.between, gravity);
  const int kept = c.linear ? views_of(c.window) : 0;
  c.cost = kTruncation * kTruncation * (views_of(window) - kept) + (c.linear ? c.linear->cost : 0);
  return c;
}

// In a narrow scene, rotation is not separable from translation; a bias of zero is then the better
// choice.
Candidate best_candidate(const MotionWindow& window, const ImuNoise& noise,
                         const InitialiserSettings& s) {
  const Eigen::Vector3d bias = gyroscope_bias(window, s.gyroscope_bias_sigma);
  Candidate best = candidate(window, bias, noise, s.gravity);
  Candidate none = candidate(window, Eigen::Vector3d::Zero(), noise, s.gravity);
  return none.cost < best.cost ? none : best;
}

InertialStart start_of(const RefinedMotion& refined, Time time, const InitialiserSettings& s) {
  const InertialState& first = refined.motion.keyframes.front();
  return {.time = time,
          .nav_T_imu = first.world_T_imu,
          .v_nav = first.v_world,
          .accelerometer_bias = first.accelerometer_bias,
          .gyroscope_bias = first.gyroscope_bias,
          .covariance = start_covariance(refined, s)};
}

}  // namespace

StartAttempt dynamic_start(const MotionWindow& window, const ImuNoise& noise,
                           const InitialiserSettings& s) {
  StartAttempt attempt;
  auto& requirements = attempt.requirements;
  const bool stereo = has_stereo(window, s);
  requirements.push_back(at_least("window", to_seconds(window.times.back() - window.times.front()),
                                  stereo ? s.min_stereo_window : s.min_window, "s"));
  requirements.push_back(
      at_least("tracks", static_cast<double>(window.tracks.size()), s.min_tracks, ""));
  if (!all_met(requirements)) return attempt;

  const int offered = views_of(window);
  const Candidate best = best_candidate(window, noise, s);
  requirements.back() = at_least("tracks that agree with the gyroscope",
                                 static_cast<double>(best.window.tracks.size()), s.min_tracks, "");
  if (!stereo) {
    require_parallax(median_parallax(best.window, rotations_of(best.between)), s, requirements);
  }
  if (!all_met(requirements)) return attempt;

  const auto& linear = best.linear;
  const auto refined =
      linear ? refine_motion(best.window, *linear, best.biases, bias_sigma(s), noise, s.gravity)
             : std::nullopt;
  if (!refined) {
    requirements.push_back(at_least("tracks that fit the motion", 0, s.min_tracks, ""));
    return attempt;
  }
  if (!stereo) {  // over some seconds, the gyroscope's bias alone looks like parallax
    requirements.erase(requirements.begin() + std::ssize(requirements) - 2, requirements.end());
    require_parallax(median_parallax(best.window, rotations_of(refined->motion)), s, requirements);
  }
  assess(*refined, *linear, offered, s, requirements);
  if (!all_met(requirements)) return attempt;
  attempt.start = start_of(*refined, window.times.front(), s);
  return attempt;
}

}  // namespace chasles
