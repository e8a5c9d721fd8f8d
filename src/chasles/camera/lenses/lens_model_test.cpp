#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include <chasles/base/constants.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/camera/lenses/lens_model.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using test::Lens;
using test::lens_of;
using test::lenses;

constexpr double kHalfPi = std::numbers::pi / 2;

const LensModel& model_of(const Camera& camera) { return *find_lens_model(camera.distortion); }

Eigen::Vector2d towards(double angle, double around) {
  return std::tan(angle) * Eigen::Vector2d(std::cos(around), std::sin(around));
}

TEST(LensModel, EachModelOfTheListHasALensHere) {
  std::set<Distortion> tested;
  for (const Lens& lens : lenses()) {
    tested.insert(lens.camera.distortion);
    const LensCoefficients& k = lens.camera.coefficients;
    EXPECT_EQ(coefficients_fault(lens.camera.distortion, k), "");
  }
  EXPECT_EQ(tested.size(), kLensModels.size());
  for (const LensModel& model : kLensModels) {
    EXPECT_EQ(lens_model_named(model.name), model.distortion);
    EXPECT_EQ(find_lens_model(model.distortion), &model);
  }
  EXPECT_EQ(find_lens_model(Distortion{77}), nullptr);
  EXPECT_EQ(find_lens_model(Distortion{-1}), nullptr);
}

TEST(LensModel, UndistortionInvertsDistortion) {
  for (const Lens& lens : lenses()) {
    const auto& k = lens.camera.coefficients;
    for (int i = 0; i <= 60; ++i) {
      for (int j = 0; j < 8; ++j) {
        const Eigen::Vector2d xy = towards(lens.largest_angle * i / 60, 0.05 + j * 0.8);
        const auto bent = model_of(lens.camera).distort(k, xy);
        ASSERT_TRUE(bent) << model_of(lens.camera).name << " " << xy.transpose();
        const auto back = model_of(lens.camera).undistort(k, bent->xy);
        ASSERT_TRUE(back) << model_of(lens.camera).name << " " << xy.transpose();
        EXPECT_LT((*back - xy).norm(), 1e-12 * (1 + xy.norm())) << model_of(lens.camera).name;
      }
    }
  }
}

TEST(LensModel, TheAxisStaysAndItsSlopeIsStated) {
  for (const Lens& lens : lenses()) {
    const auto bent =
        model_of(lens.camera).distort(lens.camera.coefficients, Eigen::Vector2d::Zero());
    ASSERT_TRUE(bent);
    EXPECT_EQ(bent->xy, Eigen::Vector2d::Zero());
    const Eigen::Vector2d f = focal_lengths_at_axis(lens.camera);
    EXPECT_TRUE(
        test::agree(bent->d_xy, f.x() / lens.camera.fx * Eigen::Matrix2d::Identity(), 1e-15));
    EXPECT_NEAR(f.y() / lens.camera.fy, f.x() / lens.camera.fx, 1e-15);
    // The derivative farther out tends to it.
    const auto near = model_of(lens.camera).distort(lens.camera.coefficients, {1e-7, 1e-7});
    EXPECT_TRUE(test::agree(near->d_xy, bent->d_xy, 1e-5));
  }
}

// Lenses that fold in front of the camera, with the angle of the fold along the x axis.
struct FoldingLens {
  Lens lens;
  double angle;
};

// The second sphere of a double sphere folds where the cosine of the shifted angle is the limit.
double double_sphere_fold(double xi, double limit) {
  double low = 0, high = std::numbers::pi / 2;
  for (int i = 0; i < 100; ++i) {
    const double angle = (low + high) / 2;
    const double shifted = std::cos(angle) + xi;
    (shifted / std::hypot(shifted, std::sin(angle)) > limit ? low : high) = angle;
  }
  return low;
}

