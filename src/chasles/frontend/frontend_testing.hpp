#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>

/// A room whose walls have a smooth random texture, rendered from inside for any camera. The point
/// of a pixel, and its projection into another view, are known exactly. Included by tests and the
/// bench only.
namespace chasles::test {

/// A square periodic grey texture, smooth over a few texels, with strong contrast.
class Texture {
 public:
  static constexpr int kSide = 1024;

  explicit Texture(std::uint64_t seed) : values_(std::size_t{kSide} * kSide) {
    Random random(seed);
    add_noise(6, 70, random);
    add_noise(18, 50, random);
    add_noise(64, 25, random);
    for (float& v : values_) v = std::min(250.0F, std::max(5.0F, v + 128));
  }

  /// Interpolated value at (x, y) [texels].
  float at(double x, double y) const {
    const double x0 = std::floor(x), y0 = std::floor(y);
    const auto u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
    const auto i = static_cast<std::int64_t>(x0), j = static_cast<std::int64_t>(y0);
    const float above = value(i, j) + u * (value(i + 1, j) - value(i, j));
    const float below = value(i, j + 1) + u * (value(i + 1, j + 1) - value(i, j + 1));
    return above + v * (below - above);
  }

 private:
  float value(std::int64_t i, std::int64_t j) const {
    return values_[static_cast<std::size_t>(j & (kSide - 1)) * kSide +
                   static_cast<std::size_t>(i & (kSide - 1))];
  }

  /// Random numbers on a lattice with this spacing [texels], interpolated smoothly.
  void add_noise(int texels, float amplitude, Random& random) {
    const int cells = kSide / texels;
    std::vector<float> lattice(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    for (float& v : lattice) v = amplitude * static_cast<float>(random.uniform(-1, 1));
    const auto smooth = [](double t) { return static_cast<float>(t * t * (3 - 2 * t)); };
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const double a = x * cells / double{kSide}, b = y * cells / double{kSide};
        const int i = static_cast<int>(a), j = static_cast<int>(b);
        const float u = smooth(a - i), v = smooth(b - j);
        const auto knot = [&](int p, int q) {
          return lattice[static_cast<std::size_t>((q % cells) * cells + p % cells)];
        };
        const float above = knot(i, j) + u * (knot(i + 1, j) - knot(i, j));
        const float below = knot(i, j + 1) + u * (knot(i + 1, j + 1) - knot(i, j + 1));
        values_[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)] +=
            above + v * (below - above);
      }
    }
  }

  std::vector<float> values_;
};

/// A room around the origin of the world.
class Room {
 public:
  explicit Room(Eigen::Vector3d half = {3, 3, 3}, std::uint64_t seed = 1)
      : half_(std::move(half)), texture_(seed) {}

  /// The image of a camera at this pose; grey = gain * texture + offset + noise.
  GrayImage render(const Camera& camera, const SE3& world_T_cam, double gain = 1, double offset = 0,
                   double noise = 0, std::uint64_t noise_seed = 1) const {
    GrayImage image{.width = camera.width, .height = camera.height, .pixels = {}};
    image.pixels.resize(static_cast<std::size_t>(camera.width) *
                        static_cast<std::size_t>(camera.height));
    Random random(noise_seed);
    const std::vector<Eigen::Vector3d>& rays = rays_of(camera);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (rays[i].isZero()) continue;
      const double grey = gain * double{grey_at(hit(world_T_cam, rays[i]))} + offset +
                          (noise > 0 ? noise * random.normal() : 0);
      image.pixels[i] = static_cast<std::uint8_t>(std::min(255.0, std::max(0.0, grey)) + 0.5);
    }
    return image;
  }

  /// The point of the wall on a ray of the camera.
  Eigen::Vector3d hit(const SE3& world_T_cam, const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d d = world_T_cam.R * ray;
    double nearest = 1e9;
    for (int a = 0; a < 3; ++a) {
      if (d[a] == 0) continue;
      nearest = std::min(nearest, ((d[a] > 0 ? half_[a] : -half_[a]) - world_T_cam.p[a]) / d[a]);
    }
    return world_T_cam.p + nearest * d;
  }

  /// The pixel in another view of the point at `pixel` in this one; none if outside its image.
  std::optional<Eigen::Vector2d> true_pixel(const Camera& from, const SE3& world_T_from,
                                            const Eigen::Vector2d& pixel, const Camera& to,
                                            const SE3& world_T_to) const {
    const auto ray = wide_ray(from, pixel);
    if (!ray) return std::nullopt;
    const auto seen = project(to, world_T_to.inverse() * hit(world_T_from, ray->ray));
    if (!seen || !in_image(to, seen->pixel)) return std::nullopt;
    return seen->pixel;
  }

 private:
  float grey_at(const Eigen::Vector3d& p) const {
    int wall = 0;
    for (int a = 1; a < 3; ++a) {
      if (std::abs(p[a]) / half_[a] > std::abs(p[wall]) / half_[wall]) wall = a;
    }
    const double side = p[wall] > 0 ? 331 : 0;
    constexpr double kTexels = 170;  // per metre
    return texture_.at(kTexels * p[(wall + 1) % 3] + 117 * wall + side,
                       kTexels * p[(wall + 2) % 3] + side);
  }

  /// The rays of all pixels; zero where there is none.
  const std::vector<Eigen::Vector3d>& rays_of(const Camera& camera) const {
    for (const auto& known : rays_) {
      if (known.width == camera.width && known.fx == camera.fx &&
          known.coefficients == camera.coefficients) {
        return known.rays;
      }
    }
    Rays& added = rays_.emplace_back();
    added.width = camera.width;
    added.fx = camera.fx;
    added.coefficients = camera.coefficients;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const auto ray = wide_ray(camera, Eigen::Vector2d(x, y));
        added.rays.push_back(ray ? ray->ray : Eigen::Vector3d::Zero());
      }
    }
    return added.rays;
  }

  struct Rays {
    int width = 0;
    double fx = 0;
    LensCoefficients coefficients;
    std::vector<Eigen::Vector3d> rays;
  };

  Eigen::Vector3d half_;
  Texture texture_;
  mutable std::vector<Rays> rays_;
};

