#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/error.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/pipeline/realtime_slam.hpp>

#include "arrays.hpp"
#include "inertial_settings_io.hpp"
#include "module.hpp"
#include "turns.hpp"

namespace chasles::python {
namespace {

using Estimates = std::vector<Estimate>;

std::unique_ptr<VisualInertialSlam> make_slam(const std::vector<Camera>& cameras,
                                              const ImuNoise& noise, const std::string& estimator,
                                              const std::string& map, const py::kwargs& arguments) {
  app::SettingSources sources;
  sources.sets = assignments(arguments);
  sources.set_option = "setting";
  sources.estimator = estimator_choice(estimator);
  const py::gil_scoped_release released;
  InertialRunSettings settings = app::inertial_run_settings_from(sources);
  std::shared_ptr<const LandmarkMap> prior;
  if (!map.empty()) {
    settings.filter.recognise = Recognise::kAppearance;
    prior = std::make_shared<const LandmarkMap>(read_map(map));
  }
  return std::make_unique<VisualInertialSlam>(cameras, noise, settings, ImuBuffer::Options{},
                                              std::vector<GrayImage>{}, std::move(prior));
}

// One sample's (3,) is a column for Eigen.
Rows as_rows(const Rows& rows) {
  return rows.cols() == 1 && rows.rows() == 3 ? Rows(rows.transpose()) : rows;
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

ImageFrame frame_of(const py::object& time, const py::sequence& images) {
  ImageFrame frame{.time = time_of(time), .images = {}};
  for (const py::handle& image : images) frame.images.push_back(image_of(image));
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

// Warns once of each kind of input that gives no estimate.
class ArrivalWarnings {
 public:
  void warn(const ArrivalCounts& counts) {
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

 private:
  static void once(bool& warned, std::size_t count, const std::string& what) {
    if (warned || count == 0) return;
    warned = true;
    const std::string text = what + "; `counts` has their number, and this is said once";
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) < 0) throw py::error_already_set();
  }

  bool not_finite_ = false, late_samples_ = false, dropped_ = false, late_images_ = false,
       uncovered_ = false;
};

// Python's other threads go on during a call.
class Slam {
  template <typename Work>
  auto locked(const Work& work) {
    const py::gil_scoped_release released;
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
    warnings_.warn(counts);
    return estimates;
  }

 public:
  Slam(const std::vector<Camera>& cameras, const ImuNoise& noise, const std::string& estimator,
       const std::string& map, const py::kwargs& arguments)
      : slam_(make_slam(cameras, noise, estimator, map, arguments)) {}

  Estimates add_imu(const py::object& time, const Rows& rate, const Rows& force) {
    const std::vector<ImuSample> samples = samples_of(time, rate, force);
    return taken([&](VisualInertialSlam& slam) {
      Estimates estimates;
      for (const ImuSample& sample : samples) append(slam.process(sample), estimates);
      return estimates;
    });
  }

  Estimates add_images(const py::object& time, const py::sequence& images) {
    ImageFrame frame = frame_of(time, images);
    return taken([&](VisualInertialSlam& slam) { return slam.process(std::move(frame)); });
  }

  Estimates finish() {
    Signals signals;
    Estimates last =
        taken([&](VisualInertialSlam& s) { return s.finish([&] { return signals.pending(); }); });
    signals.rethrow();
    return last;
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

 private:
  std::unique_ptr<VisualInertialSlam> slam_;
  ArrivalWarnings warnings_;
};

// The estimates of a RealtimeSlam that Python has not taken yet.
class ReadyEstimates {
 public:
  void add(Estimates some) {
    const std::lock_guard lock(mutex_);
    append(std::move(some), list_);
  }
  Estimates take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(list_, {});
  }

 private:
  std::mutex mutex_;
  Estimates list_;
};

class Realtime {
  // The estimator's error comes with each call, as the same object, of which pybind11 can hand the
  // Python error back once.
  template <typename Work>
  auto unlocked(const Work& work) {
    try {
      const py::gil_scoped_release released;
      return work(*slam_);
    } catch (const py::error_already_set& error) {
      PyErr_Restore(error.type().inc_ref().ptr(), error.value().inc_ref().ptr(),
                    error.trace() ? error.trace().inc_ref().ptr() : nullptr);
    }
    throw py::error_already_set();
  }

  template <typename Question>
  auto ask(const Question& question) {
    return unlocked([&](RealtimeSlam& realtime) {
      refuse_in_call();
      decltype(question(std::declval<VisualInertialSlam&>())) answer;
      realtime.ask([&](VisualInertialSlam& slam) { answer = question(slam); });
      return answer;
    });
  }

 public:
  Realtime(const std::vector<Camera>& cameras, const ImuNoise& noise, const std::string& estimator,
           const std::string& map, std::size_t most_images, const py::kwargs& arguments)
      : slam_(std::make_unique<RealtimeSlam>(
            make_slam(cameras, noise, estimator, map, arguments),
            RealtimeSlam::Options{.most_images = most_images, .turn = &estimation()},
            [ready = ready_](std::span<const Estimate> some, VisualInertialSlam&) {
              ready->add({some.begin(), some.end()});
            })) {}
  // The thread may be in a chart that is written in Python. Within a call this thread may be that
  // one, or have the turn for which that one waits: another thread then ends it.
  ~Realtime() {
    const py::gil_scoped_release released;
    if (PythonCall::active()) {
      std::thread([slam = std::move(slam_)]() mutable { slam.reset(); }).detach();
    } else {
      slam_.reset();
    }
  }
  Realtime(const Realtime&) = delete;
  Realtime& operator=(const Realtime&) = delete;

  void add_imu(const py::object& time, const Rows& rate, const Rows& force) {
    const std::vector<ImuSample> samples = samples_of(time, rate, force);
    unlocked([&](RealtimeSlam& slam) {
      for (const ImuSample& sample : samples) slam.process(sample);
    });
    warnings_.warn(slam_->arrivals());
  }

  std::size_t add_images(const py::object& time, const py::sequence& images) {
    ImageFrame frame = frame_of(time, images);
    const std::size_t displaced =
        unlocked([&](RealtimeSlam& slam) { return slam.process(std::move(frame)); });
    warnings_.warn(slam_->arrivals());
    return displaced;
  }

  Estimates take() {
    warnings_.warn(slam_->arrivals());
    return ready_->take();
  }

  // All that has not been taken.
  Estimates finish() {
    Signals signals;
    Estimates last = unlocked([&](RealtimeSlam& slam) {
      refuse_in_call();
      return slam.finish([&] { return signals.pending(); });
    });
    signals.rethrow();
    warnings_.warn(slam_->arrivals());
    Estimates all = ready_->take();
    append(std::move(last), all);
    return all;
  }

  std::optional<PredictedState> predicted(const py::object& at) {
    const Time time = time_of(at);
    const py::gil_scoped_release released;
    return slam_->predicted(time);
  }

  py::dict counts() {
    const RealtimeSlam::Counts n = slam_->counts();
    py::dict result;
    result["came"] = n.came;
    result["taken"] = n.taken;
    result["dropped"] = n.dropped;
    result["waiting"] = n.waiting;
    add_counts(slam_->arrivals(), result);
    return result;
  }

  std::string why_not_started() {
    return ask([](const VisualInertialSlam& slam) { return slam.estimator().why_not_started(); });
  }

  std::vector<MapLandmark> map() {
    return ask([](const VisualInertialSlam& slam) { return slam.estimator().map(); });
  }

 private:
  std::shared_ptr<ReadyEstimates> ready_ = std::make_shared<ReadyEstimates>();
  ArrivalWarnings warnings_;
  std::unique_ptr<RealtimeSlam> slam_;  // last: its thread uses the others
};

}  // namespace

void bind_slam(py::module_& m) {
  const char* const arguments =
      "cameras: list of Camera; noise: ImuNoise; estimator: 'filter', 'window:N' or 'batch'; "
      "map: file of a saved map; and settings by name, as chasles.settings() lists them.";
  const char* const samples =
      "A sample, or (N,) of them. Times are ints [ns] or floats [s]; angular rates [rad/s] and "
      "specific forces [m/s^2] in IMU axes: (3,) or (N, 3).";
  const char* const predicted =
      "The state at a time since the last estimate, by the samples (PredictedState). None before a "
      "start, before the last estimate's time, .5 s after the last sample, 5 s after the estimate, "
      "where the estimate is lost, and where samples are missing for more than .5 s.";
  py::class_<Realtime>(m, "RealtimeSlam",
                       "Slam on a thread of its own: calls return at once, and images that the "
                       "estimator has no time for are dropped. Any thread may call.")
      .def(py::init<const std::vector<Camera>&, const ImuNoise&, const std::string&,
                    const std::string&, std::size_t, const py::kwargs&>(),
           py::arg("cameras"), py::arg("noise"), py::kw_only(), py::arg("estimator") = "filter",
           py::arg("map") = "", py::arg("most_images") = 3, arguments)
      .def("add_imu", &Realtime::add_imu, py::arg("time"), py::arg("angular_rate"),
           py::arg("specific_force"), samples)
      .def("add_images", &Realtime::add_images, py::arg("time"), py::arg("images"),
           "The images of all cameras at one instant: arrays (height, width) of uint8, or None. "
           "Where more than most_images wait, the oldest are dropped; returns how many.")
      .def("take", &Realtime::take, "The estimates since the last call.")
      .def("predicted", &Realtime::predicted, py::arg("time"), predicted)
      .def("finish", &Realtime::finish,
           "Waits until all that has come is processed; returns the estimates not yet taken.")
      .def_property_readonly(
          "counts", &Realtime::counts,
          "Images: {'came', 'taken', 'dropped', 'waiting'}, and of what was taken those of "
          "Slam.counts.")
      .def_property_readonly("why_not_started", &Realtime::why_not_started)
      .def_property_readonly(
          "landmarks", [](Realtime& slam) { return columns(slam.map()); }, "As Slam.landmarks.");

  py::class_<Slam>(m, "Slam",
                   "Visual-inertial SLAM step by step. Any thread may call; estimators take turns, "
                   "and other Python threads go on meanwhile.")
      .def(py::init<const std::vector<Camera>&, const ImuNoise&, const std::string&,
                    const std::string&, const py::kwargs&>(),
           py::arg("cameras"), py::arg("noise"), py::kw_only(), py::arg("estimator") = "filter",
           py::arg("map") = "", arguments)
      .def(
          "add_imu", &Slam::add_imu, py::arg("time"), py::arg("angular_rate"),
          py::arg("specific_force"),
          "A sample, or (N,) of them. Times are ints [ns] or floats [s]; angular rates [rad/s] and "
          "specific forces [m/s^2] in IMU axes: (3,) or (N, 3). Returns the estimates of the "
          "images that waited for them.")
      .def("add_images", &Slam::add_images, py::arg("time"), py::arg("images"),
           "The images of all cameras at one instant: arrays (height, width) of uint8, or None. "
           "Returns the estimates that are ready.")
      .def("finish", &Slam::finish, "The estimates of the images that still wait.")
      .def("predicted", &Slam::predicted, py::arg("time"), predicted)
      .def_property_readonly("started", &Slam::started)
      .def_property_readonly("why_not_started", &Slam::why_not_started)
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
          "'observations': (N,)}.");
}

}  // namespace chasles::python