std::vector<FoldingLens> folding_lenses() {
  return {
      // r / (1 + t / 2.25): rises up to r = 1.5.
      {lens_of(Distortion::kRadtan, {0, 0, 0, 0, 0, 1 / 2.25, 0, 0}, 300, 0), std::atan(1.5)},
      // The denominator 1 - t / 4 has a pole at r = 2.
      {lens_of(Distortion::kRadtan, {0, 0, 0, 0, 0, -0.25, 0, 0}, 300, 0), std::atan(2.0)},
      // y + s3 r^2 + 0 on the x axis: d x' / d x = 1 + 2 s1 x is 0 at x = 1.25.
      {lens_of(Distortion::kRadtan, {0, 0, 0, 0, 0, 0, 0, 0, -0.4, 0, 0, 0}, 300, 0),
       std::atan(1.25)},
      {lens_of(Distortion::kDoubleSphere, {-0.8, 0.8}, 300, 0), double_sphere_fold(-0.8, -0.25)},
      {lens_of(Distortion::kDoubleSphere, {-0.8, 0.3}, 300, 0),
       double_sphere_fold(-0.8, -0.3 / 0.7)},
      // 1 - 0.5 sqrt(1 + r^2) is 0 at 60 degrees.
      {lens_of(Distortion::kOmni, {-0.5}, 300, 0), std::numbers::pi / 3},
      // 1 - 4 lambda r^2 is 0 at r = 0.5.
      {lens_of(Distortion::kDivision, {1}, 300, 0), std::atan(0.5)},
      // 1 - theta^12 is 0 at one radian.
      {lens_of(Distortion::kFisheye624, {0, 0, 0, 0, 0, -1.0 / 13, 0, 0, 0, 0, 0, 0}, 300, 0), 1}};
}

TEST(LensModel, ALensIsUsedUpToItsFirstFoldAndNotBeyond) {
  for (const auto& [lens, angle] : folding_lenses()) {
    const auto& k = lens.camera.coefficients;
    const LensModel& model = model_of(lens.camera);
    EXPECT_EQ(coefficients_fault(model.distortion, k), "");
    for (double at = 0.01; at < std::numbers::pi / 2; at += 0.01) {
      if (std::abs(at - angle) < 1e-3) continue;
      const auto bent = model.distort(k, towards(at, 0));
      EXPECT_EQ(bent.has_value(), at < angle) << model.name << " " << at;
      if (!bent) continue;
      EXPECT_TRUE(model.undistort(k, bent->xy)) << model.name << " " << at;
    }
    EXPECT_TRUE(model.distort(k, towards(angle * (1 - 1e-6), 0))) << model.name;
    EXPECT_FALSE(model.distort(k, towards(angle * (1 + 1e-6), 0))) << model.name;
  }
}

// Along each ray from the axis the radius rises, and no pixel is NaN.
TEST(LensModel, ThePlaneIsNeverNaNAndNeverCoveredTwice) {
  std::vector<Lens> all = lenses();
  for (const auto& [lens, angle] : folding_lenses()) all.push_back(lens);
  for (const Lens& lens : all) {
    const auto& k = lens.camera.coefficients;
    const LensModel& model = model_of(lens.camera);
    for (int j = 0; j < 8; ++j) {
      bool ended = false;
      for (double at = 0.001; at < 1.57; at += 0.003) {
        const auto bent = model.distort(k, towards(at, 0.8 * j));
        if (!bent) ended = true;
        if (!bent) continue;
        ASSERT_FALSE(ended && lens.largest_angle > 1.4) << model.name << " " << at;
        ASSERT_TRUE(bent->xy.allFinite() && bent->d_xy.allFinite());
        ASSERT_GT(bent->d_xy.determinant(), 0) << model.name << " " << at;
      }
    }
    // Whatever the plane holds, a ray comes back to it.
    for (double x = -4; x <= 4; x += 0.25) {
      for (double y = -4; y <= 4; y += 0.25) {
        const auto xy = model.undistort(k, {x, y});
        if (!xy) continue;
        ASSERT_TRUE(xy->allFinite());
        const auto bent = model.distort(k, *xy);
        ASSERT_TRUE(bent) << model.name << " " << x << " " << y;
        ASSERT_LT((bent->xy - Eigen::Vector2d(x, y)).norm(), 1e-11) << model.name;
      }
    }
  }
}

