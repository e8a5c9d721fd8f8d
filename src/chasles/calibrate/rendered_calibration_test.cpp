#include <cstdlib>
#include <map>
#include <string>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/base/in_parallel.hpp>
#include <chasles/calibrate/inertial_testing.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/target/target_detector.hpp>
#include <chasles/target/target_testing.hpp>

// Calibrations by rendered images of a board, from nothing. CHASLES_RUNS=100 has so many runs, and
// prints the table of docs/calibration.md.
namespace chasles::test {
namespace {

std::uint64_t runs(std::uint64_t few) {
  const char* const many = std::getenv("CHASLES_RUNS");
  return many != nullptr ? std::strtoull(many, nullptr, 10) : few;
}

std::string group_of(const std::string& parameter) {
  const auto has = [&](const char* part) { return parameter.find(part) != std::string::npos; };
  if (has(".fx") || has(".fy")) return "focal lengths";
  if (has(".cx") || has(".cy")) return "principal points";
  if (has("rotation")) return "rotations";
  if (has("position")) return "positions";
  if (has("offset")) return "time offsets";
  if (has("readout")) return "readout times";
  if (has("gravity")) return "gravity";
  if (has("target")) return "shape of the target";
  if (has("scale") || has("misalignment")) return "scales and axes of the IMU";
  return "lens coefficients";
}

// Of groups of parameters.
class Scores {
 public:
  void add(const ErrorsOfRun& run, const std::vector<std::string>& names) {
    std::map<std::string, std::vector<int>> groups;
    for (int i = 0; i < run.errors.size(); ++i) {
      groups[group_of(names[static_cast<std::size_t>(i)])].push_back(i);
      groups["all"].push_back(i);
    }
    for (const auto& [group, rows] : groups) {
      const Eigen::VectorXd errors = run.errors(rows);
      const Eigen::MatrixXd covariance = run.covariance(rows, rows);
      Score& score = scores_[group];
      score.nees += errors.dot(covariance.ldlt().solve(errors));
      score.rows += static_cast<double>(rows.size());
      const Eigen::ArrayXd sigmas = covariance.diagonal().cwiseSqrt();
      score.within += static_cast<double>((errors.array().abs() <= 3 * sigmas).count());
    }
  }
  void add_projection(const Camera& found, const Camera& truth, const Eigen::MatrixXd& covariance) {
    for (const PixelUncertainty& one : projection_uncertainty(found, covariance)) {
      expected_ += one.sigma_px * one.sigma_px;
    }
    for (const PixelDifference& one : projection_difference(found, truth)) {
      pixels_ += one.difference.squaredNorm() / 2;
    }
  }

  double nees() const { return scores_.at("all").nees / scores_.at("all").rows; }
  double within() const { return scores_.at("all").within / scores_.at("all").rows; }
  double projection() const { return pixels_ / expected_; }
  void print(const std::string& what) const {
    fmt::print("{}: projection's squares over their variance {:.2f}\n", what, projection());
    for (const auto& [group, score] : scores_) {
      fmt::print("  {:<28}{:>6} NEES {:5.2f}, within 3 sigma {:5.1f} %\n", group, score.rows,
                 score.nees / score.rows, 100 * score.within / score.rows);
    }
  }

