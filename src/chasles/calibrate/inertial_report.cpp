#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibrate/live_motion.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>

namespace chasles {
namespace {

using InertialJson = nlohmann::ordered_json;

std::string unit_of_parameter(const std::string& name) {
  const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
  if (has(".fx") || has(".fy") || has(".cx") || has(".cy")) return "px";
  if (has("rotation") || has("gravity") || has("misalignment")) return "rad";
  if (has("position") || name.starts_with("target.")) return "m";
  if (has("time")) return "s";
  return "1";
}

double rms_of_views(const std::vector<ExplainedView>& views) {
  double squares = 0, corners = 0;
  for (const ExplainedView& view : views) {
    squares += view.rms * view.rms * static_cast<double>(view.errors.size());
    corners += static_cast<double>(view.errors.size());
  }
  return std::sqrt(squares / std::max(1.0, corners));
}

InertialJson rows_of(const Eigen::MatrixXd& matrix) {
  InertialJson rows = InertialJson::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    InertialJson row = InertialJson::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

InertialJson numbers(const Eigen::VectorXd& values) {
  InertialJson list = InertialJson::array();
  for (const double value : values) list.push_back(value);
  return list;
}

InertialJson transform(const SE3& pose) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = pose.R;
  T.topRightCorner<3, 1>() = pose.p;
  return rows_of(T);
}

}  // namespace

namespace {

// The parameter of a lens that is farthest from that of the views alone.
struct LensDifference {
  int parameter = 0;
  double alone = 0, sigma = 1, joint = 0;
  double sigmas() const { return std::abs(joint - alone) / sigma; }
};

LensDifference lens_difference(const InertialCalibration& found, std::size_t c) {
  const Eigen::VectorXd alone = lens_parameters(found.alone.cameras[c]);
  const Eigen::VectorXd joint = lens_parameters(found.cameras[c]);
  const Eigen::VectorXd sigmas = lens_covariance(found.alone, c).diagonal().cwiseSqrt();
  LensDifference most;
  for (int i = 0; i < alone.size(); ++i) {
    const LensDifference one{i, alone[i], sigmas[i], joint[i]};
    if (i == 0 || one.sigmas() > most.sigmas()) most = one;
  }
  return most;
}

// The common lenses and that of a camera, if none were compared before.
std::vector<LensTrial> lens_trials(const InertialReport& report, std::size_t c, int threads) {
  if (report.choices[c]) return report.choices[c]->trials;
  CamerasInput input = report.input.cameras;
  std::vector<std::vector<LensForm>> candidates;
  for (const LensForm& lens : input.lenses) candidates.push_back({lens});
  for (const LensForm& lens : common_lenses()) {
    if (lens != candidates[c][0]) candidates[c].push_back(lens);
  }
  input.lenses.clear();
  try {
    return choose_lenses(input, candidates, false, threads)[c]->trials;
  } catch (const InputError&) {
    return {};
  }
}

// Which lens it is, if another one predicts the views better.
std::string lens_verdict(const std::vector<LensTrial>& trials, const LensForm& lens) {
  constexpr double kBetter = 0.99;  // of the error
  const auto rms = [](const LensTrial& trial) {
    return std::isfinite(trial.held_out_rms) ? trial.held_out_rms
                                             : std::numeric_limits<double>::infinity();
  };
  const auto own = std::ranges::find(trials, lens, &LensTrial::lens);
  const auto best = std::ranges::min_element(trials, {}, rms);
  if (own == trials.end() || !(rms(*best) < kBetter * rms(*own))) {
    return fmt::format(
        "no other lens than {} fits better: was the target static, and is it flat but for a bend?",
        name_of(lens));
  }
  return fmt::format("the lens {} does not fit; the lens {} predicts its views to {:.3f} px{}",
                     name_of(lens), name_of(best->lens), rms(*best),
                     std::isfinite(rms(*own)) ? fmt::format(", not to {:.3f} px", rms(*own)) : "");
}

}  // namespace

std::vector<std::string> lens_contradictions(const InertialReport& report, int threads) {
  constexpr double kMostSigmas = 3;
  const InertialCalibration& found = report.calibration;
  std::vector<std::string> sentences;
  for (std::size_t c = 0; !report.input.has_readout && c < found.cameras.size(); ++c) {
    const LensDifference most = lens_difference(found, c);
    if (!(most.sigmas() > kMostSigmas)) continue;
    const LensForm& lens = found.layout.lens(c);
    sentences.push_back(fmt::format(
        "cam{}.{} is {:.6g} by the views alone and {:.6g} with the IMU, {:.1f} sigma apart: {}", c,
        lens_parameter_names(lens)[static_cast<std::size_t>(most.parameter)], most.alone,
        most.joint, most.sigmas(), lens_verdict(lens_trials(report, c, threads), lens)));
  }
  return sentences;
}

void calibrate_with_report(InertialReport& report,
                           const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
                           int threads) {
  CamerasInput& cameras = report.input.cameras;
  report.rms_before = rms_before(cameras);
  report.choices = calibrate_with_chosen_lenses(cameras, candidates, from_nothing, threads, [&] {
    report.calibration = calibrate_inertial(report.input);
  });
  const InertialCalibration& found = report.calibration;
  try {
    report.halves = compare_halves(report.input, found);
  } catch (const InputError& error) {
    report.remarks.push_back(fmt::format("no comparison of halves: {}", error.what()));
  }
  report.suspicious = suspicious_views(found.views);
  report.missing = missing_motion(report.input, found);
  std::ranges::move(missing_views(report.input.cameras, found.views),
                    std::back_inserter(report.missing));
  std::ranges::move(contradictions(found), std::back_inserter(report.remarks));
  std::ranges::move(lens_contradictions(report, threads), std::back_inserter(report.remarks));
  if (std::string few = few_pieces(found.pieces); !few.empty()) {
    report.remarks.push_back(std::move(few));
  }
}

std::vector<std::string> missing_motion(const InertialCalibrationInput& input,
                                        const InertialCalibration& calibration) {
  // Of the samples that have views.
  std::vector<ImuSample> samples;
  const Time offset(static_cast<std::int64_t>(1e9 * calibration.time_offsets[0]));
  for (const ImuSample& sample : input.imu) {
    if (!calibration.views.empty() && sample.time >= calibration.views.front().view.time + offset &&
        sample.time <= calibration.views.back().view.time + offset) {
      samples.push_back(sample);
    }
  }
  return missing_motion(samples, calibration.biases.tail<3>());
}

std::vector<std::string> contradictions(const InertialCalibration& calibration) {
  constexpr double kMostFactor = 3;
  std::vector<std::string> found;
  for (const auto& [sensor, factor, cause] :
       {std::tuple("accelerometer", calibration.accelerometer_factor,
                   "is the size of the target right, and the stated noise"),
        std::tuple("gyroscope", calibration.gyroscope_factor,
                   "is the stated noise right, and was the target static")}) {
    if (factor <= kMostFactor) continue;
    found.push_back(
        fmt::format("the residuals of the {} are {:.0f} times its stated noise, "
                    "expected about 1: {}?",
                    sensor, factor, cause));
  }
  constexpr double kInconsistent = 2.5;
  for (Eigen::Index i = 0; i < calibration.values.size(); ++i) {
    const double sigmas = std::abs(calibration.values[i]) / calibration.prior_sigmas[i];
    if (!(sigmas > kInconsistent)) continue;
    found.push_back(fmt::format(
        "{} is {:.3g}, {:.1f} times what is common: are tagSize, tagSpacing and the other sizes of "
        "the target right, and units and axes of the IMU?",
        calibration.names[static_cast<std::size_t>(i)], calibration.values[i], sigmas));
  }
  return found;
}

InertialJson inertial_json(const InertialReport& report) {
  const InertialCalibration& calibration = report.calibration;
  InertialJson cameras = InertialJson::array();
  const SE3 imu_T_cam0 = calibration.cameras[0].cam_T_imu.inverse();
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const Camera& camera = calibration.cameras[c];
    const int row = calibration.layout.lens_row(c), n = calibration.layout.lens(c).parameters();
    std::vector<ExplainedView> views;
    std::ranges::copy_if(
        calibration.views, std::back_inserter(views),
        [&](const ExplainedView& view) { return view.view.camera == static_cast<int>(c); });
    std::size_t corners = 0;
    for (const ExplainedView& view : views) corners += view.errors.size();
    const double before = report.rms_before[c];
    cameras.push_back(
        {{"lens", name_of(form_of(camera))},
         {"resolution", {camera.width, camera.height}},
         {"cam_T_imu", transform(camera.cam_T_imu)},
         {"cam_T_cam0", transform(camera.cam_T_imu * imu_T_cam0)},
         {"time_offset_s", calibration.time_offsets[c]},
         {"readout_time_s", camera.shutter.readout},
         {"views", views.size()},
         {"corners", corners},
         {"rms_px", rms_of_views(views)},
         {"rms_before_px", std::isfinite(before) ? InertialJson(before) : InertialJson(nullptr)},
         {"projection", projection_json(camera, calibration.covariance.block(row, row, n, n))}});
    if (report.halves) {
      cameras.back()["halves_px"] = report.halves->pixels[c];
      cameras.back()["halves_sigma_px"] = report.halves->pixels_sigma[c];
    }
    if (report.choices[c]) cameras.back()["lenses"] = trials_json(*report.choices[c]);
  }
  InertialJson parameters = InertialJson::array();
  for (Eigen::Index i = 0; i < calibration.values.size(); ++i) {
    const std::string& name = calibration.names[static_cast<std::size_t>(i)];
    parameters.push_back({{"name", name},
                          {"value", calibration.values[i]},
                          {"unit", unit_of_parameter(name)},
                          {"sigma", std::sqrt(calibration.covariance(i, i))}});
    if (!report.halves) continue;
    parameters.back()["halves_difference"] = report.halves->difference[i];
    parameters.back()["halves_sigma"] = report.halves->sigma[i];
  }
  InertialJson json = {{"instants", calibration.states.size()},
                       {"views", calibration.views.size()},
                       {"views_without_pose", calibration.alone.without_pose},
                       {"seconds", calibration.seconds},
                       {"rms_px", rms_of_views(calibration.views)},
                       {"pixel_sigma_px", calibration.pixel_sigma},
                       {"correlation_factor", calibration.correlation_factor},
                       {"gyroscope_factor", calibration.gyroscope_factor},
                       {"accelerometer_factor", calibration.accelerometer_factor},
                       {"gravity_target_m_per_s2", numbers(calibration.gravity_target.front())},
                       {"accelerometer_bias_m_per_s2", numbers(calibration.biases.head<3>())},
                       {"gyroscope_bias_rad_per_s", numbers(calibration.biases.tail<3>())},
                       {"iterations", calibration.iterations},
                       {"cameras", std::move(cameras)},
                       {"parameters", std::move(parameters)},
                       {"covariance", rows_of(calibration.covariance)},
                       {"suspicious", report.suspicious},
                       {"missing", report.missing},
                       {"remarks", report.remarks}};
  if (calibration.gravity_target.size() > 1) {
    InertialJson recordings = InertialJson::array();
    for (const Eigen::Vector3d& gravity : calibration.gravity_target) {
      recordings.push_back({{"gravity_target_m_per_s2", numbers(gravity)}});
    }
    json["recordings"] = std::move(recordings);
  }
  return json;
}

