#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include <chasles/eval/nees.hpp>
#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/lab/loops.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/sim/random.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// What a component of nothing is uncertain by [m, rad].
constexpr double kLeastSigma = 1e-4;

SE3 true_pose(const LoopsSettings& s, int step) {
  const auto at = [&](double k) -> Vector3d {
    const double angle = 2 * std::numbers::pi * s.loops * k / s.steps;
    return {s.radius * std::cos(angle), s.radius * std::sin(angle),
            s.undulation * std::sin(2 * angle)};
  };
  const Vector3d x = (at(step + 1e-3) - at(step - 1e-3)).normalized();
  const Vector3d y = Vector3d::UnitZ().cross(x).normalized();
  SE3 pose;
  pose.R << x, y, x.cross(y);
  pose.p = at(step);
  return pose;
}

std::vector<Vector3d> true_landmarks(const LoopsSettings& s) {
  const Random random{s.seed};
  std::vector<Vector3d> points;
  for (int i = 0; i < s.landmarks; ++i) {
    const auto draw = [&](std::uint32_t component) {
      return random.uniform(Stream::kLandmark, static_cast<std::uint64_t>(i), component);
    };
    const double angle = 2 * std::numbers::pi * draw(0);
    const double distance = s.radius * (0.4 + 1.4 * draw(1));
    points.emplace_back(distance * std::cos(angle), distance * std::sin(angle),
                        8 * (draw(2) - 0.5));
  }
  return points;
}

bool in_view(const LoopsSettings& s, const Vector3d& p_imu) {
  return p_imu.norm() < s.range && p_imu.x() > std::cos(s.field_of_view / 2) * p_imu.norm();
}

Vector3d sigma_of(const LoopsSettings& s, const Vector3d& value) {
  return (s.sigma * value.cwiseAbs()).cwiseMax(kLeastSigma);
}

// z = R^T (Y - p) + n (math.md §3, with the identity for a camera).
Measurement measure_point(const State& x, int landmark, const Vector3d& z, const Vector3d& sigma) {
  const Matrix3d Rt = x.world_T_imu.R.transpose();
  const Vector3d from_imu =
      x.landmarks[static_cast<std::size_t>(landmark)].p_world - x.world_T_imu.p;
  Measurement result;
  result.landmark = landmark;
  result.residual = z - Rt * from_imu;
  result.d_core.resize(3, 6);
  result.d_core << Rt * hat(from_imu), -Rt;
  result.d_landmark = Rt;
  result.noise = sigma.cwiseAbs2().asDiagonal();
  return result;
}

NewLandmark begin_point(const State& x, LandmarkId id, const Vector3d& z, const Vector3d& sigma) {
  NewLandmark result;
  result.id = id;
  result.p_world = x.world_T_imu * z;
  result.d_pose << -hat(x.world_T_imu.R * z), Matrix3d::Identity();
  result.noise = x.world_T_imu.R * sigma.cwiseAbs2().asDiagonal() * x.world_T_imu.R.transpose();
  return result;
}

class Loops {
 public:
  Loops(const LoopsSettings& settings, const std::string& chart, std::uint64_t run)
      : s_(settings),
        random_(random_of_run(settings.seed, run)),
        points_(true_landmarks(settings)),
        filter_(error_chart(chart), initial(settings), Eigen::MatrixXd::Zero(6, 6),
                {.compress_map = true, .keep_map = false}) {}

  void move(int step) {
    const Vector6d twist = se3::log(true_pose(s_, step - 1).inverse() * true_pose(s_, step));
    BodyVelocityNoise noise;
    BodyVelocity odometry;
    for (int i = 0; i < 3; ++i) {
      noise.sample_sigma[i] = std::max(s_.sigma * std::abs(twist[i]), kLeastSigma);
      noise.sample_sigma[3 + i] = std::max(s_.sigma * std::abs(twist[3 + i]), kLeastSigma);
      odometry.angular_imu[i] =
          twist[i] + noise.sample_sigma[i] * draw(Stream::kAngularNoise, step, i);
      odometry.linear_imu[i] =
          twist[3 + i] + noise.sample_sigma[3 + i] * draw(Stream::kLinearNoise, step, i);
    }
    filter_.propagate(predict({.velocity_state = false, .gyro_bias = false, .scale = false},
                              filter_.state(), odometry, 1, noise));
  }

