#include <fmt/format.h>
#include <pybind11/stl.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/ate.hpp>

#include "arrays.hpp"
#include "module.hpp"

namespace chasles::python {
namespace {

constexpr std::array kAlignments{Alignment::kNone,       Alignment::kFirstPose,
                                 Alignment::kFirstLevel, Alignment::kPositionYaw,
                                 Alignment::kRigid,      Alignment::kSimilarity};

Alignment alignment_of(const std::string& text) {
  std::string names;
  for (const Alignment one : kAlignments) {
    if (name(one) == text) return one;
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", name(one));
  }
  throw UsageError(fmt::format("alignment: found '{}', expected one of {}", text, names));
}

py::dict align_columns(const py::array& times, const Rows& positions, const Rows& quaternions,
                       const py::array& truth_times, const Rows& truth_positions,
                       const Rows& truth_quaternions, const std::string& alignment) {
  const Trajectory estimate = trajectory_of("estimate", times, positions, quaternions);
  const Trajectory truth = trajectory_of("truth", truth_times, truth_positions, truth_quaternions);
  const MatchedTrajectories matched = associate(estimate, truth);
  const AbsoluteError error = absolute_error(matched, alignment_of(alignment));
  py::dict result;
  result["truth_T_estimate"] = matrix(error.transform.truth_T_estimate);
  result["scale"] = error.transform.scale;
  result["rank"] = error.transform.rank;
  result["matched"] = matched.truth.size();
  result["ate_m"] = error.position_m.rmse;
  result["attitude_deg"] = error.attitude_deg.rmse;
  return result;
}

}  // namespace

void bind_alignment(py::module_& m) {
  m.def("align", &align_columns, py::arg("time"), py::arg("position"), py::arg("quaternion"),
        py::arg("truth_time"), py::arg("truth_position"), py::arg("truth_quaternion"),
        py::arg("alignment"));
}

}  // namespace chasles::python
