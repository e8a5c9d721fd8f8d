#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/inertial_report.hpp>
#include <chasles/calibrate/target_pose.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/session/motion_calibration.hpp>

#include "arrays.hpp"
#include "long_call.hpp"
#include "module.hpp"

namespace chasles::python {
namespace {

// Views in the form that python/chasles/_calibrate.py has checked.
struct GivenViews {
  std::string of;  // the function
  py::list times;
  std::vector<int> cameras;
  std::vector<std::vector<int>> ids;  // rising
  std::vector<Rows> pixels;
};

std::vector<TargetView> views_of(const GivenViews& given) {
  std::vector<TargetView> views;
  for (std::size_t i = 0; i < given.cameras.size(); ++i) {
    TargetView view{
        .time = time_of(given.times[i], fmt::format("{}: views[{}]: time", given.of, i)),
        .camera = given.cameras[i],
        .ids = given.ids[i],
        .pixels = {}};
    for (const auto& pixel : given.pixels[i].rowwise()) view.pixels.emplace_back(pixel.transpose());
    views.push_back(std::move(view));
  }
  return views;
}

// Whether most views show that side.
bool is_seen_from_behind(const CamerasInput& input) {
  int behind = 0;
  for (const TargetView& view : input.views) {
    behind += chasles::is_seen_from_behind(input.corners, view) ? 1 : -1;
  }
  return behind > 0;
}

// Half a turn of the frame of the target about its x axis.
void turn_target(CamerasInput& input) {
  const Eigen::DiagonalMatrix<double, 3> half_turn(1, -1, -1);
  for (Eigen::Vector3d& corner : input.corners) corner = half_turn * corner;
  for (auto& derivative : input.shape.by_parameters) derivative = half_turn * derivative;
}

void turn_back(std::vector<ExplainedView>& views) {
  for (ExplainedView& view : views) {
    view.cam_T_target.R = view.cam_T_target.R * Eigen::DiagonalMatrix<double, 3>(1, -1, -1);
  }
}

py::dict view_columns(const std::vector<ExplainedView>& views) {
  const auto n = static_cast<Eigen::Index>(views.size());
  Times times(n), cameras(n);
  Eigen::VectorXd rms(n);
  Rows poses(n, 16);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ExplainedView& view = views[static_cast<std::size_t>(i)];
    times[i] = view.view.time.count();
    cameras[i] = view.view.camera;
    rms[i] = view.rms;
    poses.row(i) = matrix(view.cam_T_target).reshaped<Eigen::RowMajor>().transpose();
  }
  py::dict result;
  result["time"] = std::move(times);
  result["camera"] = std::move(cameras);
  result["rms"] = std::move(rms);
  result["cam_T_target"] = cubes(std::move(poses), 4);
  return result;
}

py::dict error_columns(const std::vector<ExplainedView>& views) {
  std::size_t corners = 0;
  for (const ExplainedView& view : views) corners += view.errors.size();
  const auto n = static_cast<Eigen::Index>(corners);
  Times of(n), ids(n);
  Rows pixels(n, 2), errors(n, 2);
  Eigen::Index row = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < views[v].errors.size(); ++i, ++row) {
      of[row] = static_cast<std::int64_t>(v);
      ids[row] = views[v].view.ids[i];
      pixels.row(row) = views[v].view.pixels[i];
      errors.row(row) = views[v].errors[i];
    }
  }
  py::dict result;
  result["view"] = std::move(of);
  result["id"] = std::move(ids);
  result["pixel"] = std::move(pixels);
  result["error"] = std::move(errors);
  return result;
}

// The views, with the target turned so that cameras see the side of its z axis, and the lenses to
// try. `lenses`: of each camera. `start`: of each camera with the lens to begin at, or none.
struct GivenCameras {
  CamerasInput input;
  std::vector<std::vector<LensForm>> candidates;
  bool is_turned = false;
};

GivenCameras given_cameras(const Rows& corners, GivenViews views,
                           const std::vector<std::pair<int, int>>& sizes,
                           const std::vector<std::string>& lenses, const std::vector<Camera>& start,
                           bool bend) {
  GivenCameras given;
  CamerasInput& input = given.input;
  for (const auto& corner : corners.rowwise()) input.corners.emplace_back(corner.transpose());
  input.views = views_of(views);
  for (std::size_t c = 0; c < sizes.size(); ++c) {
    input.cameras.push_back(
        start.empty() ? Camera{.width = sizes[c].first, .height = sizes[c].second, .cam_T_imu = {}}
                      : start[c]);
    given.candidates.push_back(lens_candidates(lenses[c], "lenses"));
  }
  if (bend) input.shape = bent_shape(input.corners);
  given.is_turned = is_seen_from_behind(input);
  if (given.is_turned) turn_target(input);
  return given;
}

