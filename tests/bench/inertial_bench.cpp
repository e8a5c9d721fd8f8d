// The processor time of the inertial filter: a walk of 60 s through the hallway (100 Hz IMU, 28 Hz
// frames, about 35 landmarks in view) in each error chart, with the default landmark initialisation
// and with Kleinert & Stilla's; and the step of one IMU sample. `x_real_time` is the factor by
// which the filter is faster than real time.

#include <string>

#include <benchmark/benchmark.h>

#include <chasles/filter/dense.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

const Recording& walk() {
  static const Recording recording = [] {
    Recording r = simulate_inertial(inertial_scene("hallway"), 0);
    const Time end = r.frames.front().time + from_seconds(60);
    std::erase_if(r.frames, [&](const FeatureFrame& frame) { return frame.time > end; });
    return r;
  }();
  return recording;
}

void hallway(benchmark::State& state, const std::string& chart, LandmarkInit init) {
  FilterVariant filter;
  filter.settings.chart = chart;
  filter.settings.init = init;
  if (init == LandmarkInit::kFixedDepth) {
    filter.settings.landmarks = LandmarkForm::kCartesian;
    filter.settings.nav_attitude = true;
  }
  const InertialStart start = draw_start(walk(), filter.settings, 1, 0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(run_trial(filter, walk(), start));
  }
  const double seconds = to_seconds(walk().frames.back().time - walk().frames.front().time);
  state.counters["x_real_time"] =
      benchmark::Counter(seconds, benchmark::Counter::kIsIterationInvariantRate);
}

void strapdown_step(benchmark::State& state) {
  InertialState x;
  const ImuInterval interval{
      .tau = 0.01, .specific_force_imu = {0.3, -0.2, 9.8}, .angular_rate_imu = {0.2, 0.5, -0.1}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(strapdown(x, interval, {0, 0, -kStandardGravity}, ImuNoise{}));
  }
}

void declare() {
  for (const LandmarkInit init : {LandmarkInit::kFixedDepth, LandmarkInit::kMultiView}) {
    for (const ErrorChart& chart : error_charts()) {
      const std::string name(chart.name);
      benchmark::RegisterBenchmark(
          ("hallway/" + std::string(name_of(init)) + "/" + name).c_str(),
          [name, init](benchmark::State& state) { hallway(state, name, init); })
          ->Unit(benchmark::kMillisecond)
          ->Iterations(3);
    }
  }
  benchmark::RegisterBenchmark("strapdown", strapdown_step);
}

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  chasles::dense::prepare();
  benchmark::Initialize(&argc, argv);
  chasles::declare();
  benchmark::RunSpecifiedBenchmarks();
}
