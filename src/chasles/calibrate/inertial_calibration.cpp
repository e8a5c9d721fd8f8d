#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_calibration.hpp>
#include <chasles/calibrate/inertial_search_detail.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

using calibrate_detail::aligned;
using calibrate_detail::first_rig;
using calibrate_detail::inertial_covariance;
using calibrate_detail::inertial_instants;
using calibrate_detail::InertialInstant;
using calibrate_detail::InertialProblem;
using calibrate_detail::InertialRig;
using calibrate_detail::InertialWeights;
using calibrate_detail::pieces_of;
using calibrate_detail::prior_sigmas;
using calibrate_detail::searched;

// A sensor that is read the other way round has a negative readout time, and its first line last.
// The covariance follows.
void flip_negative_readout(InertialRig& x, const InertialLayout& layout, std::size_t c,
                           MatrixXd& covariance) {
  const Camera& camera = x.cameras[c];
  Shutter& shutter = x.cameras[c].shutter;
  if (shutter.readout >= 0) return;
  using enum ReadoutDirection;
  const bool by_rows = shutter.direction == kDown || shutter.direction == kUp;
  const double last = 1 - 1.0 / (by_rows ? camera.height : camera.width);
  x.offsets[c] += last * shutter.readout;
  MatrixXd T = MatrixXd::Identity(layout.rows(), layout.rows());
  T(layout.offset_row(c), layout.readout_row(c)) = last;
  T(layout.readout_row(c), layout.readout_row(c)) = -1;
  covariance = T * covariance * T.transpose();
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

void check_scales(const InertialCalibration& found) {
  constexpr double kMostSigmas = 10;  // in its sigmas before any view
  for (int i = 0; i < std::min(found.imu.size(), ImuCorrection::kScales); ++i) {
    const int row = found.layout.imu_row() + i;
    if (std::abs(found.values[row]) <= kMostSigmas * found.prior_sigmas[row]) continue;
    throw InputError(fmt::format(
        "{} would be {:.3g}, expected {:.2g} at most: are units and axes of the IMU, and the size "
        "of the target, right?",
        found.names[static_cast<std::size_t>(row)], found.values[row],
        kMostSigmas * found.prior_sigmas[row]));
  }
}

ExplainedView explained(const InertialProblem& problem, const InertialRig& x, std::size_t k,
                        const TargetView& view) {
  const auto c = static_cast<std::size_t>(view.camera);
  ExplainedView result{.view = view,
                       .cam_T_target = x.cameras[c].cam_T_imu * x.states[k].world_T_imu.inverse(),
                       .errors = problem.errors(x, k, view),
                       .rms = 0};
  for (const Vector2d& error : result.errors) result.rms += error.squaredNorm();
  result.rms =
      std::sqrt(result.rms / static_cast<double>(std::max<std::size_t>(1, result.errors.size())));
  return result;
}

// What was seen, and how the rig moved.
void add_path(const InertialProblem& problem, const InertialRig& x, InertialCalibration& result) {
  const std::vector<InertialInstant>& instants = problem.instants();
  Time seconds{};
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    result.biases += x.states[k].biases() / static_cast<double>(x.states.size());
    result.state_times.push_back(instants[k].time);
    if (k > 0 && instants[k].recording == instants[k - 1].recording) {
      seconds += instants[k].time - instants[k - 1].time;
    }
    for (const TargetView* view : instants[k].views) {
      result.views.push_back(explained(problem, x, k, *view));
    }
  }
  result.states = x.states;
  result.seconds = to_seconds(seconds);
}

}  // namespace

std::size_t InertialCalibrationInput::recording_of(Time time) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(borders, time) - borders.begin());
}

void add_recording(InertialCalibrationInput& input, std::vector<TargetView> views,
                   std::vector<ImuSample> imu) {
  constexpr std::chrono::seconds kPause(10);  // longer than clocks may differ
  std::vector<TargetView>& all = input.cameras.views;
  Time last = Time::min(), first = Time::max();
  for (const TargetView& view : all) last = std::max(last, view.time);
  for (const ImuSample& sample : input.imu) last = std::max(last, sample.time);
  for (const TargetView& view : views) first = std::min(first, view.time);
  for (const ImuSample& sample : imu) first = std::min(first, sample.time);
  if (last != Time::min() && first != Time::max()) {
    input.borders.push_back(last + kPause / 2);
    const Time shift = last + kPause - first;
    for (TargetView& view : views) view.time += shift;
    for (ImuSample& sample : imu) sample.time += shift;
  }
  std::ranges::move(views, std::back_inserter(all));
  std::ranges::move(imu, std::back_inserter(input.imu));
}

InertialLayout::InertialLayout(const std::vector<LensForm>& lenses, bool has_readout, int imu_rows,
                               std::vector<std::string> shape_names, std::size_t recordings)
    : lenses_(lenses),
      has_readout_(has_readout),
      imu_rows_(imu_rows),
      shape_names_(std::move(shape_names)),
      recordings_(recordings) {
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
  for (std::size_t r = 0; r < recordings_; ++r) {
    const std::string of = recordings_ > 1 ? fmt::format("recording{}.", r) : "";
    names.insert(names.end(), {of + "gravity_1", of + "gravity_2"});
  }
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
  const RotationAlignment alignment = aligned(input, alone);
  ImuCorrection imu;
  imu.has_g_sensitivity = false;
  imu.has_scale = imu.has_misalignment = input.has_imu_errors;
  const InertialLayout layout(input.cameras.lenses, input.has_readout, imu.size(),
                              input.cameras.shape.names, input.recordings());
  InertialProblem problem(input, layout,
                          inertial_instants(alone.views, input, alignment.time_offset),
                          alone.pixel_sigma);
  InertialWeights weights{.sigma = alone.pixel_sigma};
  int iterations = 0;
  InertialRig x = searched(problem, layout, first_rig(input, alone, alignment, problem.instants()),
                           weights, iterations);
  MatrixXd covariance = inertial_covariance(problem, layout, x);
  for (std::size_t c = 0; layout.has_readout() && c < layout.cameras(); ++c) {
    flip_negative_readout(x, layout, c, covariance);
  }
  InertialCalibration result{.cameras = x.cameras,
                             .time_offsets = x.offsets,
                             .gravity_target = x.gravity,
                             .imu = x.imu,
                             .biases = Vector6d::Zero(),
                             .shape = x.shape,
                             .names = layout.names(x.imu),
                             .values = inertial_values(x, layout),
                             .covariance = std::move(covariance),
                             .prior_sigmas = prior_sigmas(input, layout, x.imu),
                             .layout = layout,
                             .alone = std::move(alone),
                             .pixel_sigma = weights.sigma,
                             .pieces = pieces_of(problem).back() + 1,
                             .correlation_factor = weights.correlation,
                             .gyroscope_factor = weights.gyroscope,
                             .accelerometer_factor = weights.accelerometer,
                             .state_times = {},
                             .states = {},
                             .iterations = iterations,
                             .views = {}};
  check_scales(result);
  add_path(problem, x, result);
  return result;
}

}  // namespace chasles
