#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/session/recording_input.hpp>

#include "arrays.hpp"
#include "forks.hpp"
#include "interpreter_exit.hpp"
#include "long_call.hpp"
#include "messages.hpp"
#include "module.hpp"
#include "recordings.hpp"

namespace chasles::python {
namespace {

using Eigen::Index;

// Images for several threads of Python: a run reads ahead while another thread looks at them.
class SharedImages : public ImageSource {
 public:
  explicit SharedImages(std::shared_ptr<const ImageSource> images) : images_(std::move(images)) {}

  std::size_t size() const override { return images_->size(); }
  Time time(std::size_t i) const override { return images_->time(i); }
  bool has_image(std::size_t i, std::size_t camera) const override {
    return images_->has_image(i, camera);
  }
  ImageFrame read(std::size_t i) const override {
    return locked([&] { return images_->read(i); });
  }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    return locked([&] { return images_->read_cameras(i, cameras); });
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    return locked([&] { return images_->read_undamaged(i, cameras, damaged); });
  }

 private:
  template <typename Read>
  ImageFrame locked(const Read& read) const {
    reject_after_fork();
    const UnfitForForks unfit;
    const std::scoped_lock lock(mutex_);
    return read();
  }

  std::shared_ptr<const ImageSource> images_;
  mutable std::mutex mutex_;
};

Recording read(const std::filesystem::path& path, std::optional<double> start,
               std::optional<double> stop, bool backwards, const std::string& cameras,
               const std::string& truth, const std::string& truth_level, const std::string& pairing,
               std::optional<double> max_truth_gap, const std::string& truth_time_offset,
               const std::string& truth_frame, std::optional<double> truth_scale,
               bool truth_inverse) {
  RecordingInput input;
  input.recording = path;
  input.start = start;
  input.stop = stop;
  input.backwards = backwards;
  input.cameras = cameras;
  input.truth = truth;
  if (max_truth_gap && !(std::isfinite(*max_truth_gap) && *max_truth_gap > 0)) {
    throw UsageError(fmt::format(
        "max_truth_gap: found {}, expected a finite number of seconds above 0", *max_truth_gap));
  }
  constexpr double kLeastScale = 1e-9, kMostScale = 1e9;
  if (truth_scale && !(*truth_scale >= kLeastScale && *truth_scale <= kMostScale)) {
    throw UsageError(fmt::format("truth_scale: found {}, expected a number from {:g} to {:g}",
                                 *truth_scale, kLeastScale, kMostScale));
  }
  input.truth_options = {.pairing = pairing,
                         .max_gap = max_truth_gap,
                         .level = truth_level,
                         .time_offset = truth_time_offset,
                         .frame = truth_frame,
                         .scale = truth_scale,
                         .inverse = truth_inverse,
                         .errors = {}};
  return LongCall()([&] { return shared(read_input(input)); });
}

Times frame_times(const Recording& recording) {
  const std::size_t n = frame_count(recording);
  Times times(static_cast<Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    times[static_cast<Index>(i)] = frame_time(recording, i).count();
  }
  return times;
}

std::size_t checked(py::ssize_t index, std::size_t size, const char* what) {
  const auto n = static_cast<py::ssize_t>(size);
  const py::ssize_t i = index < 0 ? index + n : index;
  if (i < 0 || i >= n) {
    throw py::index_error(fmt::format("{} {}: the recording has {}", what, index, size));
  }
  return static_cast<std::size_t>(i);
}

py::list images(const Recording& recording, py::ssize_t index) {
  const std::size_t i =
      checked(index, recording.images ? recording.images->size() : 0, "images of frame");
  ImageFrame frame;
  {
    const Released released;
    frame = recording.images->read(i);
  }
  py::list result;
  for (GrayImage& image : frame.images) {
    result.append(image.empty() ? py::none() : py::object(array_of(std::move(image))));
  }
  return result;
}

py::dict tracks(const Recording& recording, py::ssize_t index) {
  const FeatureFrame& frame =
      recording.frames[checked(index, recording.frames.size(), "tracks of frame")];
  const bool stereo = !frame.observations.empty();
  const auto n = static_cast<Index>(stereo ? frame.observations.size() : frame.pixels.size());
  Times landmarks(n), cameras(n);
  Rows pixels(n, stereo ? 4 : 2);
  for (Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    landmarks[i] = stereo ? frame.observations[at].landmark : frame.pixels[at].landmark;
    cameras[i] = stereo ? 0 : frame.pixels[at].camera;
    if (stereo) {
      pixels.row(i) = frame.observations[at].pixels;
    } else {
      pixels.row(i) = frame.pixels[at].pixel;
    }
  }
  py::dict result;
  result["landmark"] = std::move(landmarks);
  result["camera"] = std::move(cameras);
  result["pixel"] = std::move(pixels);
  return result;
}

Camera make_camera(int width, int height, double fx, double fy, double cx, double cy,
                   const std::string& distortion, const std::vector<double>& coefficients,
                   const Eigen::Matrix4d& cam_T_imu, double readout_time,
                   const std::string& readout_direction) {
  const auto model = choice_of<Distortion>(distortion);
  if (!model) {
    throw py::value_error(fmt::format("Camera: distortion: found '{}', expected one of {}",
                                      distortion, fmt::join(kChoiceNames<Distortion>, ", ")));
  }
  const std::string fault = coefficients_fault(*model, coefficients);
  const auto check = [](const char* name, double value, const char* expected, bool good) {
    if (good) return;
    throw py::value_error(
        fmt::format("Camera: {}: found {:g}, expected {}", name, value, expected));
  };
  constexpr const char* kSize = "a number of pixels above 0";
  check("width", width, kSize, width > 0);
  check("height", height, kSize, height > 0);
  constexpr const char* kFocalLength = "a finite number of pixels above 0";
  check("fx", fx, kFocalLength, std::isfinite(fx) && fx > 0);
  check("fy", fy, kFocalLength, std::isfinite(fy) && fy > 0);
  check("cx", cx, "a finite number of pixels", std::isfinite(cx));
  check("cy", cy, "a finite number of pixels", std::isfinite(cy));
  const auto direction = choice_of<ReadoutDirection>(readout_direction);
  if (!direction) {
    throw py::value_error(fmt::format("Camera: readout_direction: found '{}', expected one of {}",
                                      readout_direction,
                                      fmt::join(kChoiceNames<ReadoutDirection>, ", ")));
  }
  check("readout_time", readout_time, fmt::format("seconds from 0 to {}", kLongestReadout).c_str(),
        readout_time >= 0 && readout_time <= kLongestReadout);
  for (const double k : coefficients) {
    check("coefficients", k, "finite numbers", std::isfinite(k));
  }
  if (!fault.empty()) throw py::value_error("Camera: coefficients: " + fault);
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = cx;
  camera.cy = cy;
  camera.distortion = *model;
  camera.coefficients = LensCoefficients(without_padding(*model, coefficients));
  camera.cam_T_imu = pose_of(cam_T_imu, "Camera: cam_T_imu");
  camera.shutter = {.readout = readout_time, .direction = *direction};
  return camera;
}

ImuNoise make_noise(double accelerometer, double gyroscope, double accelerometer_walk,
                    double gyroscope_walk) {
  const auto checked = [](const char* name, double value) {
    if (std::isfinite(value) && value >= 0) return value;
    throw py::value_error(
        fmt::format("ImuNoise: {}: found {:g}, expected a finite number not below 0", name, value));
  };
  ImuNoise noise;
  noise.accelerometer_noise_density = checked("accelerometer_noise_density", accelerometer);
  noise.accelerometer_random_walk = checked("accelerometer_random_walk", accelerometer_walk);
  noise.gyroscope_noise_density = checked("gyroscope_noise_density", gyroscope);
  noise.gyroscope_random_walk = checked("gyroscope_random_walk", gyroscope_walk);
  return noise;
}

// For pickle and copy.
py::tuple state_of(const Camera& c) {
  return py::make_tuple(c.width, c.height, c.fx, c.fy, c.cx, c.cy, static_cast<int>(c.distortion),
                        std::vector<double>(c.coefficients.begin(), c.coefficients.end()),
                        Eigen::Matrix3d(c.cam_T_imu.R), Eigen::Vector3d(c.cam_T_imu.p),
                        c.shutter.readout, static_cast<int>(c.shutter.direction));
}

Camera camera_of(const py::tuple& state) {
  Camera c{.width = state[0].cast<int>(),
           .height = state[1].cast<int>(),
           .fx = state[2].cast<double>(),
           .fy = state[3].cast<double>(),
           .cx = state[4].cast<double>(),
           .cy = state[5].cast<double>(),
           .distortion = static_cast<Distortion>(state[6].cast<int>()),
           .coefficients = LensCoefficients(state[7].cast<std::vector<double>>()),
           .cam_T_imu = {}};
  c.cam_T_imu = {.R = state[8].cast<Eigen::Matrix3d>(), .p = state[9].cast<Eigen::Vector3d>()};
  c.shutter = {.readout = state[10].cast<double>(),
               .direction = static_cast<ReadoutDirection>(state[11].cast<int>())};
  return c;
}

py::tuple state_of_noise(const ImuNoise& n) {
  return py::make_tuple(n.accelerometer_noise_density, n.accelerometer_random_walk,
                        n.gyroscope_noise_density, n.gyroscope_random_walk, n.exact);
}

ImuNoise noise_of_state(const py::tuple& state) {
  return {.accelerometer_noise_density = state[0].cast<double>(),
          .accelerometer_random_walk = state[1].cast<double>(),
          .gyroscope_noise_density = state[2].cast<double>(),
          .gyroscope_random_walk = state[3].cast<double>(),
          .exact = state[4].cast<bool>()};
}

std::string camera_text(const Camera& c) {
  return fmt::format("<chasles.Camera {} x {} px, fx {:.1f}, fy {:.1f}, cx {:.1f}, cy {:.1f}, {}>",
                     c.width, c.height, c.fx, c.fy, c.cx, c.cy, name_of(c.distortion));
}

std::string noise_text(const ImuNoise& n) {
  return fmt::format(
      "<chasles.ImuNoise accelerometer {:g} m/s^2/sqrt(Hz), walk {:g}; gyroscope {:g} "
      "rad/s/sqrt(Hz), walk {:g}>",
      n.accelerometer_noise_density, n.accelerometer_random_walk, n.gyroscope_noise_density,
      n.gyroscope_random_walk);
}

std::string text_of(const Recording& recording) {
  return fmt::format("<chasles.Recording '{}': {} frames{}, {} IMU samples, {} velocities, {}>",
                     recording.name, frame_count(recording), recording.images ? " of images" : "",
                     recording.imu.size(), recording.velocities.size(),
                     recording.truth.empty() ? "no truth" : "with truth");
}

}  // namespace

