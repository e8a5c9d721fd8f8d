// The time per frame: with a dense and with the compressed map, over the map's size; propagation
// and update over the number of landmarks in view; each error chart. Every figure is also given as
// a ratio to the first of its group, measured in the same run, because times depend on the machine
// and its load.

#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/velocity/body_velocity_model.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

namespace chasles {
namespace {

constexpr int kInView = 70;
const BodyVelocityModel kModel;
const StereoNoise kPixels{.u = 1, .v = 1, .disparity = 0.5};

StereoRig rig() {
  StereoRig rig{.fx = 700, .fy = 700, .cx = 600, .cy = 180, .baseline = 0.5, .cam0_T_imu = {}};
  rig.cam0_T_imu.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return rig;
}

// Points in front of a static camera: only the sizes of the matrices matter here.
StereoObservation observe(LandmarkId id) {
  const double disparity = 5 + static_cast<double>(id % 23);
  const double u = 100 + static_cast<double>((id * 37) % 1000);
  const double v = 20 + static_cast<double>((id * 17) % 320);
  return {.landmark = id, .pixels = {u, v, u - disparity, v}};
}

struct Drive {
  explicit Drive(const std::string& chart, Ekf::Map map, int in_view)
      : filter(error_chart(chart), initial(), covariance(), {.map = map}) {
    noise.walk.setConstant(0.1);
    noise.sample_sigma.setConstant(0.1);
    initialise(in_view);
  }

  static State initial() {
    State x;
    x.additive = Eigen::VectorXd::Zero(kModel.size());
    return x;
  }
  static Eigen::MatrixXd covariance() {
    return 0.01 * Eigen::MatrixXd::Identity(6 + kModel.size(), 6 + kModel.size());
  }
  void initialise(int count) {
    std::vector<NewLandmark> landmarks;
    for (int i = 0; i < count; ++i) {
      landmarks.push_back(
          *initialise_landmark(camera, kPixels, filter.state(), observe(next_id++)));
    }
    filter.add(landmarks);
  }
  void propagate() { filter.propagate(predict(kModel, filter.state(), {}, 0.1, noise)); }
  void update() {
    std::vector<Measurement> measurements;
    const auto& landmarks = filter.state().landmarks;
    for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
      const StereoObservation o = observe(landmarks[static_cast<std::size_t>(i)].id);
      if (auto z = measure_stereo(camera, StereoRows::kMean, kPixels, filter.state(), i, o)) {
        measurements.push_back(*z);
      }
    }
    filter.update(measurements);
  }
  // The oldest landmarks retire, and as many new ones are initialised.
  void exchange(int count) {
    std::vector<int> oldest;
    for (int i = 0; i < count; ++i) oldest.push_back(i);
    filter.retire(oldest);
    initialise(count);
  }
  void frame() {
    propagate();
    update();
    exchange(5);
  }

  StereoRig camera = rig();
  BodyVelocityNoise noise;
  LandmarkId next_id = 0;
  Ekf filter;
};

// A frame after the map has this number of landmarks. The dense filter reaches it without updates,
// which would take minutes; the time of a frame does not depend on the values.
void frame(benchmark::State& state, Ekf::Map map) {
  Drive drive("right-sen3", map, kInView);
  while (drive.filter.map_size() < state.range(0)) drive.exchange(kInView / 2);
  for (auto _ : state) drive.frame();
}

void chart(benchmark::State& state, const char* name) {
  Drive drive(name, Ekf::Map::kHistory, kInView);
  for (auto _ : state) drive.frame();
}

void propagate(benchmark::State& state) {
  Drive drive("right-sen3", Ekf::Map::kHistory, static_cast<int>(state.range(0)));
  for (auto _ : state) drive.propagate();
}

void update(benchmark::State& state) {
  Drive drive("right-sen3", Ekf::Map::kHistory, static_cast<int>(state.range(0)));
  for (auto _ : state) drive.update();
}

// The whole map, with its covariances, after this number of frames: time per frame so far.
void read_map(benchmark::State& state) {
  Drive drive("right-sen3", Ekf::Map::kHistory, kInView);
  for (int i = 0; i < state.range(0); ++i) drive.frame();
  for (auto _ : state) benchmark::DoNotOptimize(drive.filter.map());
  state.counters["ms_per_frame"] = benchmark::Counter(
      static_cast<double>(state.range(0)) * 1e-3,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

// Prints each time also as a ratio to the first of its group (the name before the first '/').
class Ratios : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      const std::string name = run.benchmark_name();
      const double time = run.GetAdjustedCPUTime();
      const double first = first_.try_emplace(name.substr(0, name.find('/')), time).first->second;
      std::printf("    ratio %.2f\n", time / first);
    }
  }

 private:
  std::map<std::string, double> first_;
};

void declare() {
  const auto add = [](const std::string& name, auto function) {
    return benchmark::RegisterBenchmark(name.c_str(), function)->Unit(benchmark::kMillisecond);
  };
  for (const Ekf::Map map : {Ekf::Map::kHistory, Ekf::Map::kDense}) {
    const bool compress = map == Ekf::Map::kHistory;
    add(compress ? "compressed" : "dense", [map](benchmark::State& state) { frame(state, map); })
        ->Arg(500)
        ->Arg(1000)
        ->Arg(2000)
        ->Arg(5000)
        ->Iterations(compress ? 100 : 3);
  }
  for (const ErrorChart& c : error_charts()) {
    const char* name = c.name.data();
    add(std::string("chart/") + name, [name](benchmark::State& state) {
      chart(state, name);
    })->Iterations(300);
  }
  add("propagate", propagate)->Arg(35)->Arg(70)->Arg(140)->Iterations(300);
  add("update", update)->Arg(35)->Arg(70)->Arg(140)->Iterations(200);
  add("map", read_map)->Arg(100)->Arg(400)->Iterations(3);
}

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  chasles::dense::prepare();
  benchmark::Initialize(&argc, argv);
  chasles::declare();
  chasles::Ratios reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
}
