// The processor time in which corners of calibration targets are found: images of 752 x 480 px
// through EuRoC's lens, with noise. `clutter` is a board before a wall of random squares, whose
// corners are candidates as well.

#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include <chasles/target/target_detector.hpp>
#include <chasles/target/target_testing.hpp>

namespace chasles {
namespace {

Target april_grid() {
  return {.kind = TargetKind::april_grid,
          .columns = 6,
          .rows = 6,
          .tag_size = 0.088,
          .tag_spacing = 0.3};
}

Target checkerboard() {
  return {.kind = TargetKind::checkerboard,
          .columns = 8,
          .rows = 7,
          .column_spacing = 0.06,
          .row_spacing = 0.06};
}

Target charuco() {
  return {.kind = TargetKind::charuco,
          .columns = 9,
          .rows = 8,
          .tag_size = 0.045,
          .column_spacing = 0.06,
          .row_spacing = 0.06,
          .dictionary = "DICT_5X5_100"};
}

Camera euroc_camera() {
  Camera camera;
  camera.width = 752, camera.height = 480;
  camera.fx = camera.fy = 458, camera.cx = 367, camera.cy = 248;
  camera.distortion = Distortion::kRadtan;
  camera.coefficients = {-0.2834, 0.07396, 0, 0};
  return camera;
}

void detect(benchmark::State& state, const Target& target, bool clutter) {
  const test::TargetRenderer renderer(target, euroc_camera());
  const GrayImage image =
      renderer.render(test::cam_T_target_of(target, {.distance = 1, .tilt = 0.3, .roll = 0.2}),
                      {.clutter = clutter});
  const TargetDetector detector(target);
  std::size_t corners = 0;
  for (auto _ : state) {
    const TargetDetection found = detector.detect(image);
    corners = found.view.ids.size();
  }
  state.counters["corners"] = static_cast<double>(corners);
}

void register_all() {
  const std::pair<std::string, Target> targets[] = {
      {"aprilgrid", april_grid()}, {"checkerboard", checkerboard()}, {"charuco", charuco()}};
  for (const auto& [name, target] : targets) {
    for (const bool clutter : {false, true}) {
      const auto run = [board = target, clutter](benchmark::State& state) {
        detect(state, board, clutter);
      };
      benchmark::RegisterBenchmark((name + (clutter ? "/clutter" : "/plain")).c_str(), run)
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  chasles::register_all();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