TEST(LensModel, WhatIsFarOutIsNone) {
  constexpr double kLarge = std::numeric_limits<double>::max();
  for (const Lens& lens : lenses()) {
    for (const double x : {kLarge, -1e200, 1e160}) {
      EXPECT_FALSE(project(lens.camera, {x, 1, 1}));
      const auto ray = unproject(lens.camera, {x, 1});
      EXPECT_FALSE(ray && !ray->ray.allFinite());
    }
  }
}

Eigen::Vector3d bearing_at(double angle, double around) {
  return {std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle)};
}

// Directions on rings about the axis, also close to it and on both sides of 90 degrees.
std::vector<Eigen::Vector3d> bearings(double widest) {
  std::vector<Eigen::Vector3d> all = {{0, 0, 1}};
  for (const double angle : {1e-12, 0.99e-9, 1.01e-9, 1e-6, 0.1, 0.8, 1.5, kHalfPi - 1e-9, kHalfPi,
                             kHalfPi + 1e-9, 1.6, 1.75, 1.9, 2.3, 2.6}) {
    if (angle > widest) break;
    for (int i = 0; i < 12; ++i) all.push_back(bearing_at(angle, 0.1 + i * kHalfPi / 3));
  }
  return all;
}

TEST(LensModel, InFrontADirectionHasTheImageOfItsPlanePoint) {
  for (const Lens& lens : lenses()) {
    const LensModel& model = model_of(lens.camera);
    const auto& k = lens.camera.coefficients;
    EXPECT_EQ(model.distort_bearing == nullptr, model.bearing_of == nullptr);
    EXPECT_EQ(model.distort_bearing == nullptr,
              model.distortion == Distortion::kNone || model.distortion == Distortion::kRadtan);
    if (!model.distort_bearing) continue;
    for (int i = 0; i <= 60; ++i) {
      const double angle = lens.largest_angle * i / 60;
      const Eigen::Vector3d b = bearing_at(angle, 0.05 + 0.8 * i);
      const auto image = model.distort_bearing(k, b);
      const auto bent = model.distort(k, towards(angle, 0.05 + 0.8 * i));
      ASSERT_TRUE(image && bent) << model.name << " " << angle;
      EXPECT_LT((image->xy - bent->xy).norm(), 1e-14 * (1 + bent->xy.norm())) << model.name;
      const Eigen::Matrix2d by_plane = image->d_bearing.leftCols<2>() * b.z();
      EXPECT_TRUE(test::agree(by_plane, bent->d_xy, 1e-12)) << model.name << " " << angle;
    }
  }
}

TEST(LensModel, ADirectionComesBackOverTheWholeDomain) {
  for (const Lens& lens : lenses()) {
    const LensModel& model = model_of(lens.camera);
    const double widest = test::widest_angle(lens.camera);
    for (int i = 0; i <= 90 && widest > 0; ++i) {
      for (int j = 0; j < 8; ++j) {
        const Eigen::Vector3d b = bearing_at(widest * i / 90, 0.05 + j * 0.8);
        const auto image = model.distort_bearing(lens.camera.coefficients, b);
        ASSERT_TRUE(image) << model.name << " " << b.transpose();
        const auto back = model.bearing_of(lens.camera.coefficients, image->xy);
        ASSERT_TRUE(back) << model.name << " " << b.transpose();
        EXPECT_LT((*back - b).norm(), 1e-12) << model.name << " " << b.transpose();
        EXPECT_NEAR(back->norm(), 1, 1e-15);
      }
    }
  }
}

TEST(LensModel, TheJacobianByABearingIsTheDerivative) {
  for (const Lens& lens : lenses()) {
    const LensModel& model = model_of(lens.camera);
    for (const Eigen::Vector3d& b : bearings(test::widest_angle(lens.camera))) {
      if (!model.distort_bearing) break;
      const auto image = [&](const Eigen::Vector3d& p) {
        return model.distort_bearing(lens.camera.coefficients, p.normalized())->xy;
      };
      const auto at = model.distort_bearing(lens.camera.coefficients, b);
      EXPECT_TRUE(test::agree(at->d_bearing, test::numeric_derivative(image, b, 1e-4), 1e-8))
          << model.name << " " << b.transpose();
      EXPECT_LT((at->d_bearing * b).norm(), 1e-13) << model.name;
    }
  }
}

