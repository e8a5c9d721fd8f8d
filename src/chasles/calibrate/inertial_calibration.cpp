#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/calibrate/correlated_errors_detail.hpp>
#include <chasles/calibrate/inertial_calibration.hpp>
#include <chasles/calibrate/inertial_problem_detail.hpp>
#include <chasles/calibrate/levenberg_marquardt.hpp>
#include <chasles/calibrate/rotation_alignment.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

using calibrate_detail::columns_from;
using calibrate_detail::correlation_factor;
using calibrate_detail::independent_pieces;
using calibrate_detail::InertialInstant;
using calibrate_detail::InertialMotion;
using calibrate_detail::InertialProblem;
using calibrate_detail::InertialRig;
using calibrate_detail::Instant;
using calibrate_detail::kLongestLink;
using calibrate_detail::LinearisedRig;
using calibrate_detail::prior_sigmas;

constexpr double kMostUnexplained = 0.3;  // of the rates, for a first alignment
constexpr double kMostForce = 0.2;        // relative error of its mean
constexpr double kMostScaleSigmas = 10;   // of a scale, in its sigmas before any view
constexpr double kStale = 0.0005;         // change of an offset after which links begin anew [s]

// The views whose lines the IMU covers, by instants of the IMU's clock.
std::vector<InertialInstant> inertial_instants(const std::vector<ExplainedView>& views,
                                               const std::vector<ImuSample>& imu, double offset) {
  constexpr double kMargin = 0.1;  // [s]
  std::vector<InertialInstant> instants;
  const Time shift(static_cast<std::int64_t>(std::llround(1e9 * offset)));
  for (const ExplainedView& one : views) {
    const Time time = one.view.time + shift;
    if (to_seconds(time - imu.front().time) < kMargin ||
        to_seconds(imu.back().time - time) < kMargin) {
      continue;
    }
    if (instants.empty() || instants.back().time != time)
      instants.push_back({.time = time, .views = {}, .sample = {}});
    instants.back().views.push_back(&one.view);
  }
  return instants;
}

std::vector<int> pieces_of(const InertialProblem& problem) {
  std::vector<Instant> instants;
  for (const InertialInstant& one : problem.instants()) instants.push_back({one.time, one.views});
  return independent_pieces(instants);
}

// That of the lenses by the pixels alone: what else these show is eliminated.
double lens_correlation(const InertialProblem& problem, const InertialLayout& layout,
                        const InertialRig& x) {
  const std::optional<LinearisedRig> pixels = problem.pixels_alone(x);
  if (!pixels) return 1;
  const auto gradients = pixels->equations.border_gradients();
  const auto information = pixels->equations.border_information();
  if (!gradients || !information) return 1;
  std::vector<int> lenses;
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const auto rows = columns_from(layout.lens_row(c), layout.lens(c).parameters());
    lenses.insert(lenses.end(), rows.begin(), rows.end());
  }
  return correlation_factor(*information, *gradients, lenses, pieces_of(problem));
}

double inertial_scatter(const InertialProblem& problem, const InertialRig& x) {
  std::vector<double> sizes;
  for (std::size_t k = 0; k < problem.instants().size(); ++k) {
    for (const TargetView* view : problem.instants()[k].views) {
      for (const Vector2d& error : problem.errors(x, k, *view)) sizes.push_back(error.norm());
    }
  }
  return std::max(0.01, median(std::move(sizes)) / 1.17741);
}

