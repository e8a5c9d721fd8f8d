#include "slam_input.hpp"

#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/session/inertial_settings_io.hpp>

#include "interpreter_exit.hpp"
#include "messages.hpp"

namespace chasles::python {
namespace {

// One sample's (3,) is a column for Eigen.
Rows as_rows(const Rows& rows) {
  return rows.cols() == 1 && rows.rows() == 3 ? Rows(rows.transpose()) : rows;
}

// Warns, the first time.
void once(bool& warned, std::size_t count, const std::string& what) {
  if (warned || count == 0) return;
  warned = true;
  constexpr int kOfTheCaller = 2;  // _one_line.py is between
  const std::string text = what + "; `counts` has their number, and this is said once";
  if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), kOfTheCaller) < 0)
    throw py::error_already_set();
}

}  // namespace

std::vector<Camera> cameras_of(const std::string& name, const py::object& cameras) {
  if (py::isinstance<Camera>(cameras)) return {cameras.cast<Camera>()};
  return as<std::vector<Camera>>(cameras, name + ": cameras: found", "a Camera, or a list of them");
}

std::unique_ptr<VisualInertialSlam> make_slam(const char* name, const py::object& cameras,
                                              const ImuNoise* noise, const std::string& estimator,
                                              const std::optional<std::filesystem::path>& map,
                                              const py::kwargs& arguments) {
  const std::vector<Camera> rig = cameras_of(name, cameras);
  const bool realtime = std::string_view(name) == "RealtimeSlam";
  if (!realtime && arguments.contains("most_images")) {
    throw UsageError("Slam: most_images is an argument of RealtimeSlam: Slam drops no images");
  }
  std::vector<std::string> own{"estimator", "map"};
  if (realtime) own.emplace_back("most_images");
  check_keys(name, arguments, own);
  if (noise == nullptr) {
    throw UsageError(fmt::format(
        "{}: found None as the noise of the IMU, which the recording does not state; expected "
        "chasles.ImuNoise(...)",
        name));
  }
  SettingSources sources;
  sources.sets = assignments(arguments);
  sources.set_option = "setting";
  sources.estimator = estimator_choice(estimator);
  const Released released;
  InertialRunSettings settings = inertial_run_settings_from(sources);
  std::shared_ptr<const LandmarkMap> prior;
  if (map && !map->empty()) {
    settings.filter.recognise = Recognise::kAppearance;
    prior = std::make_shared<const LandmarkMap>(read_map(*map));
  }
  return std::make_unique<VisualInertialSlam>(rig, *noise, settings, ImuBuffer::Options{},
                                              std::vector<GrayImage>{}, std::move(prior));
}

std::vector<ImuSample> samples_of(const py::object& time, const Rows& rate, const Rows& force) {
  const bool many = py::isinstance<py::array>(time) && time.cast<py::array>().ndim() > 0;
  const std::vector<Time> times =
      many ? times_of(time.cast<py::array>()) : std::vector{time_of(time)};
  const Rows rates = as_rows(rate), forces = as_rows(force);
  const auto n = static_cast<Eigen::Index>(times.size());
  if (rates.rows() != n || forces.rows() != n || rates.cols() != 3 || forces.cols() != 3) {
    throw py::value_error(fmt::format(
        "add_imu: found {} times, angular rates {} x {} and specific forces {} x {}; expected a "
        "time with (3,) and (3,), or (N,) with (N, 3) and (N, 3)",
        n, rates.rows(), rates.cols(), forces.rows(), forces.cols()));
  }
  std::vector<ImuSample> samples(times.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    ImuSample& sample = samples[static_cast<std::size_t>(i)];
    sample.time = times[static_cast<std::size_t>(i)];
    sample.specific_force_imu = forces.row(i);
    sample.angular_rate_imu = rates.row(i);
  }
  return samples;
}

ImageFrame frame_of(const py::object& time, const py::object& images) {
  ImageFrame frame{.time = time_of(time), .images = {}};
  const bool array = py::isinstance<py::array>(images);
  const bool one = is_pillow_image(images) ||
                   (array && images.cast<py::array>().ndim() != 3);  // (cameras, height, width)
  if (one || !py::isinstance<py::sequence>(images)) {
    frame.images.push_back(image_of(images, "add_images"));
    return frame;
  }
  for (const py::handle& image : images) {
    const std::string where = fmt::format("add_images: camera {}", frame.images.size());
    frame.images.push_back(image_of(image, where));
  }
  return frame;
}

void add_counts(const ArrivalCounts& counts, py::dict& dict) {
  dict["samples"] = counts.samples;
  dict["samples_not_finite"] = counts.samples_not_finite;
  dict["samples_late"] = counts.samples_late;
  dict["samples_dropped"] = counts.samples_dropped;
  dict["images"] = counts.images;
  dict["images_late"] = counts.images_late;
  dict["images_uncovered"] = counts.images_uncovered;
}

void ArrivalWarnings::warn(const ArrivalCounts& counts) {
  once(not_finite_, counts.samples_not_finite,
       "a sample of the IMU is not finite (NaN or infinite) and is ignored");
  once(late_samples_, counts.samples_late,
       "a sample of the IMU is not later than one that was used before, or repeats its time, and "
       "is ignored");
  once(dropped_, counts.samples_dropped,
       fmt::format("more than {} samples wait for images, and the oldest are dropped; add images "
                   "as they come",
                   ArrivalOrder::kMostSamples));
  once(late_images_, counts.images_late,
       "images are not later than those that were used before, or repeat their time, and are "
       "ignored");
  once(uncovered_, counts.images_uncovered,
       fmt::format("an image has no sample of the IMU at its time or after it, though {} images "
                   "came after it or nothing more comes; add the samples first, or as they come, "
                   "and check that both have the same clock",
                   ArrivalOrder::kMostFrames));
}

}  // namespace chasles::python