 private:
  struct Score {
    double nees = 0, rows = 0, within = 0;
  };
  std::map<std::string, Score> scores_;
  double pixels_ = 0, expected_ = 0;
};

// Those of a board, at the time of each row.
struct Shot {
  Time time{};
  int camera = 0;
  std::function<SE3(double row)> cam_T_target_at;
};

std::vector<TargetView> photographed(const std::vector<Camera>& cameras,
                                     const std::vector<Shot>& shots, std::uint64_t seed) {
  const TargetDetector detector(april_board());
  std::vector<TargetRenderer> renderers;
  for (const Camera& camera : cameras) renderers.emplace_back(april_board(), camera);
  std::vector<TargetView> views(shots.size());
  in_parallel(shots.size(), 2, [&](std::size_t i) {
    const Shot& shot = shots[i];
    const Photograph how{.blur = 0.5 + 0.2 * static_cast<double>(i % 4),
                         .light = {0.2, -0.1},
                         .seed = 1000 * seed + i};
    views[i] = detector
                   .detect(renderers[static_cast<std::size_t>(shot.camera)].render(
                       shot.cam_T_target_at, how))
                   .view;
    views[i].time = shot.time;
    views[i].camera = shot.camera;
  });
  std::erase_if(views, [](const TargetView& view) { return view.ids.empty(); });
  return views;
}

CamerasInput photographed_rig(const std::vector<Camera>& cameras, std::size_t instants,
                              std::uint64_t seed) {
  const BoardScene scene{.cameras = cameras, .instants = instants};
  CamerasInput input = board_views({.cameras = cameras, .instants = 1}, seed);
  const std::vector<SE3> poses = board_poses(scene, seed);
  std::vector<Shot> shots;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const SE3 cam_T_target = cameras[c].cam_T_imu * poses[k];
      shots.push_back({std::chrono::seconds(2 * k), static_cast<int>(c),
                       [cam_T_target](double) { return cam_T_target; }});
    }
  }
  input.views = photographed(cameras, shots, seed);
  return input;
}

void calibrate(const std::vector<Camera>& truth, std::size_t instants, std::uint64_t seed,
               Scores& scores) {
  const CamerasCalibration found = calibrate_cameras(photographed_rig(truth, instants, seed));
  const CamerasLayout layout = found.layout();
  for (std::size_t c = 0; c < truth.size(); ++c) {
    scores.add_projection(found.cameras[c], truth[c], lens_covariance(found, c));
  }
  if (has_twin(truth[0])) return;
  scores.add(
      in_search_coordinates({calibration_errors(found, truth), found.covariance}, found.cameras,
                            truth, [&](std::size_t c) { return layout.lens_row(c); }),
      layout.names());
}

TEST(RenderedCalibration, OfOneCameraIsWrongByAsMuchAsItSays) {
  Scores scores;
  const std::vector<Lens> all = lenses();
  for (std::uint64_t run = 0; run < runs(2); ++run) {
    calibrate({all[(1 + 4 * run) % all.size()].camera}, 40, run, scores);
  }
  scores.print("one camera");
  EXPECT_LT(scores.nees(), 3);
  EXPECT_GE(scores.within(), 0.97);
  EXPECT_LT(scores.projection(), 1.5);
}

TEST(RenderedCalibration, OfARigIsWrongByAsMuchAsItSays) {
  Scores scores;
  for (std::uint64_t run = 0; 3 * run < runs(3); ++run) {
    calibrate(rig(2 + run % 3), 40, run, scores);
  }
  scores.print("rigs");
  EXPECT_LT(scores.nees(), 3);
  EXPECT_GE(scores.within(), 0.97);
}

TEST(RenderedCalibration, WithAnImuAndARollingShutterIsWrongByAsMuchAsItSays) {
  Scores scores;
  for (std::uint64_t run = 0; 10 * run < runs(10); ++run) {
    BoardRigScene scene{.cameras = mounted(1, 0.02), .time_offset = 0.03, .seconds = 10};
    scene.imu.force.diagonal() << 0.004, -0.003, 0.002;
    InertialCalibrationInput input = inertial_views(scene, run);
    const BoardMotion motion(scene.turning);
    std::vector<Shot> shots;
    for (double t = 1; t < scene.seconds + 1; t += 0.1) {
      const Camera& camera = scene.cameras[0];
      shots.push_back({from_seconds(t - scene.time_offset), 0, [&, t](double row) {
                         const double delay = line_delay(camera, Eigen::Vector2d(0, row));
                         return camera.cam_T_imu * motion.target_T_imu(t + delay).inverse();
                       }});
    }
    input.cameras.views = photographed(scene.cameras, shots, run);
    const InertialCalibration found = calibrate_inertial(input);
    scores.add({inertial_errors(found, scene), found.covariance}, found.names);
  }
  scores.print("camera and IMU");
  EXPECT_LT(scores.nees(), 3);
  EXPECT_GE(scores.within(), 0.95);
}

}  // namespace
}  // namespace chasles::test