InertialRig first_rig(const InertialCalibrationInput& input, const CamerasCalibration& alone,
                      const RotationAlignment& alignment,
                      const std::vector<InertialInstant>& instants) {
  InertialRig x{.cameras = alone.cameras,
                .offsets = std::vector<double>(alone.cameras.size(), alignment.time_offset),
                .gravity = {},
                .imu = {},
                .shape = alone.shape,
                .states = {}};
  x.imu.has_g_sensitivity = false;
  x.imu.has_scale = x.imu.has_misalignment = input.has_imu_errors;
  SE3 cam0_T_imu;  // its position follows
  cam0_T_imu.R = alignment.cam_R_imu;
  for (Camera& camera : x.cameras) {
    camera.cam_T_imu = camera.cam_T_imu * cam0_T_imu;
    if (input.has_readout) camera.shutter.readout = std::max(camera.shutter.readout, 0.001);
  }
  std::map<std::pair<Time, int>, SE3> poses;
  for (const ExplainedView& one : alone.views) {
    poses[{one.view.time, one.view.camera}] = one.cam_T_target;
  }
  ImuBuffer buffer({.convention = input.convention});
  for (const ImuSample& sample : input.imu) buffer.add(sample);
  Vector3d force = Vector3d::Zero();
  for (const InertialInstant& instant : instants) {
    const TargetView& view = *instant.views.front();
    const SE3 cam_T_target = poses.at({view.time, view.camera});
    InertialState state;
    state.world_T_imu =
        cam_T_target.inverse() * x.cameras[static_cast<std::size_t>(view.camera)].cam_T_imu;
    state.gyroscope_bias = alignment.gyroscope_bias;
    x.states.push_back(state);
    force += state.world_T_imu.R * buffer.at(instant.time)->specific_force_imu;
  }
  // Accelerations are zero in the mean.
  const double mean_force = force.norm() / static_cast<double>(instants.size());
  if (std::abs(mean_force / input.gravity - 1) > kMostForce) {
    throw InputError(fmt::format(
        "the mean of the specific force in the target's frame is {:.3g} m/s^2, expected about "
        "{:.3g}: are the samples in m/s^2, with gravity, and in the axes of the gyroscope?",
        mean_force, input.gravity));
  }
  x.gravity = -input.gravity * force.normalized();
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    const std::size_t a = k > 0 ? k - 1 : k, b = k + 1 < x.states.size() ? k + 1 : k;
    const double t = to_seconds(instants[b].time - instants[a].time);
    if (t > 0 && t < kLongestLink) {
      x.states[k].v_world = (x.states[b].world_T_imu.p - x.states[a].world_T_imu.p) / t;
    }
  }
  return x;
}

RotationAlignment alignment_of(const InertialCalibrationInput& input,
                               const CamerasCalibration& alone) {
  std::vector<SeenAttitude> attitudes;  // of the first camera
  for (const ExplainedView& one : alone.views) {
    const Camera& camera = alone.cameras[static_cast<std::size_t>(one.view.camera)];
    if (!attitudes.empty() && attitudes.back().time == one.view.time) continue;
    attitudes.push_back({one.view.time, camera.cam_T_imu.R.transpose() * one.cam_T_target.R});
  }
  const auto alignment = align_rotations(attitudes, input.imu);
  if (!alignment) {
    throw InputError(
        "the IMU and the views of the target have too little time in common: expected views in "
        "quick succession, at most 0.25 s apart (`--every`), by a clock within 1 s of the IMU's, "
        "at "
        "least 10 of them");
  }
  if (alignment->unexplained > kMostUnexplained) {
    throw InputError(fmt::format(
        "the gyroscope does not turn as the cameras do: {:.0f} % of their rates are unexplained, "
        "expected less than {:.0f} %: was the target static, is the motion brisk, and are units "
        "and clocks of the IMU right (`chasles check`)?",
        100 * alignment->unexplained, 100 * kMostUnexplained));
  }
  return *alignment;
}

// A sensor that is read the other way round has a negative readout time, and its first line last.
void flip_negative_readout(Camera& camera, double& time_offset) {
  Shutter& shutter = camera.shutter;
  if (shutter.readout >= 0) return;
  using enum ReadoutDirection;
  const bool by_rows = shutter.direction == kDown || shutter.direction == kUp;
  time_offset += shutter.readout * (1 - 1.0 / (by_rows ? camera.height : camera.width));
  shutter.readout = -shutter.readout;
  shutter.direction = shutter.direction == kDown    ? kUp
                      : shutter.direction == kUp    ? kDown
                      : shutter.direction == kRight ? kLeft
                                                    : kRight;
}

