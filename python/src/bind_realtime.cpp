#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/realtime_slam.hpp>

#include "forks.hpp"
#include "interpreter_exit.hpp"
#include "long_call.hpp"
#include "module.hpp"
#include "slam_input.hpp"
#include "turns.hpp"

namespace chasles::python {
namespace {

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
    RealtimeSlam& slam = checked();
    try {
      const Released released;
      return work(slam);
    } catch (const py::error_already_set& error) {
      PyErr_Restore(error.type().inc_ref().ptr(), error.value().inc_ref().ptr(),
                    error.trace() ? error.trace().inc_ref().ptr() : nullptr);
    }
    throw py::error_already_set();
  }

  template <typename Question>
  auto ask(const Question& question) {
    return unlocked([&](RealtimeSlam& realtime) {
      reject_in_call();
      decltype(question(std::declval<VisualInertialSlam&>())) answer;
      realtime.ask([&](VisualInertialSlam& slam) { answer = question(slam); });
      return answer;
    });
  }

 public:
  Realtime(const py::object& cameras, const ImuNoise* noise, const std::string& estimator,
           const std::optional<std::filesystem::path>& map, std::size_t most_images,
           const py::kwargs& arguments)
      : slam_(std::make_unique<RealtimeSlam>(
            make_slam("RealtimeSlam", cameras, noise, estimator, map, arguments),
            RealtimeSlam::Options{.most_images = most_images, .turn = &estimation()},
            [ready = ready_](std::span<const Estimate> some, VisualInertialSlam&) {
              ready->add({some.begin(), some.end()});
            })) {
    all().insert(this);
  }
  // The thread may be in a chart that is written in Python. Within a call this thread may be that
  // one, or have the turn for which that one waits: another thread then ends it.
  ~Realtime() {
    all().erase(this);
    if (generation_ != fork_generation()) {  // the thread is in another process
      static_cast<void>(slam_.release());
      return;
    }
    if (PythonCall::active() || ends_for_exit()) {
      std::thread([slam = std::move(slam_)]() mutable { slam.reset(); }).detach();
      return;
    }
    const Released released;
    slam_.reset();
  }
  Realtime(const Realtime&) = delete;
  Realtime& operator=(const Realtime&) = delete;

  void add_imu(const py::object& time, const Rows& rate, const Rows& force) {
    const std::vector<ImuSample> samples = samples_of(time, rate, force);
    unlocked([&](RealtimeSlam& slam) {
      for (const ImuSample& sample : samples) slam.process(sample);
    });
    warnings_.warn(checked().arrivals());
  }

  std::size_t add_images(const py::object& time, const py::object& images) {
    ImageFrame frame = frame_of(time, images);
    const std::size_t displaced =
        unlocked([&](RealtimeSlam& slam) { return slam.process(std::move(frame)); });
    warnings_.warn(checked().arrivals());
    return displaced;
  }

  Estimates take() {
    warnings_.warn(checked().arrivals());
    return ready_->take();
  }

  std::string text() {
    if (!slam_) return "<chasles.RealtimeSlam: ended>";
    const RealtimeSlam::Counts n = slam_->counts();
    return fmt::format("<chasles.RealtimeSlam: {} images came, {} taken, {} dropped, {} wait>",
                       n.came, n.taken, n.dropped, n.waiting);
  }

  // All that has not been taken.
  Estimates finish() {
    Signals signals;
    Estimates last = unlocked([&](RealtimeSlam& slam) {
      reject_in_call();
      return slam.finish([&] { return signals.pending(); });
    });
    ready_->add(std::move(last));
    signals.rethrow();
    warnings_.warn(checked().arrivals());
    return ready_->take();
  }

  std::optional<PredictedState> predicted(const py::object& at) {
    const Time time = time_of(at);
    const RealtimeSlam& slam = checked();
    const Released released;
    return slam.predicted(time);
  }

  py::dict counts() {
    const RealtimeSlam::Counts n = checked().counts();
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

  // At the end of the interpreter, with the GIL: their threads may be in a chart of Python.
  static void end_all() {
    auto ended = std::make_shared<std::atomic<std::size_t>>(0);
    const std::size_t count = all().size();
    for (Realtime* const one : all()) {
      if (one->generation_ != fork_generation()) static_cast<void>(one->slam_.release());
      std::thread([slam = std::move(one->slam_), ended]() mutable {
        slam.reset();
        ++*ended;
      }).detach();
    }
    const py::gil_scoped_release released;
    wait_at_exit([&] { return *ended == count; });
  }

 private:
  // Those that live. With the GIL.
  static std::set<Realtime*>& all() {
    static auto* const objects = new std::set<Realtime*>;
    return *objects;
  }

  // The thread that works for this object.
  RealtimeSlam& checked() {
    reject_thread_of(generation_, "RealtimeSlam");
    if (!slam_) throw UsageError("RealtimeSlam: its thread ended with the interpreter");
    return *slam_;
  }

  const int generation_ = fork_generation();
  std::shared_ptr<ReadyEstimates> ready_ = std::make_shared<ReadyEstimates>();
  ArrivalWarnings warnings_;
  std::unique_ptr<RealtimeSlam> slam_;  // last: its thread uses the others
};

}  // namespace

void bind_realtime(py::module_& m) {
  const char* const samples =
      "A sample, or (N,) of them. Times are ints [ns] or floats [s]; angular rates [rad/s] and "
      "specific forces [m/s^2] in IMU axes: (3,) or (N, 3).";
  py::class_<Realtime>(m, "RealtimeSlam",
                       "Slam on a thread of its own: calls return at once, and images that the "
                       "estimator has no time for are dropped. Any thread may call.")
      .def(py::init<const py::object&, const ImuNoise*, const std::string&,
                    const std::optional<std::filesystem::path>&, std::size_t, const py::kwargs&>(),
           py::arg("cameras"), py::arg("noise"), py::kw_only(), py::arg("estimator") = "filter",
           py::arg("map") = py::none(), py::arg("most_images") = 3, kSlamArguments)
      .def("add_imu", &Realtime::add_imu, py::arg("time"), py::arg("angular_rate"),
           py::arg("specific_force"), samples)
      .def("add_images", &Realtime::add_images, py::arg("time"), py::arg("images"),
           "The images of all cameras at one instant: arrays (height, width) of uint8, images of "
           "Pillow, or None; of one camera also its image alone. "
           "Where more than most_images wait, the oldest are dropped; returns how many.")
      .def("take", &Realtime::take, "The estimates since the last call.")
      .def("predicted", &Realtime::predicted, py::arg("time"), kPredicted)
      .def("finish", &Realtime::finish,
           "Waits until all that has come is processed; returns the estimates not yet taken. With "
           "estimator='batch' the final estimates of all frames follow them and replace them.")
      .def_property_readonly(
          "counts", &Realtime::counts,
          "Images: {'came', 'taken', 'dropped', 'waiting'}, and of what was taken those of "
          "Slam.counts.")
      .def_property_readonly("why_not_started", &Realtime::why_not_started,
                             "The conditions of a start that are not met.")
      .def_property_readonly(
          "landmarks", [](Realtime& slam) { return columns(slam.map()); }, "As Slam.landmarks.")
      .def("__repr__", &Realtime::text);
  at_exit_also(&Realtime::end_all);
}

}  // namespace chasles::python
