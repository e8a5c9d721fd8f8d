#pragma once

#include <numbers>
#include <vector>

#include <chasles/camera/camera.hpp>

/// Cameras of public data sets, one of each lens model. Included by tests only.
namespace chasles::test {

/// KITTI's focal length and image size. fx and fy differ, so that tests detect a confusion of the
/// two.
inline Camera pinhole_camera() {
  return {.width = 1241,
          .height = 376,
          .fx = 718.856,
          .fy = 711.2,
          .cx = 607.193,
          .cy = 185.216,
          .cam_T_imu = {}};
}

/// cam0 of EuRoC MAV.
inline Camera euroc_camera() {
  return {.width = 752,
          .height = 480,
          .fx = 458.654,
          .fy = 457.296,
          .cx = 367.215,
          .cy = 248.375,
          .distortion = Distortion::kRadtan,
          .coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
          .cam_T_imu = {}};
}

/// KITTI's unrectified grey camera of 2011_09_26, with five coefficients.
inline Camera five_coefficient_camera() {
  return {.width = 1392,
          .height = 512,
          .fx = 984.2439,
          .fy = 980.8141,
          .cx = 690.0,
          .cy = 233.1966,
          .distortion = Distortion::kRadtan,
          .coefficients = {-0.3728755, 0.2037299, 0.002219027, 0.001383707, -0.07233722},
          .cam_T_imu = {}};
}

/// As cam0 of TUM-VI; the rays of its image corners point backward.
inline Camera fisheye_camera() {
  return {.width = 512,
          .height = 512,
          .fx = 190.97847715,
          .fy = 190.9733,
          .cx = 254.93170606,
          .cy = 256.89744255,
          .distortion = Distortion::kEquidistant,
          .coefficients = {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673},
          .cam_T_imu = {}};
}

/// A lens for the tests of all models.
struct Lens {
  Camera camera;
  double largest_angle;  ///< up to which the tests go, before its fold [rad]
  bool sees_all = true;  ///< whether each pixel of the image has a ray
};

inline Lens lens_of(Distortion model, LensCoefficients coefficients, double focal,
                    double largest_angle, bool sees_all = true) {
  return {.camera = {.width = 640,
                     .height = 480,
                     .fx = focal,
                     .fy = focal - 2,
                     .cx = 322,
                     .cy = 237,
                     .distortion = model,
                     .coefficients = coefficients,
                     .cam_T_imu = {}},
          .largest_angle = largest_angle,
          .sees_all = sees_all};
}

/// At least one lens of each model of kLensModels.
inline std::vector<Lens> lenses() {
  return {{pinhole_camera(), 1.3},
          {euroc_camera(), 0.9},
          {five_coefficient_camera(), 0.7},
          // As a depth camera states its colour sensor.
          lens_of(Distortion::kRadtan, {0.52, -2.7, 8e-4, -3e-4, 1.6, 0.39, -2.5, 1.52}, 310, 0.9),
          lens_of(Distortion::kRadtan,
                  {0.52, -2.7, 8e-4, -3e-4, 1.6, 0.39, -2.5, 1.52, 1.2e-3, -4e-4, -9e-4, 3e-4}, 310,
                  0.9),
          {fisheye_camera(), 1.5, false},
          lens_of(Distortion::kDoubleSphere, {-0.21, 0.59}, 230, 1.5),
          lens_of(Distortion::kDoubleSphere, {0.35, 0.42}, 400, 1.5),
          lens_of(Distortion::kEucm, {0.62, 1.08}, 320, 1.5),
          lens_of(Distortion::kOmni, {1.6, -0.12, 0.05, 1e-3, -5e-4}, 800, 1.5),
          lens_of(Distortion::kOmni, {0.8}, 500, 1.5),
          lens_of(Distortion::kFov, {0.93}, 300, 1.5),
          lens_of(Distortion::kDivision, {-0.21}, 300, 1.5),
          lens_of(Distortion::kDivision, {0.1}, 400, 0.9),
          lens_of(Distortion::kFisheye624,
                  {0.04, -0.02, -0.012, 0.014, -0.0042, 5e-4, -4.9e-4, 2.1e-4, -6e-4, 8e-5, 4e-4,
                   -1.1e-4},
                  300, 1.5)};
}

/// Up to which angle from the axis the tests of directions go [rad]; none for models that end
/// before 90 degrees.
inline double widest_angle(const Camera& camera) {
  constexpr double kDegree = std::numbers::pi / 180;
  switch (camera.distortion) {
    case Distortion::kNone:
    case Distortion::kRadtan:
      return 0;
    case Distortion::kEquidistant:
      return 150 * kDegree;
    case Distortion::kDivision:
      return camera.coefficients[0] < 0 ? 110 * kDegree : 0;
    default:
      return 110 * kDegree;
  }
}

}  // namespace chasles::test