Recording shared(Recording recording) {
  if (recording.images) {
    recording.images = std::make_shared<const SharedImages>(std::move(recording.images));
  }
  return recording;
}

void bind_recordings(py::module_& m) {
  py::class_<Camera>(m, "Camera", "A camera of a rig: z forward, x right, y down.")
      .def(py::init(&make_camera), py::arg("width"), py::arg("height"), py::arg("fx"),
           py::arg("fy"), py::arg("cx"), py::arg("cy"), py::arg("distortion") = "none",
           py::arg("coefficients") = std::vector<double>{},
           py::arg("cam_T_imu") = Eigen::Matrix4d(Eigen::Matrix4d::Identity()),
           py::arg("readout_time") = 0.0, py::arg("readout_direction") = "down",
           ("Intrinsics in pixels; distortion with coefficients: " + lens_model_coefficients() +
            ". cam_T_imu (4, 4) maps IMU coordinates to the camera's [m]. readout_time: of a "
            "rolling shutter [s], whose image has the time of its first line; readout_direction: "
            "down, up, right or left.")
               .c_str())
      .def_readonly("width", &Camera::width, "[px]")
      .def_readonly("height", &Camera::height, "[px]")
      .def_readonly("fx", &Camera::fx, "Focal length [px].")
      .def_readonly("fy", &Camera::fy, "Focal length [px].")
      .def_readonly("cx", &Camera::cx, "Principal point [px].")
      .def_readonly("cy", &Camera::cy, "Principal point [px].")
      .def_property_readonly(
          "distortion", [](const Camera& c) { return std::string(name_of(c.distortion)); },
          "The name of the lens model.")
      .def_property_readonly(
          "coefficients",
          [](const Camera& c) {
            return std::vector<double>(c.coefficients.begin(), c.coefficients.end());
          },
          "Of the lens model, in its order.")
      .def_property_readonly(
          "cam_T_imu", [](const Camera& c) { return matrix(c.cam_T_imu); },
          "(4, 4): maps IMU coordinates to the camera's [m].")
      .def_property_readonly(
          "readout_time", [](const Camera& c) { return c.shutter.readout; },
          "Of a rolling shutter [s]; 0: a global one.")
      .def_property_readonly(
          "readout_direction",
          [](const Camera& c) { return std::string(name_of(c.shutter.direction)); },
          "down, up, right or left.")
      .def(py::pickle(&state_of, &camera_of))
      .def("__repr__", &camera_text);

  py::class_<ImuNoise>(m, "ImuNoise", "Noise densities of an IMU, as Allan variances give them.")
      .def(py::init(&make_noise), py::kw_only(), py::arg("accelerometer_noise_density"),
           py::arg("gyroscope_noise_density"), py::arg("accelerometer_random_walk"),
           py::arg("gyroscope_random_walk"),
           "Noise densities [m/s^2/sqrt(Hz), rad/s/sqrt(Hz)] and random walks of the biases "
           "[m/s^3/sqrt(Hz), rad/s^2/sqrt(Hz)].")
      .def_readonly("accelerometer_noise_density", &ImuNoise::accelerometer_noise_density,
                    "[m/s^2/sqrt(Hz)]")
      .def_readonly("gyroscope_noise_density", &ImuNoise::gyroscope_noise_density,
                    "[rad/s/sqrt(Hz)]")
      .def_readonly("accelerometer_random_walk", &ImuNoise::accelerometer_random_walk,
                    "Of the bias [m/s^3/sqrt(Hz)].")
      .def_readonly("gyroscope_random_walk", &ImuNoise::gyroscope_random_walk,
                    "Of the bias [rad/s^2/sqrt(Hz)].")
      .def(py::pickle(&state_of_noise, &noise_of_state))
      .def("__repr__", &noise_text);

  py::class_<Recording, std::shared_ptr<Recording>>(
      m, "Recording", "The measurements of a recording and, where known, the truth.")
      .def_readonly("name", &Recording::name, "Of the recording.")
      .def_property_readonly(
          "remarks",
          [](const Recording& r) {
            std::vector<std::string> remarks;
            for (const std::string& one : r.remarks) {
              remarks.push_back(in_python(one));
            }
            return remarks;
          },
          "What the reader corrected, left out or counted.")
      .def_readonly("cameras", &Recording::cameras, "Those of the rig, in its order.")
      .def_readonly("imu_noise", &Recording::imu_noise, "As the recording states it, or None.")
      .def_property_readonly(
          "imu", [](const Recording& r) { return imu_columns(r.imu); },
          "{'time': (N,) int64 [ns], 'specific_force': (N, 3) [m/s^2], "
          "'angular_rate': (N, 3) [rad/s]} in IMU axes.")
      .def_property_readonly("frame_times", &frame_times, "Of images or tracks: (N,) int64 [ns].")
      .def_property_readonly(
          "truth",
          [](const Recording& r) {
            py::dict truth = columns(r.truth);
            if (!r.truth_attitudes) PyDict_DelItemString(truth.ptr(), "quaternion");
            return truth;
          },
          "world_T_imu: {'time': (N,) int64 [ns], 'position': (N, 3) [m], 'quaternion': (N, 4) x y "
          "z w}; empty where unknown, and without the quaternion where it has positions alone.")
      .def("images", &images, py::arg("index"),
           "The images of a frame: for each camera an array (height, width) of uint8, or None.")
      .def("tracks", &tracks, py::arg("index"),
           "The observations of a frame of tracks: {'landmark': (N,), 'camera': (N,), 'pixel': (N, "
           "2) "
           "or, of a rectified pair, (N, 4)}.")
      .def("__len__", &frame_count)
      .def("__repr__", &text_of);

  m.def("read", &read, py::arg("path"), py::kw_only(), py::arg("start") = std::nullopt,
        py::arg("stop") = std::nullopt, py::arg("backwards") = false, py::arg("cameras") = "",
        py::arg("truth") = "", py::arg("truth_level") = "", py::arg("pairing") = "",
        py::arg("max_truth_gap") = std::nullopt, py::arg("truth_time_offset") = "",
        py::arg("truth_frame") = "", py::arg("truth_scale") = std::nullopt,
        py::arg("truth_inverse") = false);
}

}  // namespace chasles::python
