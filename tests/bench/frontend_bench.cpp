// The processor time per frame of the image front end: 150 tracks on 752 x 480, mono and stereo.
// The reference is plain pyramidal KLT of OpenCV (goodFeaturesToTrack where tracks are missing, 21
// x 21, 4 levels, forward only, no prediction) on the same rendered images in the same run. One
// thread.

#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include <chasles/frontend/frontend_testing.hpp>

#include "plain_klt.hpp"

namespace chasles {
namespace {

constexpr int kFrames = 60;
constexpr int kTracks = 150;

const std::vector<Camera>& rig() {
  static const std::vector<Camera> cameras = test::euroc_rig();
  return cameras;
}

const std::vector<ImageFrame>& frames() {
  static const std::vector<ImageFrame> rendered = [] {
    std::vector<ImageFrame> result;
    for (int k = 0; k < kFrames; ++k) {
      result.push_back(
          test::render_frame(test::room(), rig(), test::walk_pose(k), from_seconds(1 + 0.05 * k)));
    }
    return result;
  }();
  return rendered;
}

/// s_frame: processor time of a frame; ms_...: of its stages, the first frame left out.
void ours(benchmark::State& state, std::size_t cameras, bool gyroscope) {
  const std::vector<Camera> used(rig().begin(),
                                 rig().begin() + static_cast<std::ptrdiff_t>(cameras));
  std::vector<ImageFrame> images = frames();
  for (ImageFrame& frame : images) frame.images.resize(cameras);
  double tracks = 0, age = 0, matched = 0, pyramid = 0, follow = 0, outliers = 0, corners = 0,
         stereo = 0, n = 0;
  for (auto _ : state) {
    Frontend frontend({.max_tracks = kTracks}, used);
    for (int k = 0; k < kFrames; ++k) {
      const RotationPrior prior = gyroscope && k > 0
                                      ? test::gyroscope(test::walk_pose(k - 1), test::walk_pose(k))
                                      : RotationPrior{};
      benchmark::DoNotOptimize(frontend.process(images[static_cast<std::size_t>(k)], prior));
      const FrontendReport& r = frontend.report();
      if (k == 0) continue;
      n += 1;
      tracks += r.tracked;
      matched += r.stereo_matched;
      age += r.mean_age;
      pyramid += r.pyramid_seconds;
      follow += r.follow_seconds;
      outliers += r.outlier_seconds;
      corners += r.corner_seconds;
      stereo += r.stereo_seconds;
    }
  }
  state.counters["tracked"] = tracks / n;
  state.counters["age"] = age / n;
  state.counters["matched"] = matched / n;
  state.counters["ms_pyramid"] = 1e3 * pyramid / n;
  state.counters["ms_follow"] = 1e3 * follow / n;
  state.counters["ms_outliers"] = 1e3 * outliers / n;
  state.counters["ms_corners"] = 1e3 * corners / n;
  state.counters["ms_stereo"] = 1e3 * stereo / n;
  state.counters["s_frame"] = benchmark::Counter(
      kFrames, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void plain(benchmark::State& state, bool stereo) {
  frames();
  cv::setNumThreads(1);
  double tracks = 0, n = 0;
  for (auto _ : state) {
    bench::PlainKlt klt(kTracks);
    for (int k = 0; k < kFrames; ++k) {
      const ImageFrame& frame = frames()[static_cast<std::size_t>(k)];
      klt.process(frame.images[0], stereo ? &frame.images[1] : nullptr);
      if (k == 0) continue;
      tracks += static_cast<double>(klt.tracked());
      n += 1;
    }
  }
  state.counters["tracked"] = tracks / n;
  state.counters["s_frame"] = benchmark::Counter(
      kFrames, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(ours, mono, 1, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, mono_without_gyroscope, 1, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain, mono, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, stereo, 2, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain, stereo, true)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace chasles

BENCHMARK_MAIN();
