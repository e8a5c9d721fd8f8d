#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>

#include "forks.hpp"
#include "interpreter_exit.hpp"
#include "long_call.hpp"
#include "module.hpp"
#include "slam_input.hpp"
#include "turns.hpp"

namespace chasles::python {
namespace {

// Python's other threads go on during a call.
class Slam {
  template <typename Work>
  auto locked(const Work& work) {
    const Released released;
    const auto turn = take_turn();
    return work(*slam_);
  }

  // Of a call that brings data.
  template <typename Work>
  Estimates taken(const Work& work) {
    ArrivalCounts counts;
    Estimates estimates = locked([&](VisualInertialSlam& slam) {
      Estimates some = work(slam);
      counts = slam.arrivals();
      return some;
    });
    append(std::move(estimates), ready_);
    warnings_.warn(counts);  // may throw
    return std::exchange(ready_, {});
  }

 public:
  Slam(const py::object& cameras, const ImuNoise* noise, const std::string& estimator,
       const std::optional<std::filesystem::path>& map, const py::kwargs& arguments)
      : slam_(make_slam("Slam", cameras, noise, estimator, map, arguments)) {}

  Estimates add_imu(const py::object& time, const Rows& rate, const Rows& force) {
    const std::vector<ImuSample> samples = samples_of(time, rate, force);
    reject_after_finish("sample");
    return taken([&](VisualInertialSlam& slam) {
      Estimates estimates;
      for (const ImuSample& sample : samples) append(slam.process(sample), estimates);
      return estimates;
    });
  }

  Estimates add_images(const py::object& time, const py::object& images) {
    ImageFrame frame = frame_of(time, images);
    reject_after_finish("images");
    return taken([&](VisualInertialSlam& slam) { return slam.process(std::move(frame)); });
  }

  Estimates finish() {
    if (finished_) return std::exchange(ready_, {});
    LongCall call;
    Estimates last = call.in_turn([&] { return slam_->finish([&] { return call.stopped(); }); });
    finished_ = true;
    append(std::move(last), ready_);
    warnings_.warn(slam_->arrivals());  // may throw
    return std::exchange(ready_, {});
  }

  std::optional<PredictedState> predicted(const py::object& at) {
    const Time time = time_of(at);
    return locked([&](VisualInertialSlam& slam) { return slam.predicted(time); });
  }

  bool started() {
    return locked([](const VisualInertialSlam& s) { return s.estimator().started(); });
  }
  std::string why_not_started() {
    return locked([](const VisualInertialSlam& s) { return s.estimator().why_not_started(); });
  }
  std::size_t waiting() {
    return locked([](const VisualInertialSlam& s) { return s.waiting(); });
  }
  py::dict counts() {
    py::dict result;
    add_counts(locked([](const VisualInertialSlam& s) { return s.arrivals(); }), result);
    return result;
  }
  std::vector<MapLandmark> map() {
    return locked([](const VisualInertialSlam& s) { return s.estimator().map(); });
  }
  std::string text() {
    return locked([](const VisualInertialSlam& s) {
      return fmt::format("<chasles.Slam of {} cameras: {}, {} images wait>", s.cameras().size(),
                         s.estimator().started() ? "started" : "not started", s.waiting());
    });
  }

 private:
  void reject_after_finish(const char* what) const {
    if (finished_) throw UsageError(fmt::format("Slam: expected no {} after finish()", what));
  }

  std::unique_ptr<VisualInertialSlam> slam_;
  bool finished_ = false;
  ArrivalWarnings warnings_;
  Estimates ready_;
};

}  // namespace

void bind_slam(py::module_& m) {
  py::class_<Slam>(m, "Slam",
                   "Visual-inertial SLAM step by step. Any thread may call; estimators take turns, "
                   "and other Python threads go on meanwhile.")
      .def(py::init<const py::object&, const ImuNoise*, const std::string&,
                    const std::optional<std::filesystem::path>&, const py::kwargs&>(),
           py::arg("cameras"), py::arg("noise"), py::kw_only(), py::arg("estimator") = "filter",
           py::arg("map") = py::none(), kSlamArguments)
      .def(
          "add_imu", &Slam::add_imu, py::arg("time"), py::arg("angular_rate"),
          py::arg("specific_force"),
          "A sample, or (N,) of them. Times are ints [ns] or floats [s]; angular rates [rad/s] and "
          "specific forces [m/s^2] in IMU axes: (3,) or (N, 3). Returns the estimates of the "
          "images that waited for them.")
      .def("add_images", &Slam::add_images, py::arg("time"), py::arg("images"),
           "The images of all cameras at one instant: arrays (height, width) of uint8, images of "
           "Pillow, or None; of one camera also its image alone. "
           "Returns the estimates that are ready.")
      .def("finish", &Slam::finish,
           "The estimates of the images that still wait, and the end of the Slam, which takes "
           "nothing after it. With estimator='batch' they are the final estimates of all frames, "
           "which replace those that the other calls have returned.")
      .def("predicted", &Slam::predicted, py::arg("time"), kPredicted)
      .def_property_readonly("started", &Slam::started, "Whether there is an estimate.")
      .def_property_readonly("why_not_started", &Slam::why_not_started,
                             "The conditions of a start that are not met.")
      .def_property_readonly("waiting", &Slam::waiting, "Number of images that wait for samples.")
      .def_property_readonly(
          "counts", &Slam::counts,
          "{'samples', 'samples_not_finite', 'samples_late', 'samples_dropped', 'images', "
          "'images_late', 'images_uncovered'}: what came, and what of it gives no estimate: late "
          "is "
          "what is not later than what was used; uncovered are images without samples until their "
          "time.")
      .def_property_readonly(
          "landmarks", [](Slam& slam) { return columns(slam.map()); },
          "{'id': (N,), 'position': (N, 3) world [m], 'covariance': (N, 3, 3), "
          "'observations': (N,)}.")
      .def("__repr__", &Slam::text);
}

}  // namespace chasles::python
