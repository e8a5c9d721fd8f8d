#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/filter/inertial_testing.hpp>
#include <chasles/loop/loop_closer.hpp>
#include <chasles/loop/map_testing.hpp>

/// A scene whose points have an appearance, and a run that sees it. Included by tests only.
namespace chasles::test {

inline constexpr int kScenePoints = 12;

/// A random texture of 6 cm cells as a function of the position on the surface [m].
class Surface {
 public:
  explicit Surface(Random& random) {
    for (double& grey : cells_) grey = random.uniform(20, 235);
  }
  double at(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d scaled = p / 0.06 + Eigen::Vector2d(16, 16);
    const int u = static_cast<int>(std::floor(scaled.x())), v = static_cast<int>(scaled.y());
    const double a = scaled.x() - u, b = scaled.y() - v;
    return (1 - b) * ((1 - a) * cell(u, v) + a * cell(u + 1, v)) +
           b * ((1 - a) * cell(u, v + 1) + a * cell(u + 1, v + 1));
  }

 private:
  double cell(int u, int v) const {
    return cells_[static_cast<std::size_t>(32 * (v & 31) + (u & 31))];
  }
  std::array<double, 32 * 32> cells_;
};

/// Twelve points 4 to 6 m before the first pose, each in the middle of a textured square that faces
/// the camera.
struct TexturedScene {
  explicit TexturedScene(std::uint64_t seed) {
    Random random(seed);
    Eigen::Matrix3d axes;  // z forward, x right, y down, of an IMU with x forward
    axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    camera.cam_T_imu = {axes, {0.05, -0.02, 0.1}};
    for (int k = 0; k < kScenePoints; ++k) {
      const double depth = random.uniform(4, 6);
      const Eigen::Vector2d pixel(75 + 110 * (k % 4) + random.uniform(-8, 8),
                                  70 + 110 * (k / 4) + random.uniform(-8, 8));
      const Eigen::Vector3d p_cam(depth * (pixel.x() - camera.cx) / camera.fx,
                                  depth * (pixel.y() - camera.cy) / camera.fy, depth);
      points.push_back(camera.cam_T_imu.inverse() * p_cam);
      surfaces.emplace_back(random);
    }
  }

  Eigen::Vector3d in_camera(int k, const SE3& scene_T_imu) const {
    return camera.cam_T_imu * (scene_T_imu.inverse() * points[static_cast<std::size_t>(k)]);
  }
  Eigen::Vector2d pixel(int k, const SE3& scene_T_imu) const {
    return project(camera, in_camera(k, scene_T_imu))->pixel;
  }

  GrayImage image(const SE3& scene_T_imu) const {
    GrayImage image{.width = camera.width, .height = camera.height, .pixels = {}};
    image.pixels.assign(static_cast<std::size_t>(image.width * image.height), 128);
    constexpr int kHalf = 50;
    for (int k = 0; k < kScenePoints; ++k) {
      const Eigen::Vector2d centre = pixel(k, scene_T_imu);
      const double metres = in_camera(k, scene_T_imu).z() / camera.fx;
      const auto u_0 = static_cast<int>(centre.x()), v_0 = static_cast<int>(centre.y());
      for (int v = std::max(0, v_0 - kHalf); v < std::min(image.height, v_0 + kHalf); ++v) {
        for (int u = std::max(0, u_0 - kHalf); u < std::min(image.width, u_0 + kHalf); ++u) {
          const double grey =
              surfaces[static_cast<std::size_t>(k)].at(metres * (Eigen::Vector2d(u, v) - centre));
          image.pixels[static_cast<std::size_t>(v * image.width + u)] =
              static_cast<std::uint8_t>(grey);
        }
      }
    }
    return image;
  }

  Camera camera{
      .width = 480, .height = 360, .fx = 400, .fy = 400, .cx = 240, .cy = 180, .cam_T_imu = {}};
  std::vector<Eigen::Vector3d> points;
  std::vector<Surface> surfaces;
};

inline int index_of(const Ekf& filter, LandmarkId id) {
  return static_cast<int>(std::ranges::find(filter.state().landmarks, id, &Landmark::id) -
                          filter.state().landmarks.begin());
}

/// A run that sees the scene. The errors of its filter are drawn from their covariance.
struct SceneRun {
  explicit SceneRun(const TexturedScene& s, std::uint64_t seed = 1,
                    std::shared_ptr<const LandmarkMap> prior = nullptr, SE3 nav = {})
      : scene(s),
        nav_T_scene(std::move(nav)),
        random(seed),
        filter(started()),
        closer({.recognise = Recognise::kAppearance}, {scene.camera}, std::move(prior)) {}

  Ekf started() {
    const State x{.world_T_imu = nav_T_scene,
                  .v_world = Eigen::Vector3d::Zero(),
                  .additive = Eigen::VectorXd::Zero(6)};
    const Eigen::MatrixXd P = 1e-6 * Eigen::MatrixXd::Identity(15, 15);
    return {kStandardChart,
            moved(kStandardChart, x, -normal_of(random, P)),
            P,
            {.map = Ekf::Map::kPast, .past = {.recalls = true, .records = true}}};
  }

