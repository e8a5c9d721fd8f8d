#include "batch_report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace chasles::app {
nlohmann::ordered_json batch_json(const BatchReport& r) {
  return {{"converged", r.converged},
          {"stalled", r.stalled},
          {"decrease_left", r.decrease_left},
          {"iterations", r.iterations},
          {"successful_steps", r.successful},
          {"initial_cost", r.initial_cost},
          {"final_cost", r.final_cost},
          {"cost_per_dof", r.cost_per_dof},
          {"solver", name_of(r.solver)},
          {"keyframes", r.keyframes},
          {"landmarks", r.landmarks},
          {"landmarks_left_out", r.landmarks_left_out},
          {"landmarks_split", r.landmarks_split},
          {"observations", r.observations},
          {"observations_unusable", r.unusable},
          {"observations_gated", r.gated},
          {"loss_width", r.loss_width},
          {"observations_outlying", r.outliers},
          {"dropped_frames", r.dropped_frames},
          {"unobservable", r.unobservable}};
}

nlohmann::ordered_json window_json(const WindowReport& r) {
  return {{"window", r.window},
          {"keyframes", r.keyframes},
          {"landmarks", r.landmarks},
          {"observations", r.observations},
          {"observations_unusable", r.unusable},
          {"observations_gated", r.gated},
          {"dropped_frames", r.dropped_frames},
          {"steps", r.steps},
          {"steps_refused", r.steps_refused},
          {"frames_not_converged", r.frames_not_converged}};
}

void append_timing(const WindowReport& r, nlohmann::ordered_json& timing) {
  timing["window_seconds"] = r.seconds;
}

void append_timing(const BatchReport& r, nlohmann::ordered_json& timing) {
  timing["batch_seconds_solve"] = r.seconds_solve;
  timing["batch_seconds_covariance"] = r.seconds_covariance;
}

void append_remarks(const BatchReport& r, std::vector<std::string>& remarks) {
  if (!r.converged) {
    remarks.push_back(fmt::format(
        "batch estimation had not converged after {} steps (batch.max_iterations)", r.iterations));
  }
  if (r.stalled) {
    remarks.push_back(
        fmt::format("batch estimation stalled after {} steps: it accepts none any more, but its "
                    "cost should fall "
                    "by {:.2g} of itself: wrong pixels, or a beginning that is too far away",
                    r.iterations, r.decrease_left));
  }
  if (r.cost_per_dof >= kMostCostPerDof) {
    remarks.push_back(fmt::format(
        "batch estimation ended where its residuals are {:.1f} times what the sensors' noise makes "
        "(squared): a wrong minimum, or noise and calibration that are not as stated",
        r.cost_per_dof));
  }
  for (const std::string& name : r.unobservable) {
    remarks.push_back("neither pixels nor IMU tell " + name +
                      " at the start: it is what the start says");
  }
}

}  // namespace chasles::app