TEST(LensModel, TheDerivativeByTheCoefficientsIsTheDerivative) {
  for (const Lens& lens : lenses()) {
    const LensModel& model = model_of(lens.camera);
    const std::span<const double> list(lens.camera.coefficients.begin(),
                                       lens.camera.coefficients.size());
    const Eigen::VectorXd k = Eigen::Map<const Eigen::VectorXd>(list.data(), std::ssize(list));
    for (const Eigen::Vector3d& b :
         bearings(std::max(lens.largest_angle, test::widest_angle(lens.camera)))) {
      const auto image = [&](const Eigen::VectorXd& at) -> Eigen::Vector2d {
        const LensCoefficients moved(std::span(at.data(), list.size()));
        return model.distort_bearing ? model.distort_bearing(moved, b)->xy
                                     : model.distort(moved, b.head<2>() / b.z())->xy;
      };
      const LensDerivative d = model.by_coefficients(lens.camera.coefficients, b);
      ASSERT_EQ(d.cols(), k.size()) << model.name;
      if (k.size() == 0) continue;
      EXPECT_TRUE(test::agree(d, test::numeric_derivative(image, k, 1e-5), 1e-7, 1e-5))
          << model.name << " " << b.transpose();
    }
  }
}

// The largest angle of a lens, where its cosine is this.
struct WideLimit {
  Distortion model;
  LensCoefficients k;
  double cosine;
};

// The root of (z + xi)^2 = w1^2 (1 + 2 z xi + xi^2) with z + xi < 0: there the second sphere folds
// or ends. The half-space of Usenko, Demmel & Cremers (2018, eq. 43 to 45) lies within it.
double double_sphere_limit(double xi, double alpha) {
  const double w1 = alpha > 0.5 ? (1 - alpha) / alpha : alpha / (1 - alpha);
  const double half = xi * (1 - w1 * w1);
  const double limit = -half - std::sqrt(half * half - xi * xi + w1 * w1 * (1 + xi * xi));
  EXPECT_LE(limit, -(w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1) + 1e-15);
  return limit;
}

// Its eq. 38: z > -w d, d^2 = beta (1 - z^2) + z^2.
double extended_limit(double alpha, double beta) {
  const double w = alpha > 0.5 ? (1 - alpha) / alpha : alpha / (1 - alpha);
  return -std::sqrt(w * w * beta / (1 - w * w + w * w * beta));
}