VectorXd inertial_values(const InertialRig& x, const InertialLayout& layout) {
  VectorXd values = VectorXd::Zero(layout.rows());
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const Camera& camera = x.cameras[c];
    values.segment(layout.lens_row(c), layout.lens(c).parameters()) = lens_parameters(camera);
    values.segment<3>(layout.pose_row(c)) = so3::log(camera.cam_T_imu.R);
    values.segment<3>(layout.pose_row(c) + 3) = camera.cam_T_imu.p;
    values[layout.offset_row(c)] = x.offsets[c];
    if (layout.has_readout()) values[layout.readout_row(c)] = camera.shutter.readout;
  }
  if (x.imu.size() > 0) values.segment(layout.imu_row(), x.imu.size()) = x.imu.parameters();
  values.tail(layout.shape_rows()) = x.shape;
  return values;
}

}  // namespace

InertialLayout::InertialLayout(const std::vector<LensForm>& lenses, bool has_readout, int imu_rows,
                               std::vector<std::string> shape_names)
    : lenses_(lenses),
      has_readout_(has_readout),
      imu_rows_(imu_rows),
      shape_names_(std::move(shape_names)) {
  int row = 0;
  for (const LensForm& lens : lenses_) {
    first_.push_back(row);
    row += lens.parameters() + 7 + (has_readout ? 1 : 0);
  }
  first_.push_back(row);
}

std::vector<std::string> InertialLayout::names(const ImuCorrection& imu) const {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < lenses_.size(); ++c) {
    const std::string of = fmt::format("cam{}.", c);
    for (const std::string& name : lens_parameter_names(lenses_[c])) names.push_back(of + name);
    for (const char* part : {"rotation", "position"}) {
      for (const char* axis : {"_x", "_y", "_z"}) names.push_back(of + part + axis);
    }
    names.push_back(of + "time_offset");
    if (has_readout_) names.push_back(of + "readout_time");
  }
  names.insert(names.end(), {"gravity_1", "gravity_2"});
  if (imu_rows_ > 0) {
    for (const std::string& name : imu.names()) names.push_back("imu." + name);
  }
  for (const std::string& name : shape_names_) names.push_back("target." + name);
  return names;
}

