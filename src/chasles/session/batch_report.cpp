#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/session/batch_report.hpp>

namespace chasles {
namespace {

nlohmann::ordered_json one_batch_json(const BatchReport& r) {
  return {{"converged", r.converged},
          {"stalled", r.stalled},
          {"decrease_left", r.decrease_left},
          {"iterations", r.iterations},
          {"successful_steps", r.successful},
          {"initial_cost", r.initial_cost},
          {"final_cost", r.final_cost},
          {"cost_per_dof", r.cost_per_dof},
          {"covariance_factor", r.covariance_factor},
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

void append_factor(double factor, const char* which, std::vector<std::string>& remarks) {
  if (std::abs(factor - 1) < 0.005) return;
  remarks.push_back(
      fmt::format("{} {:.2f} times those of independent pixel noise (batch.covariance_factor; "
                  "docs/covariance.md)",
                  which, factor));
}

}  // namespace

nlohmann::ordered_json batch_json(const BatchReport& r) {
  nlohmann::ordered_json json = one_batch_json(r);
  if (r.parts > 1) json["parts"] = r.parts;
  if (r.parts_failed > 0) json["parts_failed"] = r.parts_failed;
  return json;
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
          {"steps_refused", r.steps_rejected},
          {"frames_not_converged", r.frames_not_converged},
          {"covariance_factor", r.covariance_factor}};
}

void append_timing(const WindowReport& r, nlohmann::ordered_json& timing) {
  timing["window_seconds"] = r.seconds;
}

void append_timing(const BatchReport& r, nlohmann::ordered_json& timing) {
  timing["batch_seconds_solve"] = r.seconds_solve;
  timing["batch_seconds_covariance"] = r.seconds_covariance;
}

void append_remarks(const BatchReport& r, std::vector<std::string>& remarks) {
  if (r.parts > 1) {
    remarks.push_back(
        fmt::format("the IMU has no samples for more than 0.5 s in {} places: the {} parts between "
                    "them are estimated separately, each from the filter's pose at its start",
                    r.parts - 1, r.parts));
  }
  if (r.parts_failed > 0) {
    remarks.push_back(
        fmt::format("{} of the {} parts keep the filter's estimates, and have no landmarks: {}",
                    r.parts_failed, r.parts, r.failure));
  }
  if (!r.converged) {
    remarks.push_back(fmt::format(
        "batch estimation did not converge within {} steps (batch.max_iterations)", r.iterations));
  }
  if (r.stalled) {
    remarks.push_back(fmt::format(
        "batch estimation stalled after {} steps: it accepts no further step, although a "
        "relative decrease of the cost by {:.2g} is predicted. Possible causes: wrong "
        "pixels, or a poor initial estimate",
        r.iterations, r.decrease_left));
  }
  if (r.cost_per_dof >= kMostCostPerDof) {
    remarks.push_back(fmt::format(
        "the squared residuals of batch estimation are {:.1f} times as large as the stated noise "
        "explains. Possible causes: a wrong minimum, or wrong noise or calibration",
        r.cost_per_dof));
  }
  append_factor(r.covariance_factor, "the covariances are", remarks);
  for (const std::string& name : r.unobservable) {
    remarks.push_back("neither pixels nor IMU determine " + name +
                      " at the start: it keeps its initial value");
  }
}

void append_remarks(const WindowReport& r, std::vector<std::string>& remarks) {
  append_factor(r.covariance_factor, "the last covariances are", remarks);
}

}  // namespace chasles
