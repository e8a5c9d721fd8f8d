#include <chasles/calibration/calibration.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/recording/testing.hpp>

#include "kinds.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

// A camera with a lens of each model, every second one with a rolling shutter.
std::string rig_seed(const fs::path& scratch) {
  FolderCalibration rig{.name = "rig", .imu_convention = ImuConvention::kIntervalMean};
  for (const test::Lens& lens : test::lenses()) {
    if (!rig.cameras.empty() && rig.cameras.back().distortion == lens.camera.distortion) continue;
    Camera camera = lens.camera;
    camera.width = 640;
    camera.height = 480;
    if (rig.cameras.size() % 2 == 0) {
      camera.shutter = {.readout = 0.02, .direction = ReadoutDirection::kUp};
    }
    rig.cameras.push_back(camera);
  }
  write_calibration(rig, scratch / "rig.yaml");
  return test::slurp(scratch / "rig.yaml");
}

// A lens that was read can be used: everything it gives is finite.
void use_lens(const Camera& camera) {
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      const Eigen::Vector2d pixel(camera.width * i / 7.0, camera.height * j / 7.0);
      const auto seen = bearing(camera, pixel);
      if (!seen) continue;
      const auto again = project(camera, seen->bearing);
      const auto d = parameter_derivative(camera, seen->bearing);
      if (!seen->bearing.allFinite() || (again && !again->pixel.allFinite()) ||
          (d && !d->allFinite())) {
        throw std::logic_error("a lens that is not finite");
      }
    }
  }
}

void read_rig(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "rig.yaml", std::string(bytes));
  for (const Camera& camera : read_calibration(scratch / "rig.yaml").cameras) use_lens(camera);
}

}  // namespace

std::vector<Kind> rig_kinds() { return {{"rig", rig_seed, read_rig}}; }

}  // namespace chasles::fuzz
