#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <ceres/sized_cost_function.h>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/pose_fusion.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;

constexpr double kLongestGap = 0.5;  // [s]
constexpr double kLeast = 3;         // [s]
constexpr double kHuber = 3;         // standard deviations of a pose

// A measured pose. Block: motion.
class PoseCost final : public ceres::SizedCostFunction<6, kMotionNumbers> {
 public:
  PoseCost(const SE3& measured, const PoseFusionSettings& settings)
      : measured_(measured),
        per_radian_(1 / settings.rotation_sigma),
        per_metre_(1 / settings.position_sigma) {}

  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    const SE3 pose = read_pose(x[0]);
    const Eigen::Vector3d turned = so3::log(pose.R * measured_.R.transpose());
    Eigen::Map<Vector6d> r(residuals);
    r << per_radian_ * turned, per_metre_ * (pose.p - measured_.p);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 6, kMotionNumbers, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J.topLeftCorner<3, 3>() = per_radian_ * so3::left_jacobian_inverse(turned);
    J.block<3, 3>(3, 3) = per_metre_ * Eigen::Matrix3d::Identity();
    return true;
  }

 private:
  SE3 measured_;
  double per_radian_, per_metre_;
};

struct Graph {
  std::vector<InertialState> states;
  std::vector<ImuLink> links;
  Eigen::Vector3d gravity;
};

class FusionProblem final : public ProblemBlocks {
 public:
  FusionProblem(const Trajectory& poses, const Graph& graph, const PoseFusionSettings& settings)
      : ProblemBlocks({.keyframes = poses.size()}, "standard") {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      write_state(graph.states[k], motion(k), additive(k));
      ceres().AddResidualBlock(new PoseCost(poses[k].pose, settings), new ceres::HuberLoss(kHuber),
                               motion(k));
    }
    for (std::size_t k = 0; k + 1 < poses.size(); ++k) {
      ceres().AddResidualBlock(new LinkCost(graph.links[k], graph.gravity), nullptr, motion(k),
                               additive(k), motion(k + 1), additive(k + 1));
    }
  }

  InertialState state(std::size_t k) { return read_state(motion(k), additive(k)); }
};

Trajectory covered(const Trajectory& poses, const std::vector<ImuSample>& samples) {
  Trajectory result;
  for (const StampedPose& pose : poses) {
    if (samples.empty() || pose.time < samples.front().time || pose.time > samples.back().time) {
      continue;
    }
    result.push_back(pose);
  }
  return result;
}

void check_gaps(const Trajectory& poses, const std::vector<ImuSample>& samples) {
  const double length = poses.empty() ? 0 : to_seconds(poses.back().time - poses.front().time);
  if (length < kLeast) {
    throw InputError("poses and IMU samples: both cover " + std::to_string(length) +
                     " s, expected 3 s or more");
  }
  const auto check = [](const char* what, const auto& list) {
    for (std::size_t k = 1; k < list.size(); ++k) {
      const double gap = to_seconds(list[k].time - list[k - 1].time);
      if (gap > 0 && gap <= kLongestGap) continue;
      throw InputError(std::string(what) + ": found a step of " + std::to_string(gap) +
                       " s in time, expected more than 0 s and at most 0.5 s");
    }
  };
  check("poses", poses);
  check("IMU samples", samples);
}

Eigen::Vector3d velocity_at(const Trajectory& poses, std::size_t k) {
  const StampedPose& before = poses[k == 0 ? 0 : k - 1];
  const StampedPose& after = poses[std::min(k + 1, poses.size() - 1)];
  return (after.pose.p - before.pose.p) / to_seconds(after.time - before.time);
}

Graph graph_of(const Trajectory& poses, const std::vector<ImuSample>& samples,
               const PoseFusionSettings& settings) {
  ImuBuffer buffer(settings.imu);
  for (const ImuSample& sample : samples) buffer.add(sample);
  Graph graph;
  graph.gravity = Eigen::Vector3d(0, 0, -kStandardGravity);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    graph.states.push_back({.world_T_imu = poses[k].pose,
                            .v_world = velocity_at(poses, k),
                            .accelerometer_bias = settings.accelerometer_bias,
                            .gyroscope_bias = Eigen::Vector3d::Zero()});
    if (k + 1 == poses.size()) break;
    graph.links.push_back(imu_link(buffer.between(poses[k].time, poses[k + 1].time),
                                   graph.states[k].biases(), settings.noise));
  }
  return graph;
}

// Integrates the samples from one pose to the next, and distributes the difference at the end
// evenly.
void append_between(Time from, const InertialState& state, const StampedPose& to,
                    const Graph& graph, const ImuLink& link, Trajectory& result) {
  std::vector<InertialState> steps = {state};
  for (const ImuInterval& interval : link.intervals) {
    steps.push_back(integrate(steps.back(), interval, graph.gravity));
  }
  const SE3& end = steps.back().world_T_imu;
  const Eigen::Vector3d turn = so3::log(to.pose.R * end.R.transpose()), way = to.pose.p - end.p;
  const double whole = to_seconds(to.time - from);
  double since = 0;
  for (std::size_t i = 0; i + 1 < link.intervals.size(); ++i) {
    since += link.intervals[i].tau;
    const double part = since / whole;
    const SE3& pose = steps[i + 1].world_T_imu;
    result.push_back(
        {from + from_seconds(since), {so3::exp(part * turn) * pose.R, pose.p + part * way}});
  }
}

}  // namespace

PoseFusion fuse_poses(const Trajectory& world_T_imu, const std::vector<ImuSample>& samples,
                      const PoseFusionSettings& settings) {
  const Trajectory poses = covered(world_T_imu, samples);
  check_gaps(poses, samples);
  PoseFusion result;
  Graph graph = graph_of(poses, samples, settings);
  FusionProblem problem(poses, graph, settings);
  BatchReport report;
  const BatchSettings batch{.solver = BatchSolver::kSparseNormal};
  Search(batch, report).run(problem, batch.tolerance);
  if (!report.converged) {
    throw Error(ExitCode::kDiverged,
                "poses and IMU samples: found no motion that both agree on in " +
                    std::to_string(report.iterations) + " steps");
  }
  result.iterations = report.iterations;
  // Rows of the poses minus the components of the first state; links have as many rows as a state
  // has components.
  const double dof = 6 * static_cast<double>(poses.size()) - 15;
  result.cost_per_dof = 2 * report.final_cost / dof;
  for (std::size_t k = 0; k < poses.size(); ++k) graph.states[k] = problem.state(k);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const SE3& fused = graph.states[k].world_T_imu;
    result.position_moved += (fused.p - poses[k].pose.p).squaredNorm();
    result.rotation_moved += so3::log(fused.R * poses[k].pose.R.transpose()).squaredNorm();
    const StampedPose now{poses[k].time, fused};
    if (k > 0) {
      append_between(poses[k - 1].time, graph.states[k - 1], now, graph, graph.links[k - 1],
                     result.world_T_imu);
    }
    result.world_T_imu.push_back(now);
  }
  const auto count = static_cast<double>(poses.size());
  result.position_moved = std::sqrt(result.position_moved / count);
  result.rotation_moved = std::sqrt(result.rotation_moved / count);
  return result;
}

}  // namespace chasles
