#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <chasles/base/error.hpp>
#include <chasles/target/target_detector.hpp>
#include <chasles/target/target_testing.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using test::Photograph;
using test::TargetRenderer;
using test::Viewpoint;

const Target kAprilGrid{
    .kind = TargetKind::april_grid, .columns = 6, .rows = 6, .tag_size = 0.088, .tag_spacing = 0.3};
const Target kCheckerboard{.kind = TargetKind::checkerboard,
                           .columns = 8,
                           .rows = 7,
                           .column_spacing = 0.06,
                           .row_spacing = 0.06};
const Target kCharuco{.kind = TargetKind::charuco,
                      .columns = 9,
                      .rows = 8,
                      .tag_size = 0.045,
                      .column_spacing = 0.06,
                      .row_spacing = 0.06,
                      .dictionary = "DICT_5X5_100",
                      .legacy_pattern = false};

Target with(Target target, auto change) {
  change(target);
  return target;
}

Camera pinhole(int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  return camera;
}

// The left camera of EuRoC.
Camera pinhole_like() {
  Camera camera = pinhole(752, 480);
  camera.fx = 458.6, camera.fy = 457.3, camera.cx = 367.2, camera.cy = 248.4;
  camera.distortion = Distortion::kRadtan;
  camera.coefficients = {-0.283, 0.0739, 0.00019, 1.76e-5};
  return camera;
}

// 180 degrees across the image.
Camera fisheye() {
  Camera camera = pinhole(752, 480);
  camera.fx = 157, camera.fy = 157, camera.cx = 375, camera.cy = 240;
  camera.distortion = Distortion::kDoubleSphere;
  camera.coefficients = {-0.18, 0.59};
  return camera;
}

