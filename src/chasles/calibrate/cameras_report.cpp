#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/in_parallel.hpp>
#include <chasles/base/median.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/calibrate/target_pose.hpp>
#include <chasles/calibrate/view_coverage.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSuspicious = 4;  // times the median view's error

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string unit_of(const std::string& name) {
  if (name.find("rotation") != std::string::npos) return "rad";
  if (name.find("position") != std::string::npos || name.starts_with("target.")) {
    return "m";
  }
  const std::string last = name.substr(name.find('.') + 1);
  return last == "fx" || last == "fy" || last == "cx" || last == "cy" ? "px" : "1";
}

// The value of each row: of rotations and positions those of cam_T_cam0.
Eigen::VectorXd values_of(const CamerasCalibration& calibration, const CamerasLayout& layout) {
  Eigen::VectorXd values(layout.rows());
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const Camera& camera = calibration.cameras[c];
    values.segment(layout.lens_row(c), layout.lens(c).parameters()) = lens_parameters(camera);
    if (c == 0) continue;
    values.segment<3>(layout.pose_row(c)) = so3::log(camera.cam_T_imu.R);
    values.segment<3>(layout.pose_row(c) + 3) = camera.cam_T_imu.p;
  }
  values.tail(layout.shape_rows()) = calibration.shape;
  return values;
}

double stated_rms(const CamerasInput& input, std::size_t c) {
  const Camera& camera = input.cameras[c];
  if (camera.fx <= 0) return kNaN;
  double squares = 0, corners = 0;
  for (const TargetView& view : input.views) {
    if (view.camera != static_cast<int>(c)) continue;
    const auto pose = target_pose(camera, input.corners, view);
    if (!pose) continue;
    squares += pose->rms * pose->rms * static_cast<double>(view.ids.size());
    corners += static_cast<double>(view.ids.size());
  }
  return corners > 0 ? std::sqrt(squares / corners) : kNaN;
}

struct CameraViews {
  std::vector<const ExplainedView*> views;
  std::size_t corners = 0;
  double rms = 0;
};

CameraViews views_of(const std::vector<ExplainedView>& views, std::size_t camera) {
  CameraViews result;
  double squares = 0;
  for (const ExplainedView& view : views) {
    if (view.view.camera != static_cast<int>(camera)) continue;
    result.views.push_back(&view);
    result.corners += view.view.ids.size();
    squares += view.rms * view.rms * static_cast<double>(view.view.ids.size());
  }
  result.rms = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, result.corners)));
  return result;
}

Json pose_json(const SE3& pose) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({pose.R(i, 0), pose.R(i, 1), pose.R(i, 2), pose.p(i)});
  }
  rows.push_back({0, 0, 0, 1});
  return rows;
}

Json camera_json(const CamerasReport& report, std::size_t c) {
  const CamerasCalibration& calibration = report.calibration;
  const Camera& camera = calibration.cameras[c];
  const CameraViews views = views_of(calibration.views, c);
  Json json = {{"lens", name_of(form_of(camera))},
               {"resolution", {camera.width, camera.height}},
               {"cam_T_cam0", pose_json(camera.cam_T_imu)},
               {"views", views.views.size()},
               {"corners", views.corners},
               {"rms_px", views.rms},
               {"rms_before_px", finite(report.rms_before[c])}};
  json["projection"] = projection_json(camera, lens_covariance(calibration, c));
  if (report.halves) {
    json["halves_px"] = report.halves->pixels[c];
    json["halves_sigma_px"] = report.halves->pixels_sigma[c];
  }
  if (report.choices[c]) json["lenses"] = trials_json(*report.choices[c]);
  return json;
}

