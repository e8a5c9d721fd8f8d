#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include <chasles/base/constants.hpp>
#include <chasles/base/processor_time.hpp>
#include <chasles/lab/loops.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/velocity/body_velocity_model.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The least sigma of a component, used where the component is zero [m, rad].
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

std::vector<Vector3d> true_points(const LoopsSettings& s) {
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

// z = R^T (Y - p) + n (docs/derivations.md, D38, with the identity for a camera). With first
// estimates the Jacobian uses the landmark's initial position; the pose is always the prediction.
Measurement measure_point(const State& x, int index, const Vector3d& z, const Vector3d& sigma,
                          Linearisation at) {
  const Matrix3d Rt = x.world_T_imu.R.transpose();
  const Landmark& landmark = x.landmarks[static_cast<std::size_t>(index)];
  const Vector3d& p_linear =
      at == Linearisation::kFirstEstimates ? landmark.first : landmark.p_world;
  Measurement result;
  result.landmark = index;
  result.residual = z - Rt * (landmark.p_world - x.world_T_imu.p);
  result.d_core.resize(3, 6);
  result.d_core << Rt * hat(p_linear - x.world_T_imu.p), -Rt;
  result.d_landmark = Rt;
  result.noise = sigma.cwiseAbs2().asDiagonal();
  return result;
}

// `p_pose` is the position of the pose at which the derivative is taken.
NewLandmark initialise_point(const State& x, LandmarkId id, const Vector3d& z,
                             const Vector3d& sigma, const Vector3d& p_pose) {
  NewLandmark result;
  result.id = id;
  result.p_world = x.world_T_imu * z;
  result.d_pose << -hat(result.p_world - p_pose), Matrix3d::Identity();
  result.noise = x.world_T_imu.R * sigma.cwiseAbs2().asDiagonal() * x.world_T_imu.R.transpose();
  return result;
}

// The measurement of a landmark at a step.
struct PointMeasurement {
  LandmarkId id = 0;
  Vector3d z, sigma;  // [m], in IMU axes
};

class Loops {
 public:
  Loops(const LoopsSettings& settings, const InertialSlamSettings& filter, std::uint64_t run)
      : s_(settings),
        linearisation_(filter.uses_first_estimates() ? Linearisation::kFirstEstimates
                                                     : Linearisation::kCurrent),
        random_(random_of_run(settings.seed, run)),
        points_(true_points(settings)),
        filter_(error_chart(filter.chart), initial(settings), Eigen::MatrixXd::Zero(6, 6),
                {.map = settings.retire ? Ekf::Map::kPast : Ekf::Map::kFrozen,
                 .past = {.recalls = true, .records = true}}),
        p_predicted_(filter_.state().world_T_imu.p) {}

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
    Prediction next = predict({.velocity_state = false, .gyro_bias = false, .scale = false},
                              filter_.state(), odometry, 1, noise);
    if (linearisation_ == Linearisation::kFirstEstimates) {
      next.F.block<3, 3>(3, 0) = -hat(next.world_T_imu.p - p_predicted_);
    }
    p_predicted_ = next.world_T_imu.p;
    filter_.propagate(next);
  }

  // New landmarks are initialised at the updated pose.
  UpdateReport observe(int step) {
    std::vector<Measurement> known;
    std::vector<PointMeasurement> fresh;
    const std::vector<PointMeasurement> seen = measurements(step);
    if (s_.retire) revive(seen);
    const std::unordered_map<LandmarkId, int> indices = indices_in_state();
    for (const PointMeasurement& one : seen) {
      const auto found = indices.find(one.id);
      if (found == indices.end()) {
        fresh.push_back(one);
      } else {
        known.push_back(
            measure_point(filter_.state(), found->second, one.z, one.sigma, linearisation_));
      }
    }
    const UpdateReport report = filter_.update(known);
    initialise(fresh);
    if (!s_.retire) return report;
    retire(seen);
    filter_.remember_pose(std::chrono::seconds(step));
    return report;
  }

  const Ekf& filter() const { return filter_; }
  bool lost() const { return !filter_.state().world_T_imu.p.allFinite(); }

 private:
  static State initial(const LoopsSettings& settings) {
    State x;
    x.world_T_imu = true_pose(settings, 0);
    x.additive.resize(0);
    return x;
  }

  std::vector<PointMeasurement> measurements(int step) const {
    const SE3 imu_T_world = true_pose(s_, step).inverse();
    std::vector<PointMeasurement> result;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vector3d p_imu = imu_T_world * points_[i];
      if (!in_view(s_, p_imu)) continue;
      PointMeasurement one{
          .id = static_cast<LandmarkId>(i), .z = p_imu, .sigma = sigma_of(s_, p_imu)};
      const auto index = static_cast<int>(static_cast<std::size_t>(step) * points_.size() + i);
      for (int k = 0; k < 3; ++k) one.z[k] += one.sigma[k] * draw(Stream::kPixelNoise, index, k);
      result.push_back(one);
    }
    return result;
  }

  std::unordered_map<LandmarkId, int> indices_in_state() const {
    std::unordered_map<LandmarkId, int> indices;
    for (const Landmark& landmark : filter_.state().landmarks) {
      indices.emplace(landmark.id, static_cast<int>(indices.size()));
    }
    return indices;
  }

  void revive(const std::vector<PointMeasurement>& seen) {
    std::vector<int> numbers;
    for (const PointMeasurement& one : seen) {
      const auto known = inactive_.find(one.id);
      if (known == inactive_.end()) continue;
      numbers.push_back(known->second);
      inactive_.erase(known);
    }
    std::ranges::sort(numbers);
    filter_.revive(numbers);
  }

  void retire(const std::vector<PointMeasurement>& seen) {
    std::vector<int> gone;
    const auto& landmarks = filter_.state().landmarks;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const LandmarkId id = landmarks[i].id;
      if (std::ranges::find(seen, id, &PointMeasurement::id) != seen.end()) continue;
      gone.push_back(static_cast<int>(i));
      inactive_[id] = filter_.past().states() + static_cast<int>(gone.size()) - 1;
    }
    filter_.retire(gone);
  }

  void initialise(const std::vector<PointMeasurement>& fresh) {
    const State& x = filter_.state();
    const bool first = linearisation_ == Linearisation::kFirstEstimates;
    std::vector<NewLandmark> landmarks;
    for (const PointMeasurement& one : fresh) {
      landmarks.push_back(
          initialise_point(x, one.id, one.z, one.sigma, first ? p_predicted_ : x.world_T_imu.p));
    }
    filter_.add(landmarks);
  }

  double draw(Stream stream, int index, int component) const {
    return random_.normal(stream, static_cast<std::uint64_t>(index),
                          static_cast<std::uint32_t>(component));
  }

  LoopsSettings s_;
  Linearisation linearisation_;
  Random random_;
  std::vector<Vector3d> points_;
  Ekf filter_;
  Vector3d p_predicted_;                // of the pose, before the update
  std::map<LandmarkId, int> inactive_;  // numbers of past landmarks
};

}  // namespace

