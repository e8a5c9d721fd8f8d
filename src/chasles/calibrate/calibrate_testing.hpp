#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/LU>

#include <chasles/calibrate/cameras_calibration.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/numeric/random.hpp>

/// Views of a calibration target with truth. Included by tests only.
namespace chasles::test {

/// As EuRoC's: 6 x 6 AprilTags of 88 mm.
inline Target april_board() {
  return {.kind = TargetKind::april_grid,
          .columns = 6,
          .rows = 6,
          .tag_size = 0.088,
          .tag_spacing = 0.3};
}

struct BoardScene {
  std::vector<Camera> cameras;  ///< cam_T_imu: cam_T_cam0
  std::size_t instants = 60;
  double pixel_sigma = 0.2;  ///< [px]
  double most_tilt = 0.9;    ///< of the board against the line of ray [rad]
  double seconds = 2;        ///< between two instants
};

/// cam0_T_target of a board that is held before a camera of the rig in turn, in all parts of its
/// image.
inline std::vector<SE3> board_poses(const BoardScene& scene, std::uint64_t seed) {
  const Random random = random_of_run(20261130, seed);
  const std::vector<Eigen::Vector3d> corners = april_board().corners();
  const Eigen::Vector3d centre = (corners.front() + corners.back()) / 2;
  std::uint64_t drawn = 0;
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * random.uniform(Stream::kStart, drawn++);
  };
  std::vector<SE3> poses;
  for (std::size_t k = 0; k < scene.instants; ++k) {
    const Camera& before = scene.cameras[k % scene.cameras.size()];
    std::optional<PixelBearing> ray;
    while (!ray) {
      ray = bearing(before, {uniform(0, before.width - 1.0), uniform(0, before.height - 1.0)});
    }
    // The board faces the camera, then turns about a line across the ray, and about its normal.
    const Eigen::Matrix3d facing = so3::between(Eigen::Vector3d::UnitZ(), ray->bearing) *
                                   so3::exp(Eigen::Vector3d(std::numbers::pi, 0, 0));
    const double about = uniform(0, 2 * std::numbers::pi);
    SE3 cam_T_target;
    cam_T_target.R = facing *
                     so3::exp(uniform(0, scene.most_tilt) *
                              Eigen::Vector3d(std::cos(about), std::sin(about), 0)) *
                     so3::exp(Eigen::Vector3d(0, 0, uniform(-0.4, 0.4)));
    cam_T_target.p = uniform(0.6, 1.4) * ray->bearing - cam_T_target.R * centre;
    poses.push_back(before.cam_T_imu.inverse() * cam_T_target);
  }
  return poses;
}

/// What the cameras see of it, with noise.
inline CamerasInput board_views(const BoardScene& scene, std::uint64_t seed) {
  const Random random = random_of_run(20261130, seed);
  const Target target = april_board();
  CamerasInput input{.corners = target.corners(),
                     .views = {},
                     .cameras = {},
                     .lenses = {},
                     .shape = printed_shape(target)};
  for (const Camera& camera : scene.cameras) {
    input.cameras.push_back({.width = camera.width, .height = camera.height, .cam_T_imu = {}});
    input.lenses.push_back(form_of(camera));
  }
  std::uint64_t noise = 0;
  const std::vector<SE3> poses = board_poses(scene, seed);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double seconds = scene.seconds * static_cast<double>(k);
    for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
      const Camera& camera = scene.cameras[c];
      TargetView view{.time = Time(static_cast<std::int64_t>(1e9 * seconds)),
                      .camera = static_cast<int>(c),
                      .ids = {},
                      .pixels = {}};
      for (std::size_t i = 0; i < input.corners.size(); ++i) {
        const auto image = project(camera, camera.cam_T_imu * (poses[k] * input.corners[i]));
        noise += 2;
        if (!image || !in_image(camera, image->pixel, 2)) continue;
        const Eigen::Vector2d error(random.normal(Stream::kPixelNoise, noise),
                                    random.normal(Stream::kPixelNoise, noise + 1));
        view.ids.push_back(static_cast<int>(i));
        view.pixels.push_back(image->pixel + scene.pixel_sigma * error);
      }
      if (view.ids.size() >= 20) input.views.push_back(std::move(view));
    }
  }
  return input;
}

/// The errors of a calibration, true minus found, in the order of its layout(). The target is as it
/// is drawn.
inline Eigen::VectorXd calibration_errors(const CamerasCalibration& found,
                                          const std::vector<Camera>& truth) {
  const CamerasLayout layout = found.layout();
  Eigen::VectorXd errors(layout.rows());
  for (std::size_t c = 0; c < truth.size(); ++c) {
    errors.segment(layout.lens_row(c), layout.lens(c).parameters()) =
        lens_parameters(truth[c]) - lens_parameters(found.cameras[c]);
    if (c == 0) continue;
    const SE3 &f = found.cameras[c].cam_T_imu, &t = truth[c].cam_T_imu;
    errors.segment<3>(layout.pose_row(c)) = so3::log(t.R * f.R.transpose());
    errors.segment<3>(layout.pose_row(c) + 3) = t.p - f.p;
  }
  errors.tail(layout.shape_rows()) = -found.shape;
  return errors;
}

/// A rig of up to four cameras: a pair, a fisheye and a pinhole.
inline std::vector<Camera> rig(std::size_t count) {
  std::vector<Camera> cameras = {euroc_camera(), euroc_camera(), fisheye_camera(),
                                 pinhole_camera()};
  cameras[1].cam_T_imu = {so3::exp(Eigen::Vector3d(0.01, 0.02, -0.01)), {-0.11, 0.001, 0.002}};
  cameras[2].cam_T_imu = {so3::exp(Eigen::Vector3d(0.3, -0.2, 0.1)), {0.05, 0.1, 0.02}};
  cameras[3].cam_T_imu = {so3::exp(Eigen::Vector3d(-0.1, 0.1, 0.02)), {0.2, 0.02, -0.05}};
  cameras.resize(count);
  return cameras;
}

/// With xi at 0.35 there is another double sphere, xi -0.15, with the same pixels to the noise.
inline bool has_twin(const Camera& camera) {
  return camera.distortion == Distortion::kDoubleSphere && camera.coefficients[0] > 0;
}

/// Errors and their covariance.
struct ErrorsOfRun {
  Eigen::VectorXd errors;
  Eigen::MatrixXd covariance;
};

/// In the coordinates of the search, in which the valley of xi is straight. `row_of`: of a camera's
/// lens.
template <typename RowOf>
ErrorsOfRun in_search_coordinates(ErrorsOfRun run, const std::vector<Camera>& found,
                                  const std::vector<Camera>& truth, const RowOf& row_of) {
  Eigen::MatrixXd to = Eigen::MatrixXd::Identity(run.errors.size(), run.errors.size());
  for (std::size_t c = 0; c < truth.size(); ++c) {
    const LensForm lens = form_of(found[c]);
    const int row = row_of(c), n = lens.parameters();
    const Eigen::VectorXd at = search_coordinates(lens, lens_parameters(found[c]));
    run.errors.segment(row, n) = search_coordinates(lens, lens_parameters(truth[c])) - at;
    to.block(row, row, n, n) = by_search_coordinates(lens, at).inverse();
  }
  run.covariance = to * run.covariance * to.transpose();
  return run;
}

}  // namespace chasles::test
