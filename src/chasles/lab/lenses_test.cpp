#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <chasles/camera/camera_testing.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_world.hpp>

namespace chasles {
namespace {

constexpr int kLensRuns = 8;

struct LensResult {
  double ate = 0, nees = 0, nis_per_dof = 0;  // means of the runs; NEES at the end
};

// Walks around a corner, with landmarks from `min_range` on. `fit`: makes the camera.
template <typename Fit>
LensResult walks_of(double min_range, const Fit& fit) {
  LensResult result;
  for (std::uint64_t i = 0; i < kLensRuns; ++i) {
    InertialScene scene = inertial_scene("hallway");
    InertialSettings& s = scene.settings;
    s.hall_length = s.hall_width = 8;
    s.sections = 1;
    s.frame_rate = 10;
    s.seed = 500 + i;
    s.min_range = min_range;
    scene.cameras = make_cameras(s);
    fit(scene.cameras.front());
    const Recording recording = simulate_inertial(scene);
    const FilterVariant filter{.name = "own", .settings = {}};
    const Trial trial = run_trial(filter, recording, draw_start(recording, filter.settings, 3, i));
    EXPECT_FALSE(trial.diverged);
    const TrialAverages average = averages(trial);
    result.ate += average.ate_posyaw / kLensRuns;
    result.nees += trial.points.back().nees_pose / kLensRuns;
    result.nis_per_dof += average.nis_per_dof / kLensRuns;
  }
  return result;
}

// With a lens that has the pinhole's focal length at its axis.
LensResult walks_with(const Camera& lens) {
  return walks_of(inertial_scene("hallway").settings.min_range, [&](Camera& camera) {
    const double pinhole = camera.fx;
    camera.distortion = lens.distortion;
    camera.coefficients = lens.coefficients;
    camera.fx = camera.fy = pinhole * pinhole / focal_lengths_at_axis(camera).x();
  });
}

TEST(Lenses, AWalkWithEachIsAsAccurateAndConsistentAsWithAPinhole) {
  const LensResult pinhole = walks_with(test::pinhole_camera());
  for (const test::Lens& lens : test::lenses()) {
    const LensResult with = walks_with(lens.camera);
    const std::string name(name_of(lens.camera.distortion));
    EXPECT_TRUE(chi2_band(6, kLensRuns, 0.999).contains(with.nees)) << name << " " << with.nees;
    EXPECT_NEAR(with.nis_per_dof, pinhole.nis_per_dof, 0.1) << name;
    EXPECT_LT(with.ate, 1.1 * pinhole.ate) << name;
  }
}

// 95 degrees to each side, and up to 134 in the corners of the image. A pixel is 2.5 times the
// pinhole's angle.
TEST(Lenses, AWalkWithAFisheyeOf190DegreesIsConsistent) {
  const double near = 0.8;
  const LensResult pinhole = walks_of(near, [](Camera&) {});
  const auto wide = [](Distortion model, LensCoefficients k, double focal) {
    return [=](Camera& camera) {
      camera.width = camera.height = 640;
      camera.cx = camera.cy = 319.5;
      camera.fx = camera.fy = focal;
      camera.distortion = model;
      camera.coefficients = k;
    };
  };
  for (const LensResult& fisheye :
       {walks_of(near, wide(Distortion::kEquidistant, {0, 0, 0, 0}, 193)),
        walks_of(near, wide(Distortion::kDoubleSphere, {-0.2, 0.6}, 163))}) {
    EXPECT_TRUE(chi2_band(6, kLensRuns, 0.999).contains(fisheye.nees)) << fisheye.nees;
    EXPECT_NEAR(fisheye.nis_per_dof, 1, 0.1);
    EXPECT_LT(fisheye.ate, 2 * pinhole.ate);
  }
}

}  // namespace
}  // namespace chasles
