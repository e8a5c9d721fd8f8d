#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/report/against_truth.hpp>

#include "arrays.hpp"
#include "module.hpp"
#include "python_run.hpp"

// The errors of a run against its truth, frame by frame: Run.errors().
namespace chasles::python {
namespace {

using Eigen::Index;

Eigen::VectorXd column(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  Eigen::VectorXd result(static_cast<Index>(rows.size()));
  for (Index i = 0; i < result.size(); ++i) result[i] = values[rows[static_cast<std::size_t>(i)]];
  return result;
}

// The truth in the world of the estimate.
Trajectory moved(const Trajectory& truth, const SE3& world_T_truth) {
  Trajectory result;
  for (const StampedPose& stamped : truth) {
    result.push_back({.time = stamped.time, .pose = world_T_truth * stamped.pose});
  }
  return result;
}

Run with_truth(const Run& run, const Trajectory& truth) {
  Run other;
  other.extra_names = run.extra_names;
  other.states = run.states;
  other.truth = truth;
  other.pairing = run.pairing;
  return other;
}

// Rows are the matched states. `truth`: empty for that of the run.
py::dict errors_of(const PythonRun& r, const py::array& times, const Rows& positions,
                   const Rows& quaternions, const std::string& chart, bool attitudes) {
  const bool own = times.size() == 0;
  const Run run =
      with_truth(r.run, own ? r.run.truth : trajectory_of("truth", times, positions, quaternions));
  if (run.truth.empty()) {
    throw UsageError(fmt::format(
        "errors: the recording of {} has no truth; expected one, as in errors(truth)", r.run.name));
  }
  const AgainstTruth compared = against_truth(run, pose_error_of(chart), attitudes);
  if (!compared.problem.empty()) throw InputError("errors: " + compared.problem);
  const std::vector<std::size_t>& rows = compared.matched.estimate_index;
  const auto n = static_cast<Index>(rows.size());
  py::dict result = columns(compared.matched.estimate);
  const Trajectory first = moved(compared.matched.truth, compared.world_T_truth_first);
  const py::dict truth = columns(first);
  result["truth_position"] = truth["position"];
  result["truth_quaternion"] = truth["quaternion"];
  Rows position(n, 3), attitude(n, 3), position_sigma(n, 3), attitude_sigma(n, 3);
  Times state(n);
  for (Index i = 0; i < n; ++i) {
    const std::size_t row = rows[static_cast<std::size_t>(i)];
    state[i] = static_cast<std::int64_t>(row);
    const Vector6d& error = compared.error[row];
    const Vector6d sigma = run.states[row].pose_covariance.diagonal().cwiseMax(0).cwiseSqrt();
    attitude.row(i) = error.head<3>();
    position.row(i) = error.tail<3>();
    attitude_sigma.row(i) = sigma.head<3>();
    position_sigma.row(i) = sigma.tail<3>();
  }
  result["state"] = std::move(state);
  result["position_error"] = std::move(position);
  result["attitude_error"] = std::move(attitude);
  result["position_sigma"] = std::move(position_sigma);
  result["attitude_sigma"] = std::move(attitude_sigma);
  result["nees_pose"] = column(compared.nees_pose, rows);
  result["nees_position"] = column(compared.nees_position, rows);
  result["nees_attitude"] = column(compared.nees_attitude, rows);
  result["world_T_truth"] = matrix(compared.world_T_truth_first);
  result["world_T_truth_fit"] = matrix(compared.world_T_truth_fit);
  return result;
}

}  // namespace

void bind_errors_of_runs(py::module_& m) {
  m.def("errors", &errors_of, py::arg("run"), py::arg("truth_time"), py::arg("truth_position"),
        py::arg("truth_quaternion"), py::arg("chart"), py::arg("attitudes"));
}

}  // namespace chasles::python
