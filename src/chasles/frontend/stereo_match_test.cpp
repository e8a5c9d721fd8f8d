#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/frontend_testing.hpp>
#include <chasles/frontend/stereo_match.hpp>
#include <chasles/frontend/view_transfer.hpp>

namespace chasles::test {
namespace {

/// A rig in a room, and statistics of the matches of its first camera's corners in the other one.
class StereoInARoom {
 public:
  StereoInARoom(std::vector<Camera> rig, const SE3& world_T_imu, const Room& in = room())
      : rig_(std::move(rig)), in_(in) {
    for (std::size_t c = 0; c < 2; ++c) {
      world_T_cam_[c] = world_T_imu * rig_[c].cam_T_imu.inverse();
      build_pyramid(in.render(rig_[c], world_T_cam_[c], 1, 0, 2, c + 1), Equalisation::kNone, 4,
                    images_[c]);
    }
  }

  struct Score {
    int visible = 0;          ///< corners whose point is visible in the other camera
    int found = 0;            ///< matches
    int right = 0;            ///< matches within a pixel of the truth
    double median_error = 0;  ///< of the correct ones [px]
    double outwards = 0;      ///< mean error of the correct ones, from the principal point [px]
    double worst_depth =
        0;  ///< largest relative error of a correct match's inverse depth, beyond noise
  };

  Score score(std::optional<double> inverse_depth = {}) const {
    Score result;
    std::vector<double> errors;
    const StereoViews views(rig_[0], images_[0], rig_[1], images_[1]);
    Coverage coverage({.border = 20}, rig_[0].width, rig_[0].height);
    for (const Eigen::Vector2d& pixel : coverage.refill(images_[0], {}, {})) {
      const auto ray = wide_ray(rig_[0], pixel);
      const auto truth = in_.true_pixel(rig_[0], world_T_cam_[0], pixel, rig_[1], world_T_cam_[1]);
      const auto match = match_stereo(views, {pixel, *ray, inverse_depth}, {});
      if (truth && in_image(rig_[1], *truth, 20)) ++result.visible;
      if (!match) continue;
      ++result.found;
      const double error = truth ? (match->pixel - *truth).norm() : 1e9;
      if (error > 1) continue;
      ++result.right;
      errors.push_back(error);
      const Eigen::Vector2d out = *truth - Eigen::Vector2d(rig_[1].cx, rig_[1].cy);
      result.outwards += out.normalized().dot(match->pixel - *truth);
      const Eigen::Vector3d p = world_T_cam_[0].inverse() * in_.hit(world_T_cam_[0], ray->ray);
      const double depth = is_ahead(p) ? p.z() : p.norm();
      result.worst_depth = std::max(result.worst_depth, std::abs(match->inverse_depth * depth - 1));
    }
    if (errors.empty()) return result;
    result.outwards /= static_cast<double>(errors.size());
    std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
    result.median_error = errors[errors.size() / 2];
    return result;
  }