  // The estimate moves by some centimetres more or less, as its covariance says.
  void move(const Eigen::Vector3d& by) {
    scene_T_imu.p += by;
    at.now += std::chrono::milliseconds(300);
    at.by_imu = at.now + from_seconds(0.01);
    ++at.frame;
    const State& x = filter.state();
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(15, 0.003);
    sigmas.segment<3>(3).setConstant(0.08);
    Prediction step{.world_T_imu = x.world_T_imu,
                    .v_world = x.v_world,
                    .additive = x.additive,
                    .F = Eigen::MatrixXd::Identity(15, 15),
                    .Q = sigmas.cwiseAbs2().asDiagonal()};
    step.world_T_imu.p += nav_T_scene.R * by + 0.08 * random.normal_vector(3);
    step.world_T_imu.R = so3::exp(0.003 * random.normal_vector(3)) * step.world_T_imu.R;
    filter.propagate(step);
  }

  // Tracks first, first + 1, ... of the points become landmarks.
  void initialise(LandmarkId first, int observations = 20) {
    for (int k = 0; k < kScenePoints; ++k) {
      const Eigen::Vector3d p_imu =
          scene_T_imu.inverse() * scene.points[static_cast<std::size_t>(k)];
      const Eigen::Vector3d arm =
          filter.state().world_T_imu.R * (p_imu + 0.01 * random.normal_vector(3));
      NewLandmark fresh;
      fresh.id = first + k;
      fresh.p_world = filter.state().world_T_imu.p + arm;
      fresh.d_pose << -hat(arm), Eigen::Matrix3d::Identity();
      fresh.noise = 1e-4 * Eigen::Matrix3d::Identity();
      fresh.observations = observations;
      filter.add({&fresh, 1});
      records.push_back({.seen = at.frame});
    }
  }

  FeatureFrame frame(LandmarkId first) {
    FeatureFrame frame{.time = at.now};
    for (int k = 0; k < kScenePoints; ++k) {
      frame.pixels.push_back(
          {.landmark = first + k,
           .camera = 0,
           .pixel = scene.pixel(k, scene_T_imu) + 0.5 * random.normal_vector(2)});
    }
    frame.images = std::make_shared<ImageFrame>(
        ImageFrame{.time = at.now, .images = {scene.image(scene_T_imu)}});
    return frame;
  }

  std::optional<LoopReturn> search(const FeatureFrame& frame) {
    std::vector<const PixelObservation*> observations;
    for (const PixelObservation& o : closer.renamed(frame)) observations.push_back(&o);
    return closer.search(frame, observations, filter, at);
  }
  std::optional<LoopReturn> search(LandmarkId first) { return search(frame(first)); }

  void leave(const std::vector<int>& indices) {
    closer.note_leaving(indices, filter, records, at.now);
    remove(records, indices);
    filter.retire(indices);
    closer.bar_others(filter);
  }
  void all_leave() {
    std::vector<int> all;
    for (int i = 0; i < static_cast<int>(records.size()); ++i) all.push_back(i);
    leave(all);
  }

  // Points 1 to 12 were seen and have left; 101 to 112 are the same ones, seen once from another
  // place.
  void come_back(bool leaves = true) {
    initialise(1);
    EXPECT_FALSE(search(1));
    if (leaves) all_leave();
    move({0, 0.3, 0});
    initialise(101);
    const FeatureFrame from_another_place = frame(101);
    EXPECT_FALSE(search(from_another_place)) << "a match is confirmed from a second place";
    observe(from_another_place.pixels);
    move({0, 0.2, 0});
  }

  void observe(std::span<const PixelObservation> pixels) {
    std::vector<Measurement> all;
    for (const PixelObservation& o : pixels) {
      all.push_back(
          *measure_pixel(scene.camera, 1, filter.state(), index_of(filter, o.landmark), o.pixel));
    }
    filter.update(all);
  }

  TexturedScene scene;
  SE3 nav_T_scene, scene_T_imu;
  Random random;
  Ekf filter;
  LandmarkRecords records;
  LoopCloser closer;
  FrameMoment at{.frame = 7, .now = from_seconds(10), .by_imu = from_seconds(10.01)};
};

inline bool can_return(const Ekf& filter, int number) {
  try {
    Ekf(filter).revive(std::array{number});
  } catch (const UsageError&) {
    return false;
  }
  return true;
}

/// The accepted pairs: (id of the track, id of the past landmark).
inline std::vector<std::pair<LandmarkId, LandmarkId>> matched_ids(const LoopReturn& found) {
  std::vector<std::pair<LandmarkId, LandmarkId>> result;
  for (const int i : found.accepted) {
    const ProposedMatch& match = found.innovations.matches[static_cast<std::size_t>(i)];
    result.emplace_back(found.observed[static_cast<std::size_t>(match.observation)].id,
                        found.candidates[static_cast<std::size_t>(match.landmark)].id);
  }
  return result;
}

}  // namespace chasles::test