Json matrix_json(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

ProjectionSummary projection_summary(const CamerasCalibration& calibration, std::size_t camera) {
  ProjectionSummary summary;
  const auto grid =
      projection_uncertainty(calibration.cameras[camera], lens_covariance(calibration, camera));
  for (const PixelUncertainty& one : grid) {
    summary.largest = std::max(summary.largest, one.sigma_px);
    summary.rms += one.sigma_px * one.sigma_px;
  }
  summary.rms = std::sqrt(summary.rms / static_cast<double>(std::max<std::size_t>(1, grid.size())));
  return summary;
}

void calibrate_with_report(CamerasReport& report,
                           const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
                           int threads) {
  CamerasInput& input = report.input;
  report.rms_before = rms_before(input);
  std::string no_halves;
  const auto calibrate = [&](std::size_t part) {
    if (part == 0) {
      report.calibration = calibrate_cameras(input);
      return;
    }
    try {
      report.halves = compare_halves(input);
      no_halves.clear();
    } catch (const InputError& error) {
      no_halves = error.what();
    }
  };
  report.choices = calibrate_with_chosen_lenses(input, candidates, from_nothing, threads,
                                                [&] { in_parallel(2, threads, calibrate); });
  if (const std::string few = few_pieces(report.calibration.pieces); !few.empty()) {
    report.remarks.push_back(few);
  }
  if (!no_halves.empty()) {
    report.remarks.push_back(fmt::format("no comparison of halves: {}", no_halves));
  }
  report.suspicious = suspicious_views(report.calibration.views);
  report.missing = missing_views(input, report.calibration.views);
}

std::vector<double> rms_before(const CamerasInput& input) {
  std::vector<double> errors;
  for (std::size_t c = 0; c < input.cameras.size(); ++c) errors.push_back(stated_rms(input, c));
  return errors;
}

double suspicious_rms(const std::vector<ExplainedView>& views) {
  std::vector<double> errors;
  for (const ExplainedView& view : views) errors.push_back(view.rms);
  return errors.empty() ? 0 : kSuspicious * median(errors);
}

std::string few_pieces(int pieces) {
  constexpr int kFew = 20;
  if (pieces >= kFew) return "";
  return fmt::format(
      "the views are {} independent ones, of which each may have many: move the target or the "
      "cameras more, to {} or more other views",
      pieces, kFew);
}

std::vector<std::string> suspicious_views(const std::vector<ExplainedView>& views) {
  std::vector<std::string> sentences;
  const double limit = suspicious_rms(views);
  for (const ExplainedView& view : views) {
    if (view.rms <= limit) continue;
    sentences.push_back(
        fmt::format("cam{} at {:.3f} s: {:.2f} px over {} corners, the median view has {:.2f} px",
                    view.view.camera, to_seconds(view.view.time), view.rms, view.view.ids.size(),
                    limit / kSuspicious));
  }
  return sentences;
}

Json trials_json(const LensChoice& choice) {
  Json trials = Json::array();
  for (const LensTrial& trial : choice.trials) {
    trials.push_back({{"lens", name_of(trial.lens)},
                      {"held_out_rms_px", finite(trial.held_out_rms)},
                      {"fault", trial.fault}});
  }
  return trials;
}

Json projection_json(const Camera& camera, const Eigen::MatrixXd& covariance) {
  Json grid = Json::array();
  for (const PixelUncertainty& one : projection_uncertainty(camera, covariance)) {
    grid.push_back({one.pixel.x(), one.pixel.y(), one.sigma_px, one.sigma_rad});
  }
  return {{"columns", {"u_px", "v_px", "sigma_px", "sigma_rad"}}, {"grid", std::move(grid)}};
}

std::vector<std::string> missing_views(const CamerasInput& input,
                                       const std::vector<ExplainedView>& views) {
  ViewCoverage coverage(input.cameras, input.corners);
  for (const ExplainedView& view : views) {
    coverage.add(view.view);
    coverage.add_pose(view.view.camera, view.cam_T_target);
  }
  return coverage.missing();
}

Json cameras_json(const CamerasReport& report) {
  const CamerasCalibration& calibration = report.calibration;
  const CamerasLayout layout = calibration.layout();
  const Eigen::VectorXd values = values_of(calibration, layout);
  const std::vector<std::string> names = layout.names();
  const Eigen::VectorXd sigmas = calibration.covariance.diagonal().cwiseSqrt();
  Json parameters = Json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    Json one = {
        {"name", name}, {"value", values[i]}, {"unit", unit_of(name)}, {"sigma", sigmas[i]}};
    if (report.halves) {
      one["halves_difference"] = report.halves->difference[i];
      one["halves_sigma"] = report.halves->sigma[i];
    }
    parameters.push_back(std::move(one));
  }
  Json cameras = Json::array();
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    cameras.push_back(camera_json(report, c));
  }
  Json json = {{"pixel_sigma_px", calibration.pixel_sigma},
               {"correlation_factor", calibration.correlation_factor},
               {"views", calibration.views.size()},
               {"views_without_pose", calibration.without_pose},
               {"iterations", calibration.iterations},
               {"cameras", std::move(cameras)},
               {"parameters", std::move(parameters)},
               {"covariance", matrix_json(calibration.covariance)},
               {"suspicious", report.suspicious},
               {"missing", report.missing},
               {"remarks", report.remarks}};
  if (report.halves) json["held_out_rms_px"] = report.halves->held_out_rms;
  return json;
}

std::string cameras_text(const CamerasReport& report) {
  const CamerasCalibration& calibration = report.calibration;
  const CamerasLayout layout = calibration.layout();
  const Eigen::VectorXd values = values_of(calibration, layout);
  const std::vector<std::string> names = layout.names();
  std::string text;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const CameraViews views = views_of(calibration.views, c);
    const ProjectionSummary projection = projection_summary(calibration, c);
    text += fmt::format("cam{}: {}, {} views, {} corners, error {:.3f} px", c,
                        name_of(form_of(calibration.cameras[c])), views.views.size(), views.corners,
                        views.rms);
    if (std::isfinite(report.rms_before[c])) {
      text += fmt::format(" (before {:.3f} px)", report.rms_before[c]);
    }
    text += fmt::format("; projection known to {:.3f} px, at worst {:.3f} px\n", projection.rms,
                        projection.largest);
  }
  text += fmt::format("{:<20}{:>14}{:>12}{:>14}\n", "parameter", "value", "sigma", "halves differ");
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    text += fmt::format("{:<20}{:>14.6g}{:>12.3g}", name, values[i],
                        std::sqrt(calibration.covariance(i, i)));
    if (report.halves) {
      text += fmt::format("{:>8.1f} sigma", report.halves->difference[i] / report.halves->sigma[i]);
    }
    text += fmt::format(" {}\n", unit_of(name));
  }
  for (const auto* list : {&report.suspicious, &report.missing, &report.remarks}) {
    for (const std::string& sentence : *list) text += sentence + "\n";
  }
  return text;
}

}  // namespace chasles