std::string run_settings(const InertialCalibration& calibration) {
  const InertialLayout& layout = calibration.layout;
  const Eigen::VectorXd sigmas = calibration.covariance.diagonal().cwiseSqrt();
  double rotation = 0, position = 0, offset = 0, readout = 0, focal = 0, point = 0, lens = 0;
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const int first = layout.lens_row(c), pose = layout.pose_row(c);
    const Camera& camera = calibration.cameras[c];
    rotation = std::max(rotation, sigmas.segment<3>(pose).maxCoeff());
    position = std::max(position, sigmas.segment<3>(pose + 3).maxCoeff());
    offset = std::max(offset, sigmas[layout.offset_row(c)]);
    if (layout.has_readout()) readout = std::max(readout, sigmas[layout.readout_row(c)]);
    focal = std::max({focal, sigmas[first] / camera.fx, sigmas[first + 1] / camera.fy});
    point = std::max({point, sigmas[first + 2], sigmas[first + 3]});
    // The others are correlated with the first coefficient, and a run takes them as independent.
    if (layout.lens(c).coefficients > 0) lens = std::max(lens, sigmas[first + 4]);
  }
  std::string text = fmt::format(
      "# Made by `chasles calibrate imu-cameras`: for `chasles run --config`, with this "
      "calibration.\n"
      "calibrate_extrinsics: considered\n"
      "initial_extrinsic_rotation_sigma: {:.3g}\n"
      "initial_extrinsic_translation_sigma: {:.3g}\n"
      "calibrate_intrinsics: considered\n"
      "initial_focal_sigma: {:.3g}\n"
      "initial_principal_point_sigma: {:.3g}\n"
      "initial_distortion_sigma: {:.3g}\n"
      "initial_time_offset_sigma: {:.3g}\n",
      rotation, position, focal, point, lens, offset);
  if (layout.has_readout()) text += fmt::format("initial_readout_sigma: {:.3g}\n", readout);
  return text;
}

