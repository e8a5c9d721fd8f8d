// Stereo matching on EuRoC's V1_01. The reference for each corner comes from a third image, some
// tenths of a second later, and the true motion. studies/frontend.md has the figures.

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>

#include <gtest/gtest.h>

#include <chasles/codec/image_decode.hpp>
#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/frontend_testing.hpp>
#include <chasles/frontend/stereo_match.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

/// One frame of the recording of single image pairs.
struct Pair {
  Time time{};
  SE3 world_T_imu;
  std::array<fs::path, 2> files;
};

std::vector<Pair> pairs_with_truth(const fs::path& euroc) {
  const Recording flight = read_recording(euroc / "imu_gt/V1_01_easy_imu.csv.gz");
  std::vector<Pair> pairs;
  for (const auto& entry : fs::directory_iterator(euroc / "V1_01_easy_sparse_stereo")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with("_0.jpg")) continue;
    const Time time(std::stoll(name));
    const auto pose = std::ranges::lower_bound(flight.truth, time, {}, &StampedPose::time);
    if (pose == flight.truth.end() || pose->time - time > std::chrono::milliseconds(5)) continue;
    std::string other = entry.path().string();
    other.replace(other.size() - 5, 1, "1");
    pairs.push_back({time, pose->pose, {entry.path(), other}});
  }
  std::ranges::sort(pairs, {}, &Pair::time);
  return pairs;
}

ImagePyramid pyramid_of(const fs::path& file) {
  ImagePyramid pyramid;
  build_pyramid(read_image(file, {752, 480}), Equalisation::kNone, 4, pyramid);
  return pyramid;
}

struct Score {
  int pairs = 0, visible = 0, matched = 0;
  std::vector<double> errors;  ///< of visible and matched corners [px]

  double within(double pixels) const {
    const auto right = std::ranges::count_if(errors, [&](double e) { return e < pixels; });
    return static_cast<double>(right) / static_cast<double>(errors.size());
  }
};

/// The corners of a pair's first image that the later first image shows as well. The true motion
/// gives their position in space, and thus their pixel in the pair's other image.
void compare(const Pair& pair, const Pair& later, const std::vector<Camera>& rig, Score& score) {
  Camera third = rig[0];
  third.cam_T_imu = rig[0].cam_T_imu * later.world_T_imu.inverse() * pair.world_T_imu;
  const ImagePyramid first = pyramid_of(pair.files[0]), other = pyramid_of(pair.files[1]);
  const ImagePyramid third_image = pyramid_of(later.files[0]);
  const StereoViews stereo(rig[0], first, rig[1], other);
  const StereoViews in_time(rig[0], first, third, third_image);
  Coverage coverage({.border = 20}, rig[0].width, rig[0].height);
  ++score.pairs;
  for (const Eigen::Vector2d& pixel : coverage.refill(first, {}, {})) {
    const auto ray = wide_ray(rig[0], pixel);
    const auto known = match_stereo(in_time, {pixel, *ray}, {});
    if (!known || known->inverse_depth < 0.05) continue;
    const Eigen::Vector3d p_cam0 = ray->ray / ray->ray.z() / known->inverse_depth;
    const auto expected = project(rig[1], stereo.other_T_first * p_cam0);
    if (!expected || !in_image(rig[1], expected->pixel, 20)) continue;
    ++score.visible;
    const auto match = match_stereo(stereo, {pixel, *ray}, {});
    if (!match) continue;
    ++score.matched;
    score.errors.push_back((match->pixel - expected->pixel).norm());
  }
}

TEST(ViconRoom, StereoMatchesAgreeWithAThirdViewAndTheTrueMotion) {
  const auto folder = test::euroc_folder();
  if (!folder) GTEST_SKIP() << "no recordings";
  const std::vector<Camera> rig = test::euroc_rig();
  const std::vector<Pair> pairs = pairs_with_truth(*folder);
  Score score;
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    const Pair &pair = pairs[i], &later = pairs[i + 1];
    const double way = (later.world_T_imu.p - pair.world_T_imu.p).norm();
    // As far as the rig's baseline of 0.11 m, or several times that.
    if (later.time - pair.time > std::chrono::seconds(1) || way < 0.08 || way > 0.5) continue;
    compare(pair, later, rig, score);
  }
  ASSERT_GT(score.visible, 500);
  std::ranges::sort(score.errors);
  std::cout << score.pairs << " pairs: of " << score.visible << " corners with a known place "
            << score.matched << " matched, within 4 px " << score.within(4) << ", within 2 px "
            << score.within(2) << ", median " << score.errors[score.errors.size() / 2] << " px\n";
  EXPECT_GT(score.matched, 0.92 * score.visible);
  EXPECT_GT(score.within(4), 0.97);
  EXPECT_GT(score.within(2), 0.94);
  EXPECT_LT(score.errors[score.errors.size() / 2], 0.6);
}

}  // namespace
}  // namespace chasles