// The same view with fewer pixels.
Camera smaller(Camera camera, double factor) {
  camera.width = static_cast<int>(camera.width * factor);
  camera.height = static_cast<int>(camera.height * factor);
  for (double* number : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *number *= factor;
  return camera;
}

// What a detection has against the truth.
struct Score {
  std::size_t visible = 0, found = 0, wrong = 0;
  std::vector<double> errors;  // [px]
  Vector2d sum = Vector2d::Zero();
  double squares = 0;  // of errors in sigmas

  void add(const TargetRenderer& renderer, const SE3& cam_T_target,
           const TargetDetection& detection) {
    const auto truth = renderer.corners(cam_T_target);
    for (const auto& pixel : truth) visible += pixel && in_image(renderer.camera(), *pixel, 8);
    found += detection.view.ids.size();
    EXPECT_TRUE(std::ranges::is_sorted(detection.view.ids));
    for (std::size_t k = 0; k < detection.view.ids.size(); ++k) {
      const auto& pixel = truth.at(static_cast<std::size_t>(detection.view.ids[k]));
      if (!pixel || (*pixel - detection.view.pixels[k]).norm() > 2) {
        ++wrong;
        continue;
      }
      const Vector2d error = detection.view.pixels[k] - *pixel;
      errors.push_back(error.norm());
      sum += error;
      squares += error.squaredNorm() / (2 * detection.sigmas[k] * detection.sigmas[k]);
    }
  }

  double quantile(double part) {
    if (errors.empty()) return 1e9;
    std::ranges::sort(errors);
    return errors[static_cast<std::size_t>(part * static_cast<double>(errors.size() - 1))];
  }

  Vector2d bias() const { return sum / static_cast<double>(errors.size()); }
};

// View number v of many: from all sides, partly cut by the image, sometimes with a hand before it.
struct Shot {
  Viewpoint from;
  Photograph how;
};
Shot shot_of(const Camera& camera, std::uint64_t v) {
  const Random random{77};
  const auto u = [&](std::uint32_t k) { return random.uniform(Stream::kStart, v, k); };
  const bool wide = sees_beside(camera);
  const double turn = 6.2832;
  return {{.distance = wide ? 0.3 + 0.5 * u(0) : 0.5 + 0.9 * u(0),
           .tilt = 0.9 * u(1),
           .towards = turn * u(2),
           .roll = turn * u(3),
           .aside = (wide ? 1.3 : 0.45) * u(4),
           .aside_towards = turn * u(5)},
          {.blur = 0.3 + 0.7 * u(6),
           .noise = 1 + 4 * u(7),
           .black = 25,
           .white = 120 + 120 * u(8),
           .light = {u(9) - 0.5, u(10) - 0.5},
           .clutter = true,
           .cover = v % 4 == 3 ? 0.2 : 0,
           .seed = v}};
}

Score score_of(const Target& target, const Camera& camera, std::uint64_t first,
               std::uint64_t count) {
  const TargetRenderer renderer(target, camera);
  const TargetDetector detector(target);
  Score score;
  for (std::uint64_t v = first; v < first + count; ++v) {
    const Shot s = shot_of(camera, v);
    const SE3 cam_T_target = test::cam_T_target_of(target, s.from);
    score.add(renderer, cam_T_target, detector.detect(renderer.render(cam_T_target, s.how)));
  }
  return score;
}

void expect_good(const Target& target, const Camera& camera, double part) {
  Score score = score_of(target, camera, 0, 2);
  EXPECT_EQ(score.wrong, 0u);
  EXPECT_GE(static_cast<double>(score.found), part * static_cast<double>(score.visible));
  EXPECT_LT(score.quantile(0.5), 0.05);
  EXPECT_LT(score.quantile(1), 0.5);
}

TEST(TargetDetector, AprilGridThroughAnOrdinaryLens) {
  expect_good(kAprilGrid, pinhole_like(), 0.95);
}
TEST(TargetDetector, AprilGridThroughAFisheye) { expect_good(kAprilGrid, fisheye(), 0.6); }
TEST(TargetDetector, CharucoThroughAnOrdinaryLens) { expect_good(kCharuco, pinhole_like(), 0.9); }
TEST(TargetDetector, CharucoThroughAFisheye) { expect_good(kCharuco, fisheye(), 0.6); }

TEST(TargetDetector, CheckerboardsThroughBothLenses) {
  for (const Camera& camera : {pinhole_like(), fisheye()}) {
    const TargetRenderer renderer(kCheckerboard, camera);
    const Viewpoint from{
        .distance = sees_beside(camera) ? 0.35 : 0.9, .tilt = 0.4, .towards = 1, .roll = 2};
    const SE3 cam_T_target = test::cam_T_target_of(kCheckerboard, from);
    Score score;
    score.add(renderer, cam_T_target,
              TargetDetector(kCheckerboard).detect(renderer.render(cam_T_target, {})));
    EXPECT_EQ(score.found, 56u);
    EXPECT_EQ(score.wrong, 0u);
    EXPECT_LT(score.quantile(0.5), 0.05);
  }
}

TEST(TargetDetector, LegacyPatternsAndFewBits) {
  const Target legacy = with(kCharuco, [](Target& t) {
    t.legacy_pattern = true;
    t.dictionary = "DICT_4X4_50";
  });
  Score score = score_of(legacy, pinhole_like(), 1, 2);
  EXPECT_EQ(score.wrong, 0u);
  EXPECT_GE(static_cast<double>(score.found), 0.95 * static_cast<double>(score.visible));
}

// Where half a turn makes no difference, x goes to the right.
TEST(TargetDetector, SymmetricCheckerboardsHaveADirection) {
  const Target even = with(kCheckerboard, [](Target& t) { t.columns = 6, t.rows = 6; });
  const TargetRenderer renderer(even, smaller(pinhole_like(), 0.5));
  for (const double roll : {0.2, 1.8, 3.3, 5.0}) {
    const SE3 pose = test::cam_T_target_of(even, {.distance = 0.8, .tilt = 0.3, .roll = roll});
    const TargetDetection found = TargetDetector(even).detect(renderer.render(pose, {}));
    ASSERT_EQ(found.view.ids.size(), 36u) << found.lack;
    const Vector2d x = found.view.pixels[5] - found.view.pixels[0];
    const Vector2d y = found.view.pixels[30] - found.view.pixels[0];
    EXPECT_GT(x.x(), std::abs(x.y()));
    EXPECT_LT(x.x() * y.y() - x.y() * y.x(), 0) << "y goes up";
  }
}

// The truth is within the sigmas: errors of sharp images are those of the noise.
TEST(TargetDetector, SigmasAreThoseOfTheErrors) {
  const TargetRenderer renderer(kAprilGrid, pinhole_like());
  const SE3 pose = test::cam_T_target_of(kAprilGrid, {.distance = 0.95, .tilt = 0.2, .roll = 0.3});
  Score score;
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    const Photograph how{.blur = 0.8, .noise = 6, .seed = seed};
    score.add(renderer, pose, TargetDetector(kAprilGrid).detect(renderer.render(pose, how)));
  }
  ASSERT_EQ(score.found, 288u);
  const double mean = score.squares / 288;  // of 576 squares, chi2 / 2: 1 within four sigmas
  EXPECT_GT(mean, 1 - 4 * std::sqrt(2.0 / 576));
  EXPECT_LT(mean, 1 + 4 * std::sqrt(2.0 / 576));
  EXPECT_LT(score.bias().norm(), 4 * score.quantile(0.5) / std::sqrt(288.0));
}