InertialCalibration calibrate_inertial(const InertialCalibrationInput& input) {
  if (input.imu.size() < 2) {
    throw InputError(
        fmt::format("found {} IMU samples, expected a recording with an IMU", input.imu.size()));
  }
  CamerasCalibration alone = calibrate_cameras(input.cameras);
  const RotationAlignment alignment = alignment_of(input, alone);
  ImuCorrection imu;
  imu.has_g_sensitivity = false;
  imu.has_scale = imu.has_misalignment = input.has_imu_errors;
  const InertialLayout layout(input.cameras.lenses, input.has_readout, imu.size(),
                              input.cameras.shape.names);
  double offset = alignment.time_offset;
  InertialProblem problem(input, layout, inertial_instants(alone.views, input.imu, offset),
                          alone.pixel_sigma);
  InertialRig x = first_rig(input, alone, alignment, problem.instants());
  int iterations = 0;
  double gyroscope = 1, accelerometer = 1, sigma = alone.pixel_sigma, correlation = 1;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    problem.make_links(x, gyroscope, accelerometer);
    const auto found = minimised(
        x, [&](const InertialRig& rig) { return problem.linearised(rig); },
        [&](const InertialRig& rig, const ChainEquations::Step& step) {
          return problem.moved(rig, step);
        });
    if (!found) throw InputError("a lens cannot have the corners where they were found");
    x = found->state;
    iterations += found->iterations;
    const bool is_last = round + 1 == kRounds;
    if (is_last && !found->converged) {
      throw InputError(fmt::format(
          "the search did not converge in {} steps: the motion does not determine all parameters; "
          "expected quick turns about all three axes and quick shifts, with the target in view",
          iterations));
    }
    if (is_last) break;
    // The noise that the residuals show.
    const auto [rotation, motion] = problem.link_squares(x);
    gyroscope = std::max(1.0, gyroscope * std::sqrt(rotation));
    accelerometer = std::max(1.0, accelerometer * std::sqrt(motion));
    sigma = inertial_scatter(problem, x);
    problem.set_sigma(sigma);
    correlation = lens_correlation(problem, layout, x);
    problem.set_sigma(sigma * std::sqrt(correlation));
    if (std::abs(x.offsets[0] - offset) > kStale) {
      // The states move to the times that the offset states now.
      const double change = x.offsets[0] - offset;
      offset = x.offsets[0];
      for (std::size_t k = 0; k < x.states.size(); ++k) {
        const InertialMotion later(x.states[k], x, problem.instants()[k], change);
        x.states[k].world_T_imu = later.world_T_imu;
        x.states[k].v_world = later.v_world;
      }
      std::vector<InertialInstant> instants = inertial_instants(alone.views, input.imu, offset);
      if (instants.size() != x.states.size()) {
        throw InputError("the IMU does not cover the views at the time offset that was found");
      }
      problem.set_instants(std::move(instants));
    }
  }
  const std::optional<LinearisedRig> linearised = problem.linearised(x);
  const std::optional<MatrixXd> information = linearised->equations.border_information();
  const Eigen::LLT<MatrixXd> factor(information.value_or(MatrixXd::Zero(1, 1)));
  if (!information || factor.info() != Eigen::Success) {
    throw InputError("the motion does not determine all parameters: expected turns about all axes");
  }
  MatrixXd T = MatrixXd::Identity(layout.rows(), layout.rows());
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const int row = layout.lens_row(c), n = layout.lens(c).parameters();
    T.block(row, row, n, n) = by_search_coordinates(
        layout.lens(c), search_coordinates(layout.lens(c), lens_parameters(x.cameras[c])));
  }
  InertialCalibration result{
      .cameras = x.cameras,
      .time_offsets = x.offsets,
      .gravity_target = x.gravity,
      .imu = x.imu,
      .biases = Vector6d::Zero(),
      .shape = x.shape,
      .names = layout.names(x.imu),
      .values = inertial_values(x, layout),
      .covariance = {},
      .layout = layout,
      .alone = std::move(alone),
      .pixel_sigma = sigma,
      .pieces = pieces_of(problem).back() + 1,
      .correlation_factor = correlation,
      .gyroscope_factor = gyroscope,
      .accelerometer_factor = accelerometer,
      .instants = problem.instants().size(),
      .seconds = to_seconds(problem.instants().back().time - problem.instants().front().time),
      .iterations = iterations,
      .views = {}};
  result.prior_sigmas = prior_sigmas(input, layout, x.imu);
  for (int i = 0; i < std::min(x.imu.size(), ImuCorrection::kScales); ++i) {
    const int row = layout.imu_row() + i;
    if (std::abs(result.values[row]) <= kMostScaleSigmas * result.prior_sigmas[row]) continue;
    throw InputError(fmt::format(
        "{} would be {:.3g}, expected {:.2g} at most: are units and axes of the IMU, and the size "
        "of the target, right?",
        result.names[static_cast<std::size_t>(row)], result.values[row],
        kMostScaleSigmas * result.prior_sigmas[row]));
  }
  for (std::size_t c = 0; layout.has_readout() && c < result.cameras.size(); ++c) {
    flip_negative_readout(result.cameras[c], result.time_offsets[c]);
  }
  result.covariance =
      T * factor.solve(MatrixXd::Identity(layout.rows(), layout.rows())) * T.transpose();
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    result.biases += x.states[k].biases() / static_cast<double>(x.states.size());
    for (const TargetView* view : problem.instants()[k].views) {
      ExplainedView one{
          .view = *view,
          .cam_T_target = x.cameras[static_cast<std::size_t>(view->camera)].cam_T_imu *
                          x.states[k].world_T_imu.inverse(),
          .errors = problem.errors(x, k, *view),
          .rms = 0};
      for (const Vector2d& error : one.errors) one.rms += error.squaredNorm();
      one.rms =
          std::sqrt(one.rms / static_cast<double>(std::max<std::size_t>(1, one.errors.size())));
      result.views.push_back(std::move(one));
    }
  }
  return result;
}

}  // namespace chasles
