#pragma once

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
          .coefficients = {-0.3728755, 0.2037299, 0.002219027, 0.001383707},
          .cam_T_imu = {},
          .radtan_k3 = -0.07233722};
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

}  // namespace chasles::test
