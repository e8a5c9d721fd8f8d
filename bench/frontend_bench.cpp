// What a frame costs the image front end: 150 tracks on 752 x 480, mono and stereo, against plain
// pyramidal KLT of OpenCV (goodFeaturesToTrack where tracks are missing, 21 x 21, 4 levels, forward
// only, no prediction) on the same rendered images in the same run. One thread.

#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include <chasles/frontend/frontend_testing.hpp>

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

cv::Mat mat(const GrayImage& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

/// New corners away from the tracks, as many as are missing.
void refill(const cv::Mat& image, std::vector<cv::Point2f>& points) {
  if (points.size() >= kTracks) return;
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  for (const cv::Point2f& p : points) cv::circle(mask, p, 15, cv::Scalar(0), -1);
  std::vector<cv::Point2f> added;
  cv::goodFeaturesToTrack(image, added, kTracks - static_cast<int>(points.size()), 0.01, 15, mask);
  points.insert(points.end(), added.begin(), added.end());
}

/// Plain KLT: from frame to frame in camera 0, and from there to camera 1.
void plain(benchmark::State& state, bool stereo) {
  frames();
  cv::setNumThreads(1);
  double tracks = 0, n = 0;
  std::vector<uchar> found;
  std::vector<float> error;
  std::vector<cv::Point2f> now;
  for (auto _ : state) {
    std::vector<cv::Point2f> points;
    for (int k = 0; k < kFrames; ++k) {
      const cv::Mat image = mat(frames()[static_cast<std::size_t>(k)].images[0]);
      if (k > 0) {
        const cv::Mat last = mat(frames()[static_cast<std::size_t>(k - 1)].images[0]);
        cv::calcOpticalFlowPyrLK(last, image, points, now, found, error, cv::Size(21, 21), 3);
        std::vector<cv::Point2f> kept;
        for (std::size_t i = 0; i < now.size(); ++i) {
          if (found[i]) kept.push_back(now[i]);
        }
        points = kept;
        tracks += static_cast<double>(points.size());
        n += 1;
      }
      refill(image, points);
      if (stereo) {
        const cv::Mat other = mat(frames()[static_cast<std::size_t>(k)].images[1]);
        cv::calcOpticalFlowPyrLK(image, other, points, now, found, error, cv::Size(21, 21), 3);
        benchmark::DoNotOptimize(now);
      }
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
