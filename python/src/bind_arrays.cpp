#include <memory>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/recording/time_spans.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/session/truth_options.hpp>

#include "arrays.hpp"
#include "interpreter_exit.hpp"
#include "module.hpp"
#include "recordings.hpp"
#include "turns.hpp"

// A recording of what is in memory: Recording.from_arrays().
namespace chasles::python {
namespace {

using Eigen::Index;

// A function of Python that any thread may drop.
std::shared_ptr<const py::object> kept(py::object function) {
  return {new py::object(std::move(function)), [](const py::object* object) {
            const Held held;
            delete object;
          }};
}

// Images that a function of Python returns: of each camera an array, the path of a file, or None.
class PythonImages : public ImageSource {
 public:
  PythonImages(std::vector<Time> times, std::vector<Camera> cameras, py::object images)
      : times_(std::move(times)), cameras_(std::move(cameras)), images_(kept(std::move(images))) {}

  std::size_t size() const override { return times_.size(); }
  Time time(std::size_t i) const override { return times_[i]; }
  ImageFrame read(std::size_t i) const override { return read_cameras(i, cameras_.size()); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    return read_undamaged(i, cameras, &throw_damage);
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    ImageFrame frame{.time = times_[i], .images = {}};
    std::vector<std::string> paths;
    take(i, frame.images, paths);
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const ImageSize size{.width = cameras_[c].width, .height = cameras_[c].height};
      GrayImage& image = frame.images[c];
      if (!paths[c].empty() && c < cameras) {
        image = read_or_empty([&] { return read_image(paths[c], size); }, damaged);
      }
      check_size(image, size, i, c);
    }
    frame.images.resize(std::min(cameras, frame.images.size()));
    return frame;
  }

  /// Throws for images of a frame that are none. Reads no file.
  void check(std::size_t i) const {
    std::vector<GrayImage> images;
    std::vector<std::string> paths;
    take(i, images, paths);
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      check_size(images[c], {.width = cameras_[c].width, .height = cameras_[c].height}, i, c);
    }
  }

 private:
  void take(std::size_t i, std::vector<GrayImage>& images, std::vector<std::string>& paths) const {
    const PythonCall call;
    const py::list all((*images_)(i));
    if (all.size() != cameras_.size()) {
      throw UsageError(
          fmt::format("images: frame {} has {} images, expected {}, one of each camera", i,
                      all.size(), cameras_.size()));
    }
    for (const py::handle& one : all) {
      const bool is_path = py::isinstance<py::str>(one);
      paths.push_back(is_path ? one.cast<std::string>() : std::string());
      images.push_back(
          is_path ? GrayImage{}
                  : image_of(one, fmt::format("images: frame {}, camera {}", i, images.size())));
    }
  }

  static void check_size(const GrayImage& image, const ImageSize& size, std::size_t frame,
                         std::size_t camera) {
    if (image.empty() || (image.width == size.width && image.height == size.height)) return;
    throw ImageSizeError(
        fmt::format("images: that of camera {} in frame {} has {} x {} pixels, expected {} x {}, "
                    "the size of the "
                    "camera",
                    camera, frame, image.width, image.height, size.width, size.height));
  }

  std::vector<Time> times_;
  std::vector<Camera> cameras_;
  std::shared_ptr<const py::object> images_;
};

std::vector<Time> rising(const std::vector<Time>& times, const char* what) {
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    throw InputError(fmt::format(
        "{}: row {} has the time {} ns, after {} ns; expected times that rise (numpy.argsort and "
        "numpy.unique put them in order)",
        what, i, times[i].count(), times[i - 1].count()));
  }
  return times;
}

std::vector<ImuSample> samples_of_arrays(const py::array& times, const Rows& rates,
                                         const Rows& forces) {
  const std::vector<Time> stamps = rising(times_of(times, "imu_time"), "imu_time");
  const auto n = static_cast<Index>(stamps.size());
  if (rates.rows() != n || forces.rows() != n || rates.cols() != 3 || forces.cols() != 3) {
    throw InputError(fmt::format(
        "from_arrays: found {} IMU times, angular rates {} x {} and specific forces {} x {}; "
        "expected (N,), (N, 3) and (N, 3)",
        n, rates.rows(), rates.cols(), forces.rows(), forces.cols()));
  }
  std::vector<ImuSample> samples(stamps.size());
  for (Index i = 0; i < n; ++i) {
    ImuSample& sample = samples[static_cast<std::size_t>(i)];
    sample.time = stamps[static_cast<std::size_t>(i)];
    sample.specific_force_imu = forces.row(i);
    sample.angular_rate_imu = rates.row(i);
    if (!sample.specific_force_imu.allFinite() || !sample.angular_rate_imu.allFinite()) {
      throw InputError(
          fmt::format("from_arrays: IMU sample {} is not finite; expected numbers", i));
    }
  }
  return samples;
}

Recording recording_of(const std::string& name, const py::array& imu_time, const Rows& rates,
                       const Rows& forces, const py::array& image_time, const py::object& images,
                       bool check_first, const std::vector<Camera>& cameras,
                       const std::optional<ImuNoise>& noise, const py::array& truth_time,
                       const Rows& truth_position, const Rows& truth_quaternion,
                       std::optional<bool> truth_level, const std::filesystem::path& truth_file) {
  Recording recording;
  recording.name = name;
  if (cameras.empty()) throw UsageError("from_arrays: found no camera, expected one or more");
  recording.cameras = cameras;
  recording.imu = samples_of_arrays(imu_time, rates, forces);
  recording.imu_noise = noise;
  recording.truth = trajectory_of("truth", truth_time, truth_position, truth_quaternion);
  recording.truth_attitudes = recording.truth.empty() || truth_quaternion.size() > 0;
  if (!recording.truth.empty()) {
    recording.truth_level = is_truth_level({}, truth_level, recording.truth);
  }
  if (recording.imu.empty() || image_time.size() == 0) {
    throw UsageError(
        fmt::format("from_arrays: found {} IMU samples and {} frames of images, expected both",
                    recording.imu.size(), image_time.size()));
  }
  const auto source = std::make_shared<const PythonImages>(
      rising(times_of(image_time, "image_time"), "image_time"), cameras, images);
  if (check_first) source->check(0);
  recording.images = source;
  check_time_spans("from_arrays", recording);
  if (!truth_file.empty()) {
    TruthOptions options;
    if (truth_level) options.level = *truth_level ? "yes" : "no";
    replace_truth(recording, truth_file, options);
  }
  return shared(std::move(recording));
}

}  // namespace

void bind_arrays(py::module_& m) {
  m.def("recording_of", &recording_of, py::arg("name"), py::arg("imu_time"),
        py::arg("angular_rate"), py::arg("specific_force"), py::arg("image_time"),
        py::arg("images"), py::arg("check_first"), py::arg("cameras"), py::arg("imu_noise"),
        py::arg("truth_time"), py::arg("truth_position"), py::arg("truth_quaternion"),
        py::arg("truth_level"), py::arg("truth_file"));
}

}  // namespace chasles::python