TEST(LensModel, DirectionsAreSeenUpToTheFirstFoldAndNeverStraightBehind) {
  const std::vector<WideLimit> limits = {
      {Distortion::kDoubleSphere, {-0.21, 0.59}, double_sphere_limit(-0.21, 0.59)},
      {Distortion::kDoubleSphere, {0.35, 0.42}, double_sphere_limit(0.35, 0.42)},
      {Distortion::kDoubleSphere, {0.1, 0.3}, double_sphere_limit(0.1, 0.3)},
      {Distortion::kEucm, {0.62, 1.08}, extended_limit(0.62, 1.08)},
      {Distortion::kEucm, {0.4, 0.8}, extended_limit(0.4, 0.8)},
      {Distortion::kOmni, {1.6}, -1 / 1.6},
      {Distortion::kOmni, {0.7}, -0.7},
      // 1 - theta^2 / 4 is 0 at two radians.
      {Distortion::kEquidistant, {-1.0 / 12, 0, 0, 0}, std::cos(2.0)},
      {Distortion::kFisheye624, {-1.0 / 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, std::cos(2.0)},
      {Distortion::kDivision, {0}, 0},
      {Distortion::kDivision, {0.1}, std::cos(std::atan(std::sqrt(2.5)))}};
  for (const auto& [distortion, k, cosine] : limits) {
    const LensModel& model = *find_lens_model(distortion);
    const double limit = std::acos(cosine);
    for (double angle = 0.01; angle < 3.14; angle += 0.01) {
      if (std::abs(angle - limit) < 1e-3) continue;
      const auto image = model.distort_bearing(k, bearing_at(angle, 0.3));
      EXPECT_EQ(image.has_value(), angle < limit) << model.name << " " << angle;
      if (image && angle < limit - 0.05) {
        EXPECT_TRUE(model.bearing_of(k, image->xy)) << model.name << " " << angle;
      }
    }
    EXPECT_TRUE(model.distort_bearing(k, bearing_at(limit - 1e-6, 0.3))) << model.name;
    EXPECT_FALSE(model.distort_bearing(k, bearing_at(limit + 1e-6, 0.3))) << model.name;
  }
  for (const Lens& lens : lenses()) {
    const LensModel& model = model_of(lens.camera);
    if (!model.distort_bearing) continue;
    const auto& k = lens.camera.coefficients;
    EXPECT_FALSE(model.distort_bearing(k, {0, 0, -1})) << model.name;
    EXPECT_FALSE(model.distort_bearing(k, {1e-12, 0, -1})) << model.name;
    EXPECT_FALSE(model.distort_bearing(k, {kNaN, 0, 1})) << model.name;
    // Whatever the plane holds, a direction comes back to it.
    for (double x = -40; x <= 40; x += 0.73) {
      const auto b = model.bearing_of(k, {x, 0.3 * x});
      if (!b) continue;
      ASSERT_TRUE(b->allFinite()) << model.name << " " << x;
      const auto image = model.distort_bearing(k, *b);
      if (!image) continue;  // at the very end of the domain
      EXPECT_LT((image->xy - Eigen::Vector2d(x, 0.3 * x)).norm(), 1e-9) << model.name << " " << x;
    }
  }
}

// Pixels of other programs, of 2026-11:
//   cv2 5.0.0 (opencv-contrib-python-headless 5.0.0.93): projectPoints, omnidir.projectPoints;
//   pycolmap 4.2.1: Camera(model=..., params=[fx, fy, cx, cy, ...]).img_from_cam;
//   ds-msp 0.22.2: ds_project(points, fx, fy, cx, cy, xi, alpha);
//   projectaria-tools 2.3.0: FISHEYE624, the same numbers as pycolmap's.
struct Reference {
  const char* by;
  Camera camera;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> pixels;  // of directions (x/z, y/z)
};

Camera with(Distortion model, LensCoefficients k, const Eigen::Vector4d& f) {
  return {.width = 1280,
          .height = 800,
          .fx = f[0],
          .fy = f[1],
          .cx = f[2],
          .cy = f[3],
          .distortion = model,
          .coefficients = k,
          .cam_T_imu = {}};
}

std::vector<Reference> references() {
  const Eigen::Vector2d a(0.11, 0.23), b(-0.6, 0.35), c(0.9, -0.5), d(1.3, -0.9), e(-4, 6.5);
  return {{"cv2 and pycolmap FULL_OPENCV",
           with(Distortion::kRadtan, {0.52, -2.7, 8e-4, -3e-4, 1.6, 0.39, -2.5, 1.52},
                {610, 605, 640, 360}),
           {{a, {707.6124740086715, 500.26888097699907}},
            {b, {261.72669796734675, 579.03318767702}},
            {c, {1199.138245679543, 52.31996483048857}}}},
          {"cv2",
           with(Distortion::kRadtan,
                {0.52, -2.7, 8e-4, -3e-4, 1.6, 0.39, -2.5, 1.52, 1.2e-3, -4e-4, -9e-4, 3e-4},
                {610, 605, 640, 360}),
           {{a, {707.6590231086715, 500.23425531449914}},
            {b, {262.02308324234673, 578.812720761395}},
            {c, {1199.6400072795432, 51.94672823048859}}}},
          {"cv2 omnidir",
           with(Distortion::kOmni, {1.6, -0.12, 0.05, 1e-3, -5e-4}, {800, 790, 380, 250}),
           {{a, {413.1567395134131, 318.476074940449}},
            {b, {218.15031845531075, 343.2632251823061}},
            {d, {635.5902178576735, 75.3457436625327}},
            {e, {147.42350328890905, 623.2612587273625}}}},
          {"ds-msp",
           with(Distortion::kDoubleSphere, {-0.21, 0.59}, {280, 278, 380, 250}),
           {{a, {418.1591151718434, 329.21733195089826}},
            {b, {194.5359444475712, 357.41459884078165}},
            {d, {671.6195683727244, 49.55160437677023}},
            {e, {117.3911291537641, 673.6912764456681}}}},
          {"ds-msp",
           with(Distortion::kDoubleSphere, {0.35, 0.42}, {280, 278, 380, 250}),
           {{a, {402.4631018959959, 296.6328160788954}},
            {b, {267.5067665455043, 315.1523310423954}},
            {d, {569.4798141627352, 119.75865521011985}},
            {e, {183.64049153927226, 566.8050283826205}}}},
          {"pycolmap EUCM",
           with(Distortion::kEucm, {0.62, 1.08}, {210, 208, 380, 250}),
           {{a, {402.61617396141094, 296.83799836856707}},
            {b, {269.9240179790588, 313.599456278766}},
            {d, {553.598546520682, 130.9609966715323}},
            {e, {222.59379264500748, 503.3490385047022}}}},
          {"pycolmap FOV",
           with(Distortion::kFov, {0.93}, {300, 298, 320, 240}),
           {{a, {354.8564133992959, 312.3957143753861}},
            {b, {150.39532594467738, 338.2764861331675}},
            {d, {587.4454354708364, 56.07983129928641}},
            {e, {76.38793798465554, 633.2304701031019}}}},
          {"pycolmap DIVISION",
           with(Distortion::kDivision, {-0.21}, {300, 298, 320, 240}),
           {{a, {352.5614430491663, 307.629130502723}},
            {b, {155.2744636085775, 335.4492969201409}},
            {d, {602.5389120044774, 45.70016359076703}},
            {e, {22.459039569745926, 720.2807002945018}}}},
          {"projectaria-tools FISHEYE624, pycolmap RAD_TAN_THIN_PRISM_FISHEYE",
           with(Distortion::kFisheye624,
                {0.04, -0.02, -0.012, 0.014, -0.0042, 5e-4, -4.9e-4, 2.1e-4, -6e-4, 8e-5, 4e-4,
                 -1.1e-4},
                {240, 240, 320, 240}),
           {{a, {345.89508799289905, 294.18743189425084}},
            {b, {192.49665051832847, 314.37245217703816}},
            {d, {521.8490566689118, 100.20737316480884}},
            {e, {133.09155789710027, 543.1386144535898}}}}};
}

TEST(LensModel, ProjectsAsOtherPrograms) {
  for (const Reference& reference : references()) {
    for (const auto& [xy, pixel] : reference.pixels) {
      const auto seen = project(reference.camera, {2 * xy.x(), 2 * xy.y(), 2});
      ASSERT_TRUE(seen) << reference.by;
      EXPECT_LT((seen->pixel - pixel).norm(), 1e-9) << reference.by << " " << xy.transpose();
      const auto ray = unproject(reference.camera, pixel);
      ASSERT_TRUE(ray) << reference.by;
      EXPECT_LT((ray->ray.head<2>() - xy).norm(), 1e-9) << reference.by << " " << xy.transpose();
    }
  }
}

// Pixels of directions up to 125 degrees from the axis: other programs are right there with these
// models alone. OpenCV and FISHEYE624 of projectaria-tools mirror, pycolmap has none.
//   projectaria-tools 2.3.0: CameraProjection(KANNALA_BRANDT_K3, ...).project(point);
//   ds-msp 0.22.2: ds_project, models.eucm_math.eucm_project.
TEST(LensModel, ProjectsAsOtherProgramsBeyond90Degrees) {
  constexpr double kDegree = std::numbers::pi / 180;
  const std::vector<Eigen::Vector3d> directions = {
      bearing_at(89.5 * kDegree, 100 * kDegree), bearing_at(95 * kDegree, 200 * kDegree),
      bearing_at(105 * kDegree, 310 * kDegree), bearing_at(125 * kDegree, 45 * kDegree)};
  struct Wide {
    const char* by;
    Camera camera;
    std::vector<Eigen::Vector2d> pixels;
  };
  const std::vector<Wide> all = {
      {"projectaria-tools KANNALA_BRANDT_K3",
       test::fisheye_camera(),
       {{203.6405435302194, 547.776194596629},
        {-37.837652995356336, 150.340999017866},
        {472.6550116808825, -2.5680551905277866},
        {524.6620795425983, 526.6205040327127}}},
      {"ds-msp",
       with(Distortion::kDoubleSphere, {-0.21, 0.59}, {280, 278, 380, 250}),
       {{286.3724905557186, 777.1952207550996},
        {-153.27797641142456, 57.28909935369515},
        {773.9808888362992, -216.17436725780465}}},
      {"ds-msp",
       with(Distortion::kDoubleSphere, {0.35, 0.42}, {280, 278, 380, 250}),
       {{305.6867424759251, 668.4410590217633},
        {-67.92563115291046, 88.13291450189982},
        {757.6203501405147, -196.81590599580886},
        {1094.610963401048, 959.5065993767546}}},
      {"ds-msp",
       with(Distortion::kEucm, {0.62, 1.08}, {210, 208, 380, 250}),
       {{323.6957440496933, 566.276185965333},
        {58.269531693951876, 134.0149271650244},
        {619.5165382528332, -32.72617404427069},
        {670.6766980289415, 537.9083485239039}}}};
  for (const auto& [by, camera, pixels] : all) {
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto seen = project(camera, 3 * directions[i]);
      ASSERT_TRUE(seen) << by;
      EXPECT_LT((seen->pixel - pixels[i]).norm(), 1e-9) << by << " " << i;
      const auto back = bearing(camera, pixels[i]);
      ASSERT_TRUE(back) << by;
      EXPECT_LT((back->bearing - directions[i]).norm(), 1e-9) << by << " " << i;
    }
  }
}