Trajectory loops_truth(const LoopsSettings& settings) {
  Trajectory truth;
  for (int step = 0; step <= settings.steps; ++step) {
    truth.push_back({.time = std::chrono::seconds(step), .pose = true_pose(settings, step)});
  }
  return truth;
}

std::vector<TrueLandmark> loops_landmarks(const LoopsSettings& settings) {
  std::vector<TrueLandmark> landmarks;
  for (const Vector3d& point : true_points(settings)) {
    landmarks.push_back({static_cast<LandmarkId>(landmarks.size()), point});
  }
  return landmarks;
}

Trial run_loops(const LoopsSettings& settings, const FilterVariant& filter, std::uint64_t run,
                KeepMap keep_map) {
  validate(settings);
  const double started = processor_seconds();
  const PoseError coordinates = pose_error_of(filter.settings.chart);
  Loops loops(settings, filter.settings, run);
  Trial trial{.filter = filter.name, .run = run};
  for (int step = 0; step <= settings.steps && !trial.diverged; ++step) {
    if (step > 0) loops.move(step);
    const UpdateReport report = loops.observe(step);
    TrialPoint point =
        pose_point(step, true_pose(settings, step), loops.filter().state().world_T_imu,
                   loops.filter().core_covariance().topLeftCorner<6, 6>(), coordinates);
    point.nis = report.nis;
    point.nis_dof = report.dof;
    trial.points.push_back(point);
    trial.estimate.push_back(
        {.time = std::chrono::seconds(step), .pose = loops.filter().state().world_T_imu});
    trial.diverged = loops.lost() || !(point.position_error < kDivergedAt);
  }
  trial.landmarks = loops.filter().past().map_size();
  trial.seconds_cpu = processor_seconds() - started;
  if (keep_map != KeepMap::kYes) return trial;
  Past::Estimates past = loops.filter().past().estimates();
  trial.map = std::move(past.landmarks);
  for (const PastPose& pose : past.poses) {
    const auto step = static_cast<int>(std::lround(to_seconds(pose.time)));
    trial.smoothed.push_back(
        pose_point(step, true_pose(settings, step), pose.map_T_imu, pose.covariance, coordinates));
  }
  return trial;
}

}  // namespace chasles
