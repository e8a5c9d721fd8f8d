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

// Walks around a corner, with a lens that has the pinhole's focal length at its axis.
LensResult walks_with(const Camera& lens) {
  LensResult result;
  for (std::uint64_t i = 0; i < kLensRuns; ++i) {
    InertialScene scene = inertial_scene("hallway");
    InertialSettings& s = scene.settings;
    s.hall_length = s.hall_width = 8;
    s.sections = 1;
    s.frame_rate = 10;
    s.seed = 500 + i;
    scene.cameras = make_cameras(s);
    Camera& camera = scene.cameras.front();
    camera.distortion = lens.distortion;
    camera.coefficients = lens.coefficients;
    camera.fx = camera.fy = s.focal_length * s.focal_length / focal_lengths_at_axis(camera).x();
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

}  // namespace
}  // namespace chasles
