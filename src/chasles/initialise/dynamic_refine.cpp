#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include <chasles/eval/chi2.hpp>
#include <chasles/initialise/dynamic_refine.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// To convergence; views that do not fit are removed before each.
struct Stage {
  Shooting shooting;
  int iterations;
};
constexpr std::array kStages{Stage{Shooting::kSingle, 6}, Stage{Shooting::kSingle, 6},
                             Stage{Shooting::kMultiple, 8}};
constexpr int kFewestTracks = 5;
constexpr double kFarAway = 0.02;     // inverse depth of a point behind the camera [1/m]
constexpr double kNearest = 0.1;      // [m]
constexpr double kOutlier = 4;        // a view's residual, in standard deviations
constexpr double kRightTrack = 0.98;  // probability that a correct track is kept
constexpr double kLeastMisfit = 0.1;  // lower limit of the pixel noise
constexpr double kConverged = 1e-5;   // decrease of the cost in a step, relative to the cost
constexpr double kLeastPosition =
    1e-6;  // noise of a position, so that one sample between two keyframes, which determines six of
           // nine components, suffices [m]

std::vector<Preintegration> preintegrate_all(const MotionWindow& window, const Vector6d& biases,
                                             const ImuNoise& noise) {
  std::vector<Preintegration> between;
  for (const auto& intervals : window.intervals) {
    between.push_back(preintegrate(intervals, biases, noise));
    between.back().Q.diagonal().array() += kLeastPosition * kLeastPosition;
  }
  return between;
}

std::optional<std::vector<Matrix9d>> whitenings_of(const std::vector<Preintegration>& between) {
  std::vector<Matrix9d> all;
  for (const Preintegration& p : between) {
    const std::optional<Eigen::MatrixXd> one = whitening_of(p.Q);
    if (!one) return std::nullopt;
    all.emplace_back(*one);
  }
  return all;
}

// Aligns gravity with nav's z axis; the heading is that of the shortest rotation.
InertialState first_state(const LinearMotion& linear, const Vector6d& biases) {
  InertialState state;
  state.world_T_imu.R = so3::between(-linear.gravity, Eigen::Vector3d::UnitZ());
  state.v_world = state.world_T_imu.R * linear.v;
  state.accelerometer_bias = biases.head<3>();
  state.gyroscope_bias = biases.tail<3>();
  return state;
}

// The point nearest to a track's rays, equally weighted, in the axes of its first view.
Eigen::Vector3d point_of(const MotionWindow& window, const MotionUnknowns& motion,
                         const PlaneTrack& track) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const PlaneView& view : track) {
    const SE3& world_T_imu = motion.keyframes[static_cast<std::size_t>(view.keyframe)].world_T_imu;
    const Eigen::Vector3d u = world_T_imu.R * view.ray_imu;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
    A += across;
    b += across * (world_T_imu * window.imu_T_cam[static_cast<std::size_t>(view.camera)].p);
  }
  const PlaneView& anchor = track.front();
  const SE3 cam_T_world =
      window.cam_T_imu[static_cast<std::size_t>(anchor.axes)] *
      motion.keyframes[static_cast<std::size_t>(anchor.keyframe)].world_T_imu.inverse();
  const double z = (cam_T_world * solve_symmetric(A, b)).z();
  return {anchor.xy.x(), anchor.xy.y(), z > kNearest ? 1 / z : kFarAway};
}

void set_points(const MotionWindow& window, MotionUnknowns& motion) {
  motion.points.clear();
  for (const PlaneTrack& track : window.tracks) {
    motion.points.push_back(point_of(window, motion, track));
  }
}

// Levenberg's iterations from a given motion. Damping is used only while a full step does not lower
// the cost; otherwise it would hold back the scale, which is the most uncertain direction.
struct Minimum {
  MotionStep at;
  MotionSystem system;
};
Minimum minimise(const MotionWindow& window, const MotionWeights& weights, MotionStep at,
                 Shooting shooting, int iterations) {
  Minimum best{.at = std::move(at), .system = {}};
  best.system = linearise(window, best.at.between, weights, best.at.motion);
  double damping = 0;
  for (int i = 0; i < iterations && damping < 1e3; ++i) {
    auto next = take_step(window, best.system, best.at, weights.gravity, shooting, damping);
    if (!next) {
      damping = std::max(1e-6, 10 * damping);
      continue;
    }
    optimise_points(window, weights, next->motion);
    MotionSystem there = linearise(window, next->between, weights, next->motion);
    if (!(there.cost < best.system.cost)) {
      if (there.cost < (1 + kConverged) * best.system.cost) break;
      damping = std::max(1e-6, 10 * damping);
      continue;
    }
    const bool converged = best.system.cost - there.cost < kConverged * best.system.cost;
    best = {.at = std::move(*next), .system = std::move(there)};
    damping = damping > 1e-6 ? damping / 10 : 0;
    if (converged) break;
  }
  return best;
}

bool has_three_keyframes(const PlaneTrack& track) {
  int count = 0, last = -1;
  for (const PlaneView& view : track) {
    count += view.keyframe != last;
    last = view.keyframe;
  }
  return count >= 3;
}

// A track without the views that do not fit, and the squares of the others per degree of freedom.
struct Fit {
  PlaneTrack track;
  double dof = 0, squares_per_dof = 0;
};

