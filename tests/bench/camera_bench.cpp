// What cameras cost: rigs of 1 to 4 cameras, a rolling shutter, and a calibration in the state,
// with rendered images of 640 x 480 px in memory and one thread. Each time is a processor time per
// frame after the initialisation, the minimum of the repetitions, with its ratio to the first row
// of its table in the same run.

#include <cstdio>
#include <string>

#include <opencv2/core/utility.hpp>

#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render_images.hpp>

#include "chain.hpp"

namespace chasles {
namespace {

using bench::Cost;

constexpr int kRepetitions = 5;

bench::Footage walk(int cameras, double readout) {
  InertialScene scene = inertial_scene("walk");
  InertialSettings& s = scene.settings;
  s.cameras = cameras;
  s.rig = RigLayout::kRing;
  s.image_width = 640;
  s.image_height = 480;
  s.focal_length = 320;
  s.center_u = 319.5;
  s.center_v = 239.5;
  s.frame_rate = 10;
  s.walk_duration = 12;
  s.readout_time = readout;
  return bench::footage_of(render_inertial(scene));
}

struct Mean {
  double frontend = 0, filter = 0, tracks = 0;
  double all() const { return frontend + filter; }
};

Mean mean_of(const bench::Footage& footage, std::size_t cameras,
             const InertialRunSettings& settings) {
  std::vector<Cost> costs;
  for (int i = 0; i < kRepetitions; ++i) {
    bench::keep_least(bench::chain(footage, cameras, settings), costs);
  }
  Mean mean;
  const auto n = static_cast<double>(costs.size());
  for (const Cost& c : costs) {
    mean.frontend += c.frontend / n;
    mean.filter += c.filter / n;
    mean.tracks += c.report.tracked / n;
  }
  return mean;
}

// A row, with its ratios to the first one, which it becomes where there is none.
void print(const std::string& name, const Mean& mean, std::optional<Mean>& first) {
  if (!first) first = mean;
  std::printf(
      "  %-24s %4.0f tracks  front end %6.3f ms (%4.2f)  filter %6.3f ms (%4.2f)  both (%4.2f)\n",
      name.c_str(), mean.tracks, mean.frontend, mean.frontend / first->frontend, mean.filter,
      mean.filter / first->filter, mean.all() / first->all());
}

void measure() {
  const bench::Footage ring = walk(4, 0), rolling = walk(1, 0.02);
  std::optional<Mean> one, global, known;
  for (const std::size_t cameras : {1, 2, 3, 4}) {
    print(std::to_string(cameras) + " of a ring", mean_of(ring, cameras, {}), one);
  }
  print("global shutter", mean_of(walk(1, 0), 1, {}), global);
  print("rolling shutter, 20 ms", mean_of(rolling, 1, {}), global);
  for (const Calibrate calibrate : {Calibrate::kFalse, Calibrate::kConsidered, Calibrate::kTrue}) {
    InertialRunSettings settings;
    settings.filter.calibrate_extrinsics = settings.filter.calibrate_intrinsics =
        settings.filter.calibrate_readout = calibrate;
    print("calibration: " + std::string(name_of(calibrate)), mean_of(rolling, 1, settings), known);
  }
}

}  // namespace
}  // namespace chasles

int main() {
  cv::setNumThreads(1);
  chasles::measure();
}