inline const Room& room() {
  static const Room shared;
  return shared;
}

/// EuRoC's stereo rig, from its calibration: two cameras 11 cm apart, both rotated against the IMU.
inline std::vector<Camera> euroc_rig() {
  Camera cam0 = euroc_camera(), cam1 = euroc_camera();
  cam1.fx = 457.587;
  cam1.fy = 456.134;
  cam1.cx = 379.999;
  cam1.cy = 255.238;
  cam1.coefficients = {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05};
  SE3 imu_T_cam0, imu_T_cam1;
  imu_T_cam0.R << 0.0148655429818, -0.999880929698, 0.00414029679422,  //
      0.999557249008, 0.0149672133247, 0.025715529948,                 //
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  imu_T_cam0.p << -0.0216401454975, -0.064676986768, 0.00981073058949;
  imu_T_cam1.R << 0.0125552670891, -0.999755099723, 0.0182237714554,  //
      0.999598781151, 0.0130119051815, 0.0251588363115,               //
      -0.0253898008918, 0.0179005838253, 0.999517347078;
  imu_T_cam1.p << -0.0198435579556, 0.0453689425024, 0.00786212447038;
  cam0.cam_T_imu = imu_T_cam0.inverse();
  cam1.cam_T_imu = imu_T_cam1.inverse();
  return {cam0, cam1};
}

/// The rotation that a perfect gyroscope measures between two poses of the IMU.
inline RotationPrior gyroscope(const SE3& world_T_last, const SE3& world_T_now) {
  return {.now_R_last_imu = world_T_now.R.transpose() * world_T_last.R, .trusted = true};
}

/// A walk through the room with sway, yaw and pitch, at 20 frames per second.
inline SE3 walk_pose(int frame) {
  const double t = 0.05 * frame;
  SE3 world_T_imu;
  world_T_imu.p << 0.8 * std::sin(0.7 * t), 0.5 * std::sin(0.9 * t + 1), 0.6 * std::sin(1.1 * t);
  const Eigen::Vector3d turn(0.15 * std::sin(1.7 * t), 0.6 * std::sin(0.5 * t),
                             0.2 * std::sin(1.3 * t));
  world_T_imu.R = so3::exp(turn);
  return world_T_imu;
}

/// One image per camera from a pose of the IMU.
inline ImageFrame render_frame(const Room& in, const std::vector<Camera>& rig,
                               const SE3& world_T_imu, Time time) {
  ImageFrame frame{.time = time, .images = {}};
  for (const Camera& camera : rig) {
    frame.images.push_back(in.render(camera, world_T_imu * camera.cam_T_imu.inverse()));
  }
  return frame;
}

/// The folder of the EuRoC recordings, if present.
inline std::optional<std::filesystem::path> euroc_folder() {
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path folder =
      given ? given : std::filesystem::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "data";
  if (!std::filesystem::exists(folder / "euroc" / "MH_01_easy_17s")) return std::nullopt;
  return folder / "euroc";
}

}  // namespace chasles::test