// The other models by formulas of their own: Mei's camera is a unified one and so a double sphere,
// Aria's is equidistant without its further terms, FOV and division by their angles.
TEST(LensModel, TheOtherModelsGoOnBeyond90Degrees) {
  for (const double angle : {0.3, 1.5, kHalfPi, 1.65, 1.9}) {
    const Eigen::Vector3d b = bearing_at(angle, 0.7);
    const double alpha = 0.6, w = 0.93, lambda = -0.21;
    const auto ds = lens::distort_bearing_double_sphere({0, alpha}, b);
    const auto omni = lens::distort_bearing_omni({alpha / (1 - alpha)}, b);
    const auto eucm = lens::distort_bearing_eucm({alpha, 1}, b);
    EXPECT_TRUE(test::agree(omni->xy / (1 - alpha), ds->xy, 1e-14));
    EXPECT_TRUE(test::agree(eucm->xy, ds->xy, 1e-14));
    const auto aria =
        lens::distort_bearing_fisheye624({0.01, -0.02, 3e-3, -1e-4, 0, 0, 0, 0, 0, 0, 0, 0}, b);
    const auto equidistant = lens::distort_bearing_equidistant({0.01, -0.02, 3e-3, -1e-4}, b);
    EXPECT_TRUE(test::agree(aria->xy, equidistant->xy, 1e-14));
    const double r_fov = lens::distort_bearing_fov({w}, b)->xy.norm();
    EXPECT_NEAR(std::sin(r_fov * w) * std::cos(angle),
                2 * std::cos(r_fov * w) * std::sin(angle) * std::tan(w / 2), 1e-13);
    const double r = lens::distort_bearing_division({lambda}, b)->xy.norm();
    EXPECT_NEAR(std::sin(angle) * (1 + lambda * r * r), r * std::cos(angle), 1e-13);
  }
}

