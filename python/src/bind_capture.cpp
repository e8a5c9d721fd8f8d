#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/capture_guide.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/target_pose.hpp>
#include <chasles/target/target_detector.hpp>
#include <chasles/target/target_file.hpp>

#include "arrays.hpp"
#include "long_call.hpp"
#include "module.hpp"

namespace chasles::python {
namespace {

Rows rows_of_corners(const Target& target) {
  const std::vector<Eigen::Vector3d> corners = target.corners();
  Rows rows(std::ssize(corners), 3);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = corners[i];
  }
  return rows;
}

py::tuple find(const TargetDetector& detector, const py::object& image) {
  const GrayImage grey = image_of(image);
  const TargetView view = LongCall()([&] { return detector.detect(grey).view; });
  Times ids(std::ssize(view.ids));
  Rows pixels(std::ssize(view.ids), 2);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    ids[static_cast<Eigen::Index>(i)] = view.ids[i];
    pixels.row(static_cast<Eigen::Index>(i)) = view.pixels[i];
  }
  return py::make_tuple(std::move(ids), std::move(pixels));
}

// An array of numpy of any shape as whole numbers.
std::vector<std::int64_t> whole_numbers(const py::object& object, const std::string& what) {
  const py::array array = py::array::ensure(object);
  const bool is_whole = array && (array.dtype().kind() == 'i' || array.dtype().kind() == 'u');
  if (!is_whole && (!array || array.size() > 0)) {
    throw InputError(
        fmt::format("{}: found {}, expected whole numbers", what, description(object)));
  }
  return as<std::vector<std::int64_t>>(array.attr("ravel")().attr("tolist")(), what + ": found",
                                       "whole numbers");
}

// Corners with rising ids, as detectors give them: (K,) or (K, 1) and (K, 2) or (K, 1, 2).
TargetView view_of(Time time, int camera, const py::object& ids, const py::object& pixels) {
  constexpr const char* kWhat = "CaptureGuide.add: pixels: found";
  const std::vector<std::int64_t> numbers = whole_numbers(ids, "CaptureGuide.add: ids");
  const auto array = py::array_t<double, py::array::forcecast>::ensure(pixels);
  if (!array || array.size() != 2 * std::ssize(numbers)) {
    PyErr_Clear();
    throw InputError(fmt::format("{} {}, expected ({}, 2), a row for each id", kWhat,
                                 description(pixels), numbers.size()));
  }
  const auto rows = as<Rows>(array.attr("reshape")(-1, 2), kWhat, "(K, 2)");
  std::map<std::int64_t, Eigen::Vector2d> by_id;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const bool is_new =
        by_id.emplace(numbers[i], rows.row(static_cast<Eigen::Index>(i)).transpose()).second;
    if (!is_new) {
      throw InputError(
          fmt::format("CaptureGuide.add: found the id {} twice, expected each corner "
                      "once",
                      numbers[i]));
    }
  }
  TargetView view{.time = time, .camera = camera, .ids = {}, .pixels = {}};
  for (const auto& [id, pixel] : by_id) {
    view.ids.push_back(static_cast<int>(std::clamp<std::int64_t>(id, -1, 1'000'000'000)));
    view.pixels.push_back(pixel);
  }
  return view;
}

std::vector<Eigen::Vector3d> corners_of(const py::object& target) {
  if (py::isinstance<TargetDetector>(target)) {
    return target.cast<const TargetDetector&>().target().corners();
  }
  constexpr const char* kExpected = "a Target or its corners (N, 3)";
  const auto rows = as<Rows>(target, "CaptureGuide: target: found", kExpected);
  if (rows.cols() != 3 || !rows.allFinite()) {
    throw InputError(fmt::format("CaptureGuide: target: found {}, expected {}, finite numbers",
                                 description(target), kExpected));
  }
  std::vector<Eigen::Vector3d> corners;
  for (const auto& row : rows.rowwise()) corners.emplace_back(row.transpose());
  return corners;
}

CamerasInput guided_input(const py::object& target, const std::vector<std::pair<int, int>>& sizes,
                          const std::string& lenses) {
  CamerasInput input{
      .corners = corners_of(target), .views = {}, .cameras = {}, .lenses = {}, .shape = {}};
  const std::vector<LensForm> candidates = lens_candidates(lenses, "CaptureGuide: lenses");
  for (const auto& [width, height] : sizes) {
    if (width < 1 || height < 1) {
      throw InputError(
          fmt::format("CaptureGuide: sizes: found {} x {}, expected (width, height) of each camera",
                      width, height));
    }
    input.cameras.push_back({.width = width, .height = height, .cam_T_imu = {}});
    input.lenses.push_back(guiding_lens(input.cameras.back(), candidates));
  }
  return input;
}

// Several threads of Python may use it, and the GIL is free while a lens is estimated.
class SharedGuide {
 public:
  explicit SharedGuide(CamerasInput input) : guide_(std::move(input)) {}

  void add(const py::object& time, int camera, const py::object& ids, const py::object& pixels) {
    const TargetView view = view_of(time_of(time, "CaptureGuide.add: time"), camera, ids, pixels);
    LongCall().in_turn([&] {
      const std::lock_guard lock(mutex_);
      check_view(guide_.input(), view, "CaptureGuide.add");
      if (guide_.input().views.empty() && is_seen_from_behind(guide_.input().corners, view)) {
        guide_ = turned();
      }
      guide_.add(view);
    });
  }

  std::vector<std::string> missing() const {
    const std::lock_guard lock(mutex_);
    return guide_.missing();
  }

  std::vector<std::optional<std::pair<double, double>>> focal_lengths() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::optional<std::pair<double, double>>> lengths;
    for (std::size_t c = 0; c < guide_.input().cameras.size(); ++c) {
      const auto& estimate = guide_.estimate(c);
      lengths.push_back(estimate ? std::optional(std::pair(estimate->focal_length, estimate->sigma))
                                 : std::nullopt);
    }
    return lengths;
  }

 private:
  // Of a target whose z axis points away from the cameras.
  CaptureGuide turned() const {
    CamerasInput input = guide_.input();
    for (Eigen::Vector3d& corner : input.corners) corner.tail<2>() *= -1;
    return CaptureGuide(std::move(input));
  }

  mutable std::mutex mutex_;
  CaptureGuide guide_;
};

}  // namespace