std::vector<Fit> fits_of(const MotionUnknowns& motion, const MotionWindow& window) {
  std::vector<Fit> fits;
  for (std::size_t i = 0; i < window.tracks.size(); ++i) {
    Fit fit{.track = {}};
    double squares = 0;
    for (const PlaneView& view : window.tracks[i]) {
      const auto r = view_residual(window, motion, i, view);
      if (!r || r->norm() >= kOutlier) continue;
      squares += r->squaredNorm();
      fit.track.push_back(view);
    }
    if (2 * fit.track.size() <= window.tracks[i].size()) continue;
    if (!has_three_keyframes(fit.track)) continue;
    fit.dof = 2 * static_cast<double>(fit.track.size()) - 3;
    fit.squares_per_dof = squares / fit.dof;
    fits.push_back(std::move(fit));
  }
  return fits;
}

// Removes views that do not fit, then tracks that fit worse than most. The tracks themselves show
// the true pixel noise. A wrong track may fit a static point so well that no single view is an
// outlier, and still distort the scale.
void drop_misfits(const MotionUnknowns& motion, MotionWindow& window) {
  std::vector<Fit> fits = fits_of(motion, window);
  window.tracks.clear();
  if (fits.empty()) return;
  std::vector<double> all;
  for (const Fit& fit : fits) all.push_back(fit.squares_per_dof);
  const auto middle = all.begin() + std::ssize(all) / 2;
  std::ranges::nth_element(all, middle);
  const double noise = std::max(*middle, kLeastMisfit);
  for (Fit& fit : fits) {
    if (fit.squares_per_dof > noise * chi2_quantile(kRightTrack, fit.dof) / fit.dof) continue;
    window.tracks.push_back(std::move(fit.track));
  }
}

// The covariance, and the length of the next step.
struct Certainty {
  Matrix11d covariance;
  double distance = 0;
};
std::optional<Certainty> certainty_of(const MotionSystem& system) {
  const ReducedSystem reduced = eliminate_points(system, 0);
  const Eigen::Index n = reduced.H.rows();
  const std::array<Eigen::Index, 11> rows{0, 1, 6, 7, 8, n - 6, n - 5, n - 4, n - 3, n - 2, n - 1};
  const Eigen::LLT<Eigen::MatrixXd> cholesky(reduced.H);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(n, 11);
  for (Eigen::Index i = 0; i < 11; ++i) unit(rows[static_cast<std::size_t>(i)], i) = 1;
  const Eigen::MatrixXd solved = cholesky.solve(unit);
  Matrix11d P;
  for (Eigen::Index i = 0; i < 11; ++i) P.row(i) = solved.row(rows[static_cast<std::size_t>(i)]);
  if (!P.allFinite()) return std::nullopt;
  return Certainty{.covariance = (P + P.transpose()) / 2,
                   .distance = std::sqrt(reduced.b.dot(cholesky.solve(reduced.b)))};
}

// From the linear motion. Far away points and little parallax make its speed too small, up to a
// local minimum where most views are outliers. If so, the search begins at a high speed as well.
Minimum first_minimum(const MotionWindow& window, const MotionWeights& weights, LinearMotion linear,
                      const Vector6d& biases, std::vector<Preintegration> between) {
  constexpr int kIterations = 20;
  constexpr double kFits = 1;   // cost a view
  constexpr double kFast = 10;  // [m/s]
  const auto minimum = [&] {
    MotionStep from{
        .motion = {.keyframes = {first_state(linear, biases)}, .biases = biases, .points = {}},
        .between = between};
    for (const Preintegration& p : between) {
      from.motion.keyframes.push_back(
          moved(from.motion.keyframes.back(), p, {0, 0, -weights.gravity}));
    }
    set_points(window, from.motion);
    return minimise(window, weights, std::move(from), Shooting::kSingle, kIterations);
  };
  Minimum best = minimum();
  if (best.system.cost < kFits * views_of(window)) return best;
  linear.v = kFast * linear.v.normalized();
  Minimum other = minimum();
  return other.system.cost < best.system.cost ? other : best;
}

}  // namespace

std::optional<RefinedMotion> refine_motion(MotionWindow window, const LinearMotion& linear,
                                           const Vector6d& biases, const Vector6d& bias_sigma,
                                           const ImuNoise& noise, double gravity) {
  std::vector<Preintegration> between = preintegrate_all(window, biases, noise);
  const auto imu = whitenings_of(between);
  if (!imu || window.tracks.size() < kFewestTracks) return std::nullopt;
  const MotionWeights weights{.imu = *imu, .bias_sigma = bias_sigma, .gravity = gravity};
  Minimum at = first_minimum(window, weights, linear, biases, std::move(between));
  for (const auto& [shooting, iterations] : kStages) {
    if (!std::isfinite(at.system.cost)) return std::nullopt;
    at.at.between = preintegrate_all(window, at.at.motion.biases, noise);
    drop_misfits(at.at.motion, window);
    if (window.tracks.size() < kFewestTracks) return std::nullopt;
    set_points(window, at.at.motion);
    at = minimise(window, weights, std::move(at.at), shooting, iterations);
  }
  if (!std::isfinite(at.system.cost)) return std::nullopt;
  const std::optional<Certainty> certainty = certainty_of(at.system);
  if (!certainty) return std::nullopt;
  const int views = views_of(window), tracks = static_cast<int>(window.tracks.size());
  const int dof = 2 * views - 3 * tracks - 5;
  return RefinedMotion{.motion = std::move(at.at.motion),
                       .covariance = certainty->covariance,
                       .misfit = at.system.squares / std::max(dof, 1),
                       .distance = certainty->distance,
                       .views = views,
                       .tracks = tracks};
}

}  // namespace chasles
