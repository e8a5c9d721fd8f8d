#pragma once

#include <cmath>
#include <random>

#include <chasles/camera/camera.hpp>
#include <chasles/imu/imu_sample.hpp>

// Shared by the tests of the parts of the initialisation.
namespace chasles::test {

inline constexpr ImuNoise kNoise{.accelerometer_noise_density = 0.01,
                                 .gyroscope_noise_density = 1e-3};

/// Normal random numbers by Box-Muller over a fixed generator: the same numbers on all platforms.
class Normal {
 public:
  explicit Normal(unsigned seed) : bits_(seed) {}
  double operator()() {
    const double u = uniform(), v = uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
  }
  Eigen::Vector3d vector(double sigma) {
    Eigen::Vector3d v;
    for (double& x : v) x = sigma * (*this)();
    return v;
  }

 private:
  double uniform() { return (static_cast<double>(bits_()) + 0.5) / 4294967296.0; }
  std::mt19937 bits_;
};

inline Camera test_camera() {
  Camera camera{
      .width = 640, .height = 480, .fx = 400, .fy = 410, .cx = 320, .cy = 240, .cam_T_imu = {}};
  camera.cam_T_imu = se3::exp((Vector6d() << 0.3, -0.2, 0.4, 0.05, 0.02, -0.1).finished());
  return camera;
}

}  // namespace chasles::test