// A unified lens is a double sphere of xi = 0, an extended one of beta = 1, and, but for a factor,
// Mei's of xi = alpha / (1 - alpha).
TEST(LensModel, TheUnifiedLensesAgreeWhereTheyAreTheSame) {
  const double alpha = 0.6;
  const Eigen::Vector2d xy(1.3, -0.4);
  const auto ds = lens::distort_double_sphere({0, alpha}, xy);
  const auto eucm = lens::distort_eucm({alpha, 1}, xy);
  const auto omni = lens::distort_omni({alpha / (1 - alpha)}, xy);
  EXPECT_TRUE(test::agree(ds->xy, eucm->xy, 1e-14));
  EXPECT_TRUE(test::agree(omni->xy / (1 - alpha), eucm->xy, 1e-14));
  EXPECT_TRUE(test::agree(omni->d_xy / (1 - alpha), ds->d_xy, 1e-13));
}

TEST(LensModel, CoefficientsThatCannotBeAreNamed) {
  const auto fault = [](Distortion model, const std::vector<double>& k) {
    return coefficients_fault(model, k);
  };
  const auto expect = [](const std::string& found, const std::string& part) {
    EXPECT_NE(found.find(part), std::string::npos) << found;
  };
  for (const LensModel& model : kLensModels) {
    for (std::size_t count = 0; count <= 16; ++count) {
      const bool allowed = count == 0
                               ? model.counts[0] == 0
                               : std::ranges::find(model.counts, count) != model.counts.end();
      const std::string found = fault(model.distortion, std::vector<double>(count, 0.5));
      EXPECT_EQ(found.empty(), allowed) << found;
    }
    if (model.counts[0] == 0) continue;
    for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
      std::vector<double> k(model.counts[0], 0.5);
      k.back() = bad;
      expect(fault(model.distortion, k), "not finite");
    }
  }
  expect(fault(Distortion::kRadtan, {1, 2, 3}),
         "has 3 coefficients, expected 4, 5, 8 or 12 with the model radtan: k1 k2 p1 p2 [k3 [k4 k5 "
         "k6 [s1 s2 s3 s4]]]");
  expect(fault(Distortion::kRadtan, std::vector<double>(14, 1)), "tilted sensor");
  expect(fault(Distortion::kDoubleSphere, {-1, 0.5}), "xi above -1");
  expect(fault(Distortion::kDoubleSphere, {0, 1.1}), "alpha from 0 to 1");
  expect(fault(Distortion::kEucm, {-0.1, 1}), "alpha from 0 to 1");
  expect(fault(Distortion::kEucm, {0.5, 0}), "beta above 0");
  expect(fault(Distortion::kOmni, {-1.5}), "xi above -1");
  expect(fault(Distortion::kFov, {0}), "w above 0");
  expect(fault(Distortion::kFov, {3.2}), "below pi");
  expect(fault(Distortion{77}, {}), "not known");
}

