#include <algorithm>
#include <array>
#include <set>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_halves.hpp>
#include <chasles/calibrate/inertial_search_detail.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using calibrate_detail::across;
using calibrate_detail::inertial_covariance;
using calibrate_detail::InertialInstant;
using calibrate_detail::InertialProblem;
using calibrate_detail::InertialRig;
using calibrate_detail::InertialWeights;
using calibrate_detail::least_rig;

constexpr double kLeastPiece = 3;  // longer than links between views [s]
constexpr double kUsualPieces = 10;
constexpr int kLeastPieces = 4;

static_assert(kLeastPiece > calibrate_detail::kLongestLink, "no link goes past the other half");

// Which of the two halves each instant belongs to.
std::vector<int> halves_of_instants(const InertialCalibrationInput& input,
                                    const InertialCalibration& calibration) {
  const std::vector<Time>& times = calibration.state_times;
  const double length = std::max(kLeastPiece, calibration.seconds / kUsualPieces);
  std::vector<int> halves;
  std::array<std::set<std::size_t>, 2> recordings;
  std::size_t begin = 0;
  int piece = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (to_seconds(times[k] - times[begin]) >= length) {
      begin = k;
      ++piece;
    }
    halves.push_back(piece % 2);
    recordings[static_cast<std::size_t>(halves.back())].insert(input.recording_of(times[k]));
  }
  if (piece + 1 < kLeastPieces || recordings[0] != recordings[1]) {
    throw InputError(
        fmt::format("found views over {:.1f} s, expected {:.0f} s or more of each recording",
                    calibration.seconds, kLeastPieces * kLeastPiece));
  }
  return halves;
}

struct HalfOfInstants {
  std::vector<InertialInstant> instants;
  std::vector<InertialState> states;
};

HalfOfInstants half_of(const InertialCalibrationInput& input,
                       const InertialCalibration& calibration, const std::vector<int>& halves,
                       int which) {
  HalfOfInstants half;
  std::size_t view = 0;
  for (std::size_t k = 0; k < halves.size(); ++k) {
    const Time time = calibration.state_times[k], seen = calibration.views[view].view.time;
    InertialInstant instant{
        .time = time, .views = {}, .recording = input.recording_of(time), .sample = {}};
    for (; view < calibration.views.size() && calibration.views[view].view.time == seen; ++view) {
      instant.views.push_back(&calibration.views[view].view);
    }
    if (halves[k] != which) continue;
    half.instants.push_back(std::move(instant));
    half.states.push_back(calibration.states[k]);
  }
  return half;
}

struct HalfRig {
  InertialRig rig;
  Eigen::MatrixXd covariance;
};

HalfRig calibrated_half(const InertialCalibrationInput& input,
                        const InertialCalibration& calibration, HalfOfInstants half) {
  const InertialWeights weights{.sigma = calibration.pixel_sigma,
                                .correlation = calibration.correlation_factor,
                                .gyroscope = calibration.gyroscope_factor,
                                .accelerometer = calibration.accelerometer_factor};
  InertialProblem problem(input, calibration.layout, std::move(half.instants),
                          weights.pixel_sigma());
  int iterations = 0;
  HalfRig result;
  result.rig = least_rig(problem,
                         {.cameras = calibration.cameras,
                          .offsets = calibration.time_offsets,
                          .gravity = calibration.gravity_target,
                          .imu = calibration.imu,
                          .shape = calibration.shape,
                          .states = std::move(half.states)},
                         weights, true, iterations);
  result.covariance = inertial_covariance(problem, calibration.layout, result.rig);
  return result;
}

Eigen::VectorXd rig_differences(const InertialRig& a, const InertialRig& b,
                                const InertialLayout& layout) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(layout.rows());
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const Camera &from = a.cameras[c], &to = b.cameras[c];
    result.segment(layout.lens_row(c), layout.lens(c).parameters()) =
        lens_parameters(to) - lens_parameters(from);
    result.segment<3>(layout.pose_row(c)) = so3::log(to.cam_T_imu.R * from.cam_T_imu.R.transpose());
    result.segment<3>(layout.pose_row(c) + 3) = to.cam_T_imu.p - from.cam_T_imu.p;
    result[layout.offset_row(c)] = b.offsets[c] - a.offsets[c];
    if (!layout.has_readout()) continue;
    result[layout.readout_row(c)] = to.shutter.readout - from.shutter.readout;
  }
  for (std::size_t r = 0; r < a.gravity.size(); ++r) {
    const Eigen::Vector3d turn = so3::log(so3::between(a.gravity[r], b.gravity[r]));
    result.segment<2>(layout.gravity_row(r)) = across(a.gravity[r]).transpose() * turn;
  }
  if (a.imu.size() > 0) {
    result.segment(layout.imu_row(), a.imu.size()) = b.imu.parameters() - a.imu.parameters();
  }
  result.tail(layout.shape_rows()) = b.shape - a.shape;
  return result;
}

}  // namespace

InertialHalves compare_halves(const InertialCalibrationInput& input,
                              const InertialCalibration& calibration) {
  const InertialLayout& layout = calibration.layout;
  const std::vector<int> halves = halves_of_instants(input, calibration);
  const HalfRig a = calibrated_half(input, calibration, half_of(input, calibration, halves, 0));
  const HalfRig b = calibrated_half(input, calibration, half_of(input, calibration, halves, 1));
  InertialHalves result{.difference = rig_differences(a.rig, b.rig, layout),
                        .sigma = (a.covariance + b.covariance).diagonal().cwiseSqrt(),
                        .pixels = {},
                        .pixels_sigma = {}};
  const Eigen::MatrixXd covariance = a.covariance + b.covariance;
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const int row = layout.lens_row(c), n = layout.lens(c).parameters();
    result.pixels.push_back(rms_of(projection_difference(a.rig.cameras[c], b.rig.cameras[c])));
    result.pixels_sigma.push_back(
        rms_of(projection_uncertainty(calibration.cameras[c], covariance.block(row, row, n, n))));
  }
  return result;
}

}  // namespace chasles
