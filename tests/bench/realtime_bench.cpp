// What a robot's program waits for: the state between images (StatePredictor::at, whose goal is 5
// us for a controller at 1 kHz), the step of a sample, a new beginning at an estimate, and the
// calls of RealtimeSlam beside those of VisualInertialSlam with the same images.

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <chasles/base/median.hpp>
#include <chasles/pipeline/realtime_slam.hpp>
#include <chasles/sim/render_images.hpp>

namespace chasles {
namespace {

const Recording& rendered() {
  static const Recording recording = [] {
    InertialScene scene = inertial_scene("hallway");
    scene.settings.sections = 1;
    scene.settings.hall_length = 12;
    return render_inertial(scene);
  }();
  return recording;
}

std::unique_ptr<VisualInertialSlam> new_slam() {
  const Recording& r = rendered();
  return std::make_unique<VisualInertialSlam>(r.cameras, *r.imu_noise, InertialRunSettings{},
                                              ImuBuffer::Options{.convention = r.imu_convention});
}

// Samples of 200 Hz since an estimate.
StatePredictor after_samples(int samples, Time& now) {
  StatePredictor predictor(*rendered().imu_noise, {});
  Estimate e;
  e.time = std::chrono::seconds(1);
  e.v_world = Eigen::Vector3d(1, 0, 0);
  e.additive = Vector6d::Zero();
  e.covariance = Matrix15d::Identity();
  now = e.time;
  predictor.add({.time = now, .specific_force_imu = {0, 0, 9.8}});
  predictor.correct(e);
  for (int i = 0; i < samples; ++i) {
    now += std::chrono::milliseconds(5);
    predictor.add(
        {.time = now, .specific_force_imu = {0.1, 0.2, 9.8}, .angular_rate_imu = {0.1, 0.3, -0.2}});
  }
  return predictor;
}

void predicted(benchmark::State& state) {
  Time now{};
  StatePredictor predictor = after_samples(static_cast<int>(state.range(0)), now);
  for (auto _ : state) benchmark::DoNotOptimize(predictor.at(now + std::chrono::milliseconds(2)));
}

void a_sample(benchmark::State& state) {
  Time now{};
  StatePredictor predictor = after_samples(0, now);
  const StatePredictor fresh = predictor;
  int since = 0;
  for (auto _ : state) {
    if (++since == 20) {
      state.PauseTiming();
      predictor = fresh;
      now -= since * std::chrono::milliseconds(5);
      since = 0;
      state.ResumeTiming();
    }
    now += std::chrono::milliseconds(5);
    predictor.add({.time = now, .specific_force_imu = {0.1, 0.2, 9.8}});
  }
}

// Of an image that is 20 samples old.
void a_late_estimate(benchmark::State& state) {
  Time now{};
  const StatePredictor before = after_samples(20, now);
  Estimate e;
  e.time = std::chrono::seconds(1);
  e.v_world = Eigen::Vector3d(1, 0, 0);
  e.additive = Vector6d::Zero();
  e.covariance = Matrix15d::Identity();
  StatePredictor predictor = before;
  for (auto _ : state) predictor.correct(e);
}

// The median time of the caller for an image, blocking and not: on a busy machine the thread that
// is woken takes the caller's place now and then.
template <typename Slam>
double seconds_of_calls(Slam& slam) {
  std::vector<double> seconds;
  EventStream events(rendered());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (!due) continue;
    ImageFrame frame = rendered().images->read(due->index);
    const auto started = std::chrono::steady_clock::now();
    slam.process(std::move(frame));
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count());
  }
  slam.finish();
  return median(std::move(seconds));
}

void blocking_images(benchmark::State& state) {
  for (auto _ : state) {
    const auto slam = new_slam();
    state.SetIterationTime(seconds_of_calls(*slam));
  }
}

void images_on_a_thread(benchmark::State& state) {
  for (auto _ : state) {
    RealtimeSlam slam(new_slam(), {.most_images = 0});
    state.SetIterationTime(seconds_of_calls(slam));
  }
}

BENCHMARK(predicted)->Arg(0)->Arg(20)->Unit(benchmark::kMicrosecond);
BENCHMARK(a_sample)->Unit(benchmark::kMicrosecond);
BENCHMARK(a_late_estimate)->Unit(benchmark::kMicrosecond);
BENCHMARK(blocking_images)->UseManualTime()->Unit(benchmark::kMicrosecond)->Iterations(1);
BENCHMARK(images_on_a_thread)->UseManualTime()->Unit(benchmark::kMicrosecond)->Iterations(1);

}  // namespace
}  // namespace chasles

BENCHMARK_MAIN();