std::string inertial_text(const InertialReport& report) {
  const InertialCalibration& calibration = report.calibration;
  std::string text = fmt::format(
      "{} instants in {:.1f} s, error {:.3f} px; noise of the IMU {:.1f} (gyroscope) and {:.1f} "
      "(accelerometer) times the stated one; variances {:.1f} times those of independent corners\n",
      calibration.states.size(), calibration.seconds, rms_of_views(calibration.views),
      calibration.gyroscope_factor, calibration.accelerometer_factor,
      calibration.correlation_factor);
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    text += fmt::format("cam{}: {}\n", c, name_of(form_of(calibration.cameras[c])));
  }
  for (const Eigen::Vector3d& g : calibration.gravity_target) {
    text += fmt::format("gravity in the target's frame: {:.4f} {:.4f} {:.4f} m/s^2\n", g.x(), g.y(),
                        g.z());
  }
  text += fmt::format("{:<36}{:>14}{:>12}{:>14}\n", "parameter", "value", "sigma",
                      report.halves ? "halves differ" : "");
  for (Eigen::Index i = 0; i < calibration.values.size(); ++i) {
    const std::string& name = calibration.names[static_cast<std::size_t>(i)];
    if (name.find("gravity_") != std::string::npos) continue;  // its direction is above
    text += fmt::format("{:<36}{:>14.6g}{:>12.3g}", name, calibration.values[i],
                        std::sqrt(calibration.covariance(i, i)));
    if (report.halves) {
      text += fmt::format("{:>8.1f} sigma", report.halves->difference[i] / report.halves->sigma[i]);
    }
    text += fmt::format(" {}\n", unit_of_parameter(name));
  }
  for (const auto* list : {&report.suspicious, &report.missing, &report.remarks}) {
    for (const std::string& sentence : *list) text += sentence + "\n";
  }
  return text;
}

}  // namespace chasles
