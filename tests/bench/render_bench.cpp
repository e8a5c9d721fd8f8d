// The time of rendered images, 752 x 480 through EuRoC's lens: the light of one image of each
// scene, frames of the walk with noise, mono and stereo, and the painting of its walls. `x_20_Hz`
// is the factor by which a frame is faster than 20 Hz.

#include <string>

#include <benchmark/benchmark.h>

#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render.hpp>
#include <chasles/sim/render_images.hpp>

namespace chasles {
namespace {

InertialScene with_euroc_camera(const std::string& name, int cameras) {
  InertialScene scene = inertial_scene(name);
  InertialSettings& s = scene.settings;
  s.cameras = cameras;
  s.baseline = 0.11;
  s.image_width = 752;
  s.image_height = 480;
  s.focal_length = 458;
  s.center_u = 367;
  s.center_v = 248;
  s.distortion = Distortion::kRadtan;
  s.distortion_1 = -0.2834;
  s.distortion_2 = 0.07396;
  return scene;
}

void set_rate(benchmark::State& state, double images) {
  state.counters["x_20_Hz"] =
      benchmark::Counter(images / 20, benchmark::Counter::kIsIterationInvariantRate);
}

// Light only, with views spread over the path.
void light(benchmark::State& state, const std::string& name) {
  const InertialScene scene = with_euroc_camera(name, 1);
  const Spline motion = inertial_motion(scene);
  const Camera camera = simulate_sensors(scene, motion, 0).cameras.front();
  const PaintedWorld world = paint_world(make_render_world(scene.settings, motion), 0.005, 1);
  const RayTable rays = make_rays(camera);
  std::vector<float> image;
  double time = 0;
  for (auto _ : state) {
    render(world, rays, motion_at(motion, time).world_T_imu * camera.cam_T_imu.inverse(), image);
    benchmark::DoNotOptimize(image.data());
    time += 0.37;
    if (time > motion.duration) time = 0;
  }
  set_rate(state, 1);
}

// Frames as a reader gives them, with noise.
void frame(benchmark::State& state, const std::string& name, int cameras) {
  const Recording recording = render_inertial(with_euroc_camera(name, cameras));
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(recording.images->read(i));
    i = (i + 7) % recording.images->size();
  }
  set_rate(state, 1);
}

void paint(benchmark::State& state) {
  const InertialScene scene = with_euroc_camera("walk", 1);
  const RenderWorld world = make_render_world(scene.settings, {});
  for (auto _ : state) benchmark::DoNotOptimize(paint_world(world, 0.005, 1));
}

void declare() {
  using benchmark::State;
  const auto add = [](const std::string& name, auto run) {
    benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond);
  };
  for (const std::string name : {"hallway", "turntable", "walk"}) {
    add("light/" + name, [name](State& state) { light(state, name); });
  }
  add("frame/walk/mono", [](State& state) { frame(state, "walk", 1); });
  add("frame/walk/stereo", [](State& state) { frame(state, "walk", 2); });
  add("paint/walk", paint);
}

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  chasles::declare();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