  UpdateReport look(int step) {
    const SE3 imu_T_world = true_pose(s_, step).inverse();
    std::vector<Measurement> known;
    std::vector<NewLandmark> fresh;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vector3d p_imu = imu_T_world * points_[i];
      if (!in_view(s_, p_imu)) continue;
      const Vector3d sigma = sigma_of(s_, p_imu);
      Vector3d z = p_imu;
      const auto index = static_cast<int>(static_cast<std::size_t>(step) * points_.size() + i);
      for (int k = 0; k < 3; ++k) z[k] += sigma[k] * draw(Stream::kPixelNoise, index, k);
      const auto id = static_cast<LandmarkId>(i);
      const auto found = index_.find(id);
      if (found != index_.end()) {
        known.push_back(measure_point(filter_.state(), found->second, z, sigma));
      } else {
        fresh.push_back(begin_point(filter_.state(), id, z, sigma));
      }
    }
    const UpdateReport report = filter_.update(known);
    // Their places are those of the updated pose.
    for (NewLandmark& landmark : fresh) {
      landmark =
          begin_point(filter_.state(), landmark.id, before_.inverse() * landmark.p_world,
                      sigma_of(s_, imu_T_world * points_[static_cast<std::size_t>(landmark.id)]));
      index_.emplace(landmark.id, static_cast<int>(index_.size()));
    }
    filter_.add(fresh);
    return report;
  }

  void remember_pose() { before_ = filter_.state().world_T_imu; }
  const Ekf& filter() const { return filter_; }
  bool lost() const { return !filter_.state().world_T_imu.p.allFinite(); }

 private:
  static State initial(const LoopsSettings& settings) {
    State x;
    x.world_T_imu = true_pose(settings, 0);
    x.additive.resize(0);
    return x;
  }
  double draw(Stream stream, int index, int component) const {
    return random_.normal(stream, static_cast<std::uint64_t>(index),
                          static_cast<std::uint32_t>(component));
  }

  LoopsSettings s_;
  Random random_;
  std::vector<Vector3d> points_;
  Ekf filter_;
  SE3 before_;
  std::unordered_map<LandmarkId, int> index_;  // in the state, where none is ever retired
};

}  // namespace

Trial run_loops(const LoopsSettings& settings, const std::string& chart, std::uint64_t run) {
  const PoseError coordinates = pose_error_of(chart);
  Loops loops(settings, chart, run);
  Trial trial{.filter = chart, .run = run};
  for (int step = 0; step <= settings.steps; ++step) {
    if (step > 0) loops.move(step);
    loops.remember_pose();
    const UpdateReport report = loops.look(step);
    const SE3& estimate = loops.filter().state().world_T_imu;
    const SE3 truth = true_pose(settings, step);
    const PoseNees nees = pose_nees(coordinates, truth, estimate,
                                    loops.filter().core_covariance().topLeftCorner<6, 6>());
    trial.points.push_back({.seconds = static_cast<double>(step),
                            .position_error = (truth.p - estimate.p).norm(),
                            .attitude_error = so3::log(truth.R * estimate.R.transpose()).norm(),
                            .nees_position = nees.position,
                            .nees_attitude = nees.attitude,
                            .nees_pose = nees.pose,
                            .nis = report.nis,
                            .nis_dof = report.dof});
    trial.diverged = loops.lost() || !(trial.points.back().position_error < kDivergedAt);
    if (trial.diverged) break;
  }
  return trial;
}

}  // namespace chasles