// OpenCV's refinement, from the same corners, in windows without other edges.
TEST(TargetDetector, CornersAreNearerToTheTruthThanOpenCvs) {
  const TargetRenderer renderer(kCheckerboard, pinhole_like());
  const SE3 pose =
      test::cam_T_target_of(kCheckerboard, {.distance = 0.8, .tilt = 0.5, .roll = 0.3});
  GrayImage image = renderer.render(pose, {.blur = 0.8, .noise = 4});
  const TargetDetection found = TargetDetector(kCheckerboard).detect(image);
  ASSERT_EQ(found.view.ids.size(), 56u);
  std::vector<cv::Point2f> corners;
  for (const Vector2d& p : found.view.pixels)
    corners.emplace_back(std::lround(p.x()), std::lround(p.y()));
  cv::cornerSubPix(cv::Mat(image.height, image.width, CV_8U, image.pixels.data()), corners, {5, 5},
                   {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  const auto truth = renderer.corners(pose);
  double ours = 0, theirs = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector2d other(static_cast<double>(corners[k].x), static_cast<double>(corners[k].y));
    EXPECT_LT((found.view.pixels[k] - other).norm(), 0.2);
    ours += (found.view.pixels[k] - *truth[k]).squaredNorm();
    theirs += (other - *truth[k]).squaredNorm();
  }
  EXPECT_LT(ours, 0.5 * theirs);
}

// What a view of `shown` says to a detector of `stated`.
TargetDetection seen(const Target& shown, const Target& stated, const Viewpoint& from,
                     const Photograph& how = {}) {
  const TargetRenderer renderer(shown, smaller(pinhole_like(), 0.5));
  return TargetDetector(stated).detect(renderer.render(test::cam_T_target_of(shown, from), how));
}

void expect_none(const TargetDetection& found, const std::string& part) {
  EXPECT_TRUE(found.view.ids.empty());
  EXPECT_NE(found.lack.find(part), std::string::npos) << found.lack;
}

void expect_some(const TargetDetection& found, const std::string& part) {
  EXPECT_FALSE(found.view.ids.empty());
  EXPECT_NE(found.lack.find(part), std::string::npos) << found.lack;
}

TEST(TargetDetector, SaysWhyCornersAreMissing) {
  const Viewpoint near{.distance = 0.7};
  EXPECT_EQ(seen(kCharuco, kCharuco, near).lack, "");
  expect_some(seen(kCharuco, kCharuco, {.distance = 0.3}), "leaves the image");
  expect_some(seen(kCharuco, kCharuco, near, {.cover = 0.2}), "covered");
  expect_none(seen(kCharuco, kCharuco, near, {.blur = 6, .clutter = false}), "blurred");
  expect_none(seen(kCharuco, kCharuco, near, {.black = 20, .white = 22, .clutter = false}), "dark");
  expect_none(seen(kCheckerboard, kCheckerboard, near, {.cover = 0.2}), "in the image wholly");
}

TEST(TargetDetector, AnotherBoardThanStated) {
  const Viewpoint near{.distance = 0.9};
  const auto columns = [](Target& t) { t.columns = 7; };
  const auto rows = [](Target& t) { t.rows = 5; };
  const auto legacy = [](Target& t) { t.legacy_pattern = true; };
  const auto dictionary = [](Target& t) { t.dictionary = "DICT_6X6_100"; };
  expect_none(seen(kCharuco, with(kCharuco, columns), near), "is not 7 x 8");
  expect_none(seen(kCharuco, with(kCharuco, legacy), near), "legacy_pattern true");
  expect_none(seen(kCharuco, with(kCharuco, dictionary), near), "other tags");
  expect_none(seen(kCheckerboard, with(kCheckerboard, columns), near),
              "56 corners, expected all 49");
  expect_none(seen(kAprilGrid, with(kAprilGrid, columns), {.distance = 1}), "contradict");
  expect_none(seen(kAprilGrid, with(kAprilGrid, rows), {.distance = 1}), "beyond");
}

TEST(TargetDetector, ImagesWithoutABoard) {
  const TargetDetector detector(kAprilGrid);
  for (const auto& [width, height] : {std::pair(0, 0), {1, 1}, {3, 200}, {16, 16}, {101, 99}}) {
    const GrayImage image{width, height,
                          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * height, 128)};
    expect_none(detector.detect(image), "no crossing edges");
  }
  GrayImage noise{200, 100, {}};
  for (std::uint64_t i = 0; i < 20000; ++i) {
    noise.pixels.push_back(
        static_cast<std::uint8_t>(255 * Random{3}.uniform(Stream::kImageNoise, i)));
  }
  EXPECT_TRUE(detector.detect(noise).view.ids.empty());
}

TEST(TargetDetector, BadTargetsAreRejected) {
  EXPECT_THROW(TargetDetector(with(kAprilGrid, [](Target& t) { t.tag_size = 0; })), UsageError);
  EXPECT_THROW(TargetDetector(with(kCharuco, [](Target& t) { t.dictionary = ""; })), UsageError);
}

// A thousand views of all kinds; a fourth of them partly covered, many cut.
TEST(TargetDetectorLong, NoWrongId) {
  const std::vector<Target> targets = {kAprilGrid, kCharuco,
                                       with(kCharuco,
                                            [](Target& t) {
                                              t.legacy_pattern = true;
                                              t.dictionary = "DICT_4X4_50";
                                            }),
                                       kCheckerboard};
  for (const Target& target : targets) {
    for (const Camera& camera : {pinhole_like(), fisheye()}) {
      Score score = score_of(target, smaller(camera, 0.6), 0, 125);
      EXPECT_EQ(score.wrong, 0u);
      EXPECT_GT(score.found, score.visible / 2);
      EXPECT_LT(score.quantile(0.5), 0.05);
      EXPECT_LT(score.quantile(0.99), 0.3);
    }
  }
}

}  // namespace
}  // namespace chasles