TEST(LensModel, ZerosAtTheEndAreLeftOutWhereTheModelMayHaveFewer) {
  const auto size = [](Distortion model, const std::vector<double>& k) {
    return without_padding(model, k).size();
  };
  EXPECT_EQ(size(Distortion::kRadtan, {1, 0, 0, 0, 0}), 4u);
  EXPECT_EQ(size(Distortion::kRadtan, std::vector<double>(14, 0)), 4u);
  EXPECT_EQ(size(Distortion::kRadtan, {1, 0, 0, 0, 0, 0, 1}), 7u);
  EXPECT_EQ(size(Distortion::kRadtan, {1, 0, 0, 0, 0, 0, 1, 0}), 8u);
  EXPECT_EQ(size(Distortion::kRadtan, {1, 0}), 2u);
  EXPECT_EQ(size(Distortion::kDoubleSphere, {1, 0, 0}), 2u);
  EXPECT_EQ(size(Distortion::kOmni, {0, 0, 0, 0, 0}), 1u);
  EXPECT_EQ(size(Distortion::kNone, {0, 0}), 0u);
  EXPECT_EQ(size(Distortion::kNone, {0, 1, 0}), 2u);
}

TEST(LensModel, HasTheNamesOfOtherPrograms) {
  EXPECT_EQ(lens_model_named("Plumb_Bob"), Distortion::kRadtan);
  EXPECT_EQ(lens_model_named("radial-tangential"), Distortion::kRadtan);
  EXPECT_EQ(lens_model_named("fisheye"), Distortion::kEquidistant);
  EXPECT_EQ(lens_model_named("MEI"), Distortion::kOmni);
  for (const char* name : {"", " ", "rad", "tangential", "equi fisheye", "cubic"}) {
    EXPECT_FALSE(lens_model_named(name)) << name;
  }
  EXPECT_TRUE(lens_model_names().starts_with("none, radtan (also radial-tangential, "));
  EXPECT_NE(lens_model_coefficients().find("ds (xi alpha), "), std::string::npos);
}

}  // namespace
}  // namespace chasles