 private:
  std::vector<Camera> rig_;
  const Room& in_;
  SE3 world_T_cam_[2];
  ImagePyramid images_[2];
};

void expect_good(const StereoInARoom::Score& score) {
  EXPECT_GT(score.visible, 80);
  EXPECT_GE(score.right, 0.98 * score.found) << score.found;
  EXPECT_GE(score.right, 0.9 * score.visible) << score.visible;
  EXPECT_LT(score.median_error, 0.1);
  EXPECT_LT(score.worst_depth, 0.1);
}

// Two fisheye cameras of 195 degrees, 10 cm from each other and back to back: they share the points
// beside them, which both have at the rims of their images.
TEST(StereoMatch, CamerasBackToBackShareTheirRims) {
  Camera front = fisheye_camera();
  front.width = front.height = 480;
  front.fx = front.fy = 140;
  front.cx = front.cy = 239.5;
  front.coefficients = {0, 0, 0, 0};
  Camera back = front;
  back.cam_T_imu.R = so3::exp({0, std::numbers::pi, 0});
  back.cam_T_imu.p = {0, 0, -0.1};
  const StereoInARoom rig({front, back}, {so3::exp({0.2, -0.1, 0.3}), {0.3, -0.2, 0.1}});
  const auto score = rig.score();
  EXPECT_GT(score.visible, 30);
  EXPECT_GE(score.right, 0.98 * score.found) << score.found;
  EXPECT_GE(score.right, 0.9 * score.visible) << score.visible;
  EXPECT_LT(score.median_error, 0.1);
  // Lines bend to different sides there (transfer_bow): otherwise all matches are too far in.
  EXPECT_NEAR(score.outwards, 0, 0.02);
}

TEST(TransferBow, IsTheSecondOrderPartOfThePixels) {
  Camera front = fisheye_camera(), back = fisheye_camera();
  back.cam_T_imu.R = so3::exp({0.1, std::numbers::pi, 0.2});
  const Eigen::Matrix3d back_R_front = back.cam_T_imu.R * front.cam_T_imu.R.transpose();
  const auto seen = [&](const Eigen::Vector2d& pixel) {
    const auto direction = bearing(back, pixel);
    return project(front, 100 * (back_R_front.transpose() * direction->bearing))->pixel;
  };
  const auto at_rim = project(back, 100 * Eigen::Vector3d(0.3, 1, 0.02));
  ASSERT_TRUE(at_rim);
  const Eigen::Vector2d pixel = at_rim->pixel;
  const auto bow = transfer_bow(front, back, back_R_front, pixel, 3);
  EXPECT_GT(bow.cwiseAbs().maxCoeff(), 1e-3);
  Eigen::Matrix2d A;
  constexpr double kStep = 0.01;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
    A.col(i) = (seen(pixel + step) - seen(pixel - step)) / (2 * kStep);
  }
  for (const Eigen::Vector2d& o : {Eigen::Vector2d(5, 0), Eigen::Vector2d(0, 6),
                                   Eigen::Vector2d(-4, 3), Eigen::Vector2d(4, 5)}) {
    const Eigen::Vector2d linear = seen(pixel) + A * o;
    const Eigen::Vector2d squares =
        bow * Eigen::Vector3d(o.x() * o.x(), o.x() * o.y(), o.y() * o.y());
    EXPECT_LT((seen(pixel + o) - linear - squares).norm(),
              0.1 * (seen(pixel + o) - linear).norm() + 1e-3)
        << o.transpose();
  }
  EXPECT_LT(transfer_bow(front, front, Eigen::Matrix3d::Identity(), pixel, 3).norm(), 1e-9);
  EXPECT_TRUE(transfer_bow(front, back, back_R_front, {-1e4, 0}, 3).isZero()) << "no direction";
}

TEST(StereoMatch, FindsTheCornersOfARoomWithoutAnyDepthGiven) {
  for (const int frame : {0, 20, 60}) {
    expect_good(StereoInARoom(euroc_rig(), walk_pose(frame)).score());
  }
}

TEST(StereoMatch, FindsThemFromARoughDepthAndFromAWrongOne) {
  const StereoInARoom stereo(euroc_rig(), walk_pose(10));
  expect_good(stereo.score(0.33));
  expect_good(stereo.score(2.5));
}

TEST(StereoMatch, FindsNearWalls) {
  const Room small({0.9, 0.9, 0.9}, 4);
  StereoInARoom stereo(euroc_rig(), {}, small);
  const auto score = stereo.score();
  EXPECT_GE(score.right, 0.97 * score.found);
  EXPECT_GE(score.right, 0.8 * score.visible);
}

TEST(StereoMatch, OfAFisheyeRigIsAlongItsCurvedLines) {
  Camera first = fisheye_camera(), other = fisheye_camera();
  other.cam_T_imu.R = so3::exp(Eigen::Vector3d(0.02, -0.05, 0.03));
  other.cam_T_imu.p = {-0.1, 0.01, 0.005};
  const auto score = StereoInARoom({first, other}, walk_pose(5)).score();
  EXPECT_GT(score.visible, 80);
  EXPECT_GE(score.right, 0.97 * score.found) << score.found;
  EXPECT_GE(score.right, 0.85 * score.visible) << score.visible;
}

TEST(StereoMatch, OfAVerticalRigIsTheSame) {
  Camera first = euroc_camera(), other = euroc_camera();
  other.cam_T_imu.p = {0.01, -0.12, 0.02};
  expect_good(StereoInARoom({first, other}, walk_pose(30)).score());
}

TEST(TriangulateMatch, GivesTheDepthOfAProjectedPoint) {
  const std::vector<Camera> rig = euroc_rig();
  const ImagePyramid none;
  const StereoViews views(rig[0], none, rig[1], none);
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const double z = random.uniform(0.5, 30);
    const Eigen::Vector3d p =
        z * Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3), 1);
    const auto first = project(rig[0], p), other = project(rig[1], views.other_T_first * p);
    ASSERT_TRUE(first && other);
    const auto ray = wide_ray(rig[0], first->pixel);
    const auto match = triangulate_match(views, *ray, other->pixel, 1e-3);
    ASSERT_TRUE(match);
    EXPECT_NEAR(match->inverse_depth * z, 1, 1e-6);
  }
}

TEST(TriangulateMatch, RejectsWhatIsOffTheLineOrBeyondInfinity) {
  const std::vector<Camera> rig = euroc_rig();
  const ImagePyramid none;
  const StereoViews views(rig[0], none, rig[1], none);
  const Eigen::Vector3d p(0.4, -0.2, 3);
  const auto first = project(rig[0], p), other = project(rig[1], views.other_T_first * p);
  const auto ray = wide_ray(rig[0], first->pixel);
  const auto far = project(rig[1], 1000 * views.other_T_first.R * p);
  const Eigen::Vector2d along = (other->pixel - far->pixel).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const double threshold = 1 / 458.0;
  const auto matched = [&](const Eigen::Vector2d& pixel) {
    return triangulate_match(views, *ray, pixel, threshold).has_value();
  };
  EXPECT_TRUE(matched(other->pixel));
  EXPECT_TRUE(matched(other->pixel + 0.6 * across));
  EXPECT_FALSE(matched(other->pixel + 1.6 * across));
  EXPECT_FALSE(matched(other->pixel - 1.6 * across));
  EXPECT_TRUE(matched(far->pixel));
  EXPECT_TRUE(matched(far->pixel - 0.6 * along));
  EXPECT_FALSE(matched(far->pixel - 2 * along));
  EXPECT_FALSE(matched({-1e6, 1e6}));
}

TEST(TriangulateMatch, OfTwoCamerasInOnePlaceIsNone) {
  std::vector<Camera> rig = euroc_rig();
  rig[1].cam_T_imu = rig[0].cam_T_imu;
  const ImagePyramid none;
  const StereoViews views(rig[0], none, rig[1], none);
  const auto ray = wide_ray(rig[0], {300, 200});
  EXPECT_FALSE(triangulate_match(views, *ray, {300, 200}, 1e-2));
}

}  // namespace
}  // namespace chasles::test
