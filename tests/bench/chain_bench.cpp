// The processor time per frame from pixels to the estimate, on one thread: front end and filter
// with 150 tracks, 50 landmarks and 10 clones on images of 752 x 480 px in memory, mono and stereo.
// The references are plain KLT of OpenCV on the same images in the same run, and reading them from
// their files (PNG). The images are those of EuRoC's MH_01 if available ($CHASLES_DATA,
// ../shared/data), else rendered ones, which have no files.
//
// A frame's work is the same in every repetition, so its time is the minimum over the repetitions:
// this excludes other load on the machine. Frames up to the initialisation are excluded as well.
// `chain_bench --slow` lists the slowest frames with their work.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <vector>

#include <opencv2/core/utility.hpp>

#include <chasles/recording/readers.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render_images.hpp>

#include "chain.hpp"
#include "plain_klt.hpp"

namespace chasles {
namespace {

constexpr int kRepetitions = 7;
constexpr int kTracks = 150;

using bench::chain;
using bench::Cost;
using bench::cpu_ms;
using bench::keep_least;

struct Footage : bench::Footage {
  bool real = false;  // from files
};

InertialRunSettings few_landmarks() {
  InertialRunSettings settings;
  settings.filter.max_landmarks = 50;
  settings.filter.clones = 10;
  settings.frontend.max_tracks = kTracks;
  return settings;
}

Recording rendered() {
  InertialScene scene = inertial_scene("walk");
  InertialSettings& s = scene.settings;
  s.cameras = 2;
  s.baseline = 0.11;
  s.image_width = 752;
  s.image_height = 480;
  s.focal_length = 458;
  s.center_u = 367;
  s.center_v = 248;
  s.frame_rate = 20;
  s.walk_duration = 20;
  return render_inertial(scene);
}

Footage footage() {
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path data = given ? given : CHASLES_SOURCE_DIR "/../shared/data";
  const auto euroc = data / "euroc/MH_01_easy_17s";
  const bool real = std::filesystem::exists(euroc);
  std::printf("%s images\n", real ? "MH_01's" : "rendered");
  return {bench::footage_of(real ? read_recording(euroc) : rendered()), real};
}

/// The mean over the same number of frames at the end.
std::vector<double> plain(const Footage& m, bool stereo, std::size_t count) {
  bench::PlainKlt klt(kTracks);
  std::vector<double> costs;
  for (const ImageFrame& frame : m.frames) {
    const double before = cpu_ms();
    klt.process(frame.images[0], stereo ? &frame.images[1] : nullptr);
    costs.push_back(cpu_ms() - before);
  }
  costs.erase(costs.begin(), costs.end() - static_cast<long>(count));
  return costs;
}

/// Reading the images from their files, likewise.
std::vector<double> reading(const Footage& m, std::size_t cameras, std::size_t count) {
  std::vector<double> costs;
  for (std::size_t i = m.frames.size() - count; i < m.frames.size(); ++i) {
    const double before = cpu_ms();
    m.recording.images->read_cameras(i, cameras);
    costs.push_back(cpu_ms() - before);
  }
  return costs;
}

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

double p99(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(0.99 * static_cast<double>(v.size() - 1))];
}

/// The means of the references [ms].
struct Yardsticks {
  double klt = 0, reading = 0;
};

void print(const char* name, const std::vector<double>& ms, const Yardsticks& yardsticks) {
  std::printf("  %-10s mean %6.3f ms  p99 %6.3f ms  p99/mean %4.2f  ratio to plain KLT %.2f", name,
              mean(ms), p99(ms), p99(ms) / mean(ms), mean(ms) / yardsticks.klt);
  if (yardsticks.reading > 0) std::printf("  to reading %.2f", mean(ms) / yardsticks.reading);
  std::puts("");
}

void print_slow(std::vector<Cost> costs) {
  std::sort(costs.begin(), costs.end(),
            [](const Cost& a, const Cost& b) { return a.all() > b.all(); });
  std::puts(
      "      ms  front end: tracked, added    filter: pixels used, landmarks initialised, in the "
      "state");
  for (std::size_t i = 0; i < 8 && i < costs.size(); ++i) {
    const Estimate& e = costs[i].estimate;
    std::printf("  %6.2f  %9.2f: %4d, %3d     %12.2f: %3d, %2d, %2d\n", costs[i].all(),
                costs[i].frontend, costs[i].report.tracked, costs[i].report.added, costs[i].filter,
                e.used, e.added, e.in_state);
  }
}

/// The minimum of the repetitions, frame by frame.
void keep_least(const std::vector<double>& more, std::vector<double>& least) {
  if (least.empty()) least = more;
  for (std::size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], more[i]);
}

void measure(const Footage& m, bool stereo, bool slow) {
  std::vector<Cost> costs;
  std::vector<double> klt, files;
  for (int i = 0; i < kRepetitions; ++i) {
    keep_least(chain(m, stereo ? 2 : 1, few_landmarks()), costs);
    keep_least(plain(m, stereo, costs.size()), klt);
    if (m.real) keep_least(reading(m, stereo ? 2 : 1, costs.size()), files);
  }
  std::vector<double> frontend, filter, both;
  double pixels = 0, landmarks = 0;
  for (const Cost& c : costs) {
    frontend.push_back(c.frontend);
    filter.push_back(c.filter);
    both.push_back(c.all());
    pixels += c.report.tracked;
    landmarks += c.estimate.in_state;
  }
  const auto n = static_cast<double>(costs.size());
  std::printf("%s: %zu frames, %.0f tracks, %.0f landmarks in the state on average\n",
              stereo ? "stereo" : "mono", costs.size(), pixels / n, landmarks / n);
  const Yardsticks yardsticks{.klt = mean(klt), .reading = files.empty() ? 0 : mean(files)};
  print("plain KLT", klt, yardsticks);
  if (!files.empty()) print("reading", files, yardsticks);
  print("front end", frontend, yardsticks);
  print("filter", filter, yardsticks);
  print("both", both, yardsticks);
  if (slow) print_slow(costs);
}

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  double load[1] = {};
  const chasles::Footage m = chasles::footage();
  ::getloadavg(load, 1);
  std::printf("load of the machine %.1f; minimum of %d repetitions\n", load[0],
              chasles::kRepetitions);
  const bool slow = argc > 1 && std::strcmp(argv[1], "--slow") == 0;
  for (const bool stereo : {false, true}) chasles::measure(m, stereo, slow);
}