void bind_capture(py::module_& m) {
  py::class_<TargetDetector>(m, "Target",
                             "A calibration target of a file (docs/calibration.md), and its "
                             "corners in images.")
      .def(py::init([](const std::filesystem::path& path) {
             return std::make_unique<TargetDetector>(read_target(path));
           }),
           py::arg("path"))
      .def_property_readonly(
          "corners", [](const TargetDetector& self) { return rows_of_corners(self.target()); },
          "(N, 3): the corners in the frame of the target [m]; the row is a corner's id.")
      .def("find", &find, py::arg("image"),
           "The ids (K,) of the corners that an image shows and their pixels (K, 2); the centre of "
           "the first pixel is (0, 0). An image is grey, (height, width) of uint8, or one of "
           "Pillow.");
  py::class_<SharedGuide>(
      m, "CaptureGuide",
      "Says, while views of a target are recorded by any program, which views a calibration would "
      "lack. target: a Target, or its corners (N, 3) as for calibrate_cameras [m]. sizes: (width, "
      "height) of the images of each camera. lenses: as for "
      "calibrate_cameras; a single one is that by which the cameras are estimated.")
      .def(py::init([](const py::object& target, const std::vector<std::pair<int, int>>& sizes,
                       const std::string& lenses) {
             return std::make_unique<SharedGuide>(guided_input(target, sizes, lenses));
           }),
           py::arg("target"), py::arg("sizes"), py::arg("lenses") = "auto")
      .def("add", &SharedGuide::add, py::arg("time"), py::arg("camera"), py::arg("ids"),
           py::arg("pixels"),
           "A view, as one of calibrate_cameras: time an int [ns] or a float [s], one for all "
           "cameras that see the target at an instant; ids (K,), pixels (K, 2). Fewer than four "
           "corners show nothing. Raises InputError for a view that cannot be used.")
      .def_property_readonly("missing", &SharedGuide::missing,
                             "What is missing, one sentence each, the most important first; empty: "
                             "it is enough.")
      .def_property_readonly("focal_lengths", &SharedGuide::focal_lengths,
                             "Of each camera fx and its standard deviation [px], by its views till "
                             "now; None where they do not determine it yet.");
}

}  // namespace chasles::python