py::tuple calibrate(const Rows& corners, const py::list& times, std::vector<int> cameras,
                    std::vector<std::vector<int>> ids, std::vector<Rows> pixels,
                    const std::vector<std::pair<int, int>>& sizes,
                    const std::vector<std::string>& lenses, const std::vector<Camera>& start,
                    bool bend) {
  const GivenCameras given = given_cameras(
      corners, {"calibrate_cameras", times, std::move(cameras), std::move(ids), std::move(pixels)},
      sizes, lenses, start, bend);
  CamerasReport report;
  report.input = given.input;
  LongCall().in_turn([&] { calibrate_with_report(report, given.candidates, false); });
  CamerasCalibration& found = report.calibration;
  if (given.is_turned) turn_back(found.views);
  return py::make_tuple(json_text(cameras_json(report)), found.cameras, view_columns(found.views),
                        error_columns(found.views));
}

// The frame of the target as it was given.
void turn_back(InertialCalibration& found) {
  turn_back(found.views);
  const Eigen::DiagonalMatrix<double, 3> half_turn(1, -1, -1);
  for (std::size_t r = 0; r < found.gravity_target.size(); ++r) {
    Eigen::Vector3d& gravity = found.gravity_target[r];
    const Eigen::Vector3d axis = half_turn * gravity.unitOrthogonal();
    gravity = half_turn * gravity;
    // Its axes are the turned ones, or their opposites.
    if (axis.dot(gravity.unitOrthogonal()) > 0) continue;
    const int row = found.layout.gravity_row(r);
    found.covariance.middleRows<2>(row) *= -1;
    found.covariance.middleCols<2>(row) *= -1;
  }
}

py::tuple calibrate_imu(const Rows& corners, const py::list& times, std::vector<int> cameras,
                        std::vector<std::vector<int>> ids, std::vector<Rows> pixels,
                        const std::vector<std::pair<int, int>>& sizes,
                        const std::vector<std::string>& lenses, const std::vector<Camera>& start,
                        bool bend, const Recording& imu, const ImuNoise& noise, double gravity,
                        bool rolling, bool exact_imu) {
  GivenCameras given = given_cameras(
      corners,
      {"calibrate_imu_cameras", times, std::move(cameras), std::move(ids), std::move(pixels)},
      sizes, lenses, start, bend);
  InertialReport report;
  report.input = {.cameras = std::move(given.input),
                  .imu = imu.imu,
                  .noise = noise,
                  .gravity = gravity,
                  .has_readout = rolling,
                  .has_imu_errors = !exact_imu};
  for (const Camera& camera : start) report.input.has_readout |= camera.shutter.is_rolling();
  LongCall().in_turn([&] { calibrate_with_report(report, given.candidates, false); });
  InertialCalibration& found = report.calibration;
  if (given.is_turned) turn_back(found);
  return py::make_tuple(json_text(inertial_json(report)), found.cameras, view_columns(found.views),
                        error_columns(found.views), found.imu.force, found.imu.rate);
}

py::tuple from_motion(Recording recording, bool from_nothing) {
  SessionOptions options;
  options.quiet = true;
  LongCall call;
  const MotionCalibration found = call.in_turn([&] {
    return calibrate_from_motion(options, recording, from_nothing, [&] { return call.stopped(); });
  });
  return py::make_tuple(json_text(motion_json(found)), found.cameras, found.time_offset,
                        motion_text(found));
}

}  // namespace

void bind_calibrations(py::module_& m) {
  m.def("calibrate_cameras", &calibrate, py::arg("corners"), py::arg("times"), py::arg("cameras"),
        py::arg("ids"), py::arg("pixels"), py::arg("sizes"), py::arg("lenses"), py::arg("start"),
        py::arg("bend"));
  m.def("calibrate_imu_cameras", &calibrate_imu, py::arg("corners"), py::arg("times"),
        py::arg("cameras"), py::arg("ids"), py::arg("pixels"), py::arg("sizes"), py::arg("lenses"),
        py::arg("start"), py::arg("bend"), py::arg("imu"), py::arg("noise"), py::arg("gravity"),
        py::arg("rolling"), py::arg("exact_imu"));
  m.def("calibrate_from_motion", &from_motion, py::arg("recording"), py::arg("from_nothing"));
}

}  // namespace chasles::python
