#include <algorithm>
#include <utility>

#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/render_sensor.hpp>

namespace chasles {
namespace {

class RenderedImages : public ImageSource {
 public:
  RenderedImages(const InertialSettings& settings, std::uint64_t run, PaintedWorld world,
                 const std::vector<Camera>& cameras, Spline motion, std::vector<Time> times)
      : settings_(settings),
        sensor_(settings, run),
        world_(std::move(world)),
        motion_(std::move(motion)),
        times_(std::move(times)) {
    for (const Camera& camera : cameras) {
      faces_.push_back(make_faces(camera));
      imu_T_cam_.push_back(camera.cam_T_imu.inverse());
      shutters_.push_back(camera.shutter);
    }
  }

  std::size_t size() const override { return times_.size(); }
  Time time(std::size_t i) const override { return times_[i]; }

  ImageFrame read(std::size_t i) const override { return read_cameras(i, faces_.size()); }
  ImageFrame read_cameras(std::size_t i, std::size_t cameras) const override {
    ImageFrame frame{.time = times_[i], .images = {}};
    const double time = to_seconds(times_[i] - motion_.start);
    for (std::size_t camera = 0; camera < std::min(cameras, faces_.size()); ++camera) {
      const RayTable& rays = faces_[camera].front().rays;
      frame.images.push_back(sensor_.expose(light_at(time, camera), rays.width, rays.height, time,
                                            static_cast<std::uint32_t>(i),
                                            static_cast<std::uint32_t>(camera)));
    }
    return frame;
  }

 private:
  std::vector<float> light_of(double time, std::size_t camera) const {
    const std::vector<RayFace>& faces = faces_[camera];
    if (faces.size() == 1) return light_of_face(time, camera, faces.front());
    std::vector<float> light(faces.front().rays.x.size(), 0.0F);
    for (const RayFace& face : faces) {
      const std::vector<float> some = light_of_face(time, camera, face);
      for (const std::size_t pixel : face.pixels) light[pixel] = some[pixel];
    }
    return light;
  }

  std::vector<float> light_of_face(double time, std::size_t camera, const RayFace& face) const {
    std::vector<float> light;
    if (shutters_[camera].is_rolling()) return light_of_lines(time, camera, face);
    render(world_, face.rays, world_T_face(time, camera, face), light);
    return light;
  }

  SE3 world_T_face(double time, std::size_t camera, const RayFace& face) const {
    SE3 pose = motion_at(motion_, time).world_T_imu * imu_T_cam_[camera];
    pose.R = pose.R * face.cam_R_face;
    return pose;
  }

  // Some lines at a time: from the place of their middle, each with its own attitude.
  std::vector<float> light_of_lines(double time, std::size_t camera, const RayFace& face) const {
    const RayTable& rays = face.rays;
    const Shutter& shutter = shutters_[camera];
    const bool are_rows =
        shutter.direction == ReadoutDirection::kDown || shutter.direction == ReadoutDirection::kUp;
    const bool backwards =
        shutter.direction == ReadoutDirection::kUp || shutter.direction == ReadoutDirection::kLeft;
    const int count = are_rows ? rays.height : rays.width;
    const auto pose_at = [&](double line) {
      const double order = backwards ? count - 1 - line : line;
      return world_T_face(time + shutter.readout * order / count, camera, face);
    };
    std::vector<float> light(rays.x.size()), some;
    for (int first = 0; first < count; first += kBlockEdge) {
      const Lines lines{first, std::min(first + kBlockEdge, count), are_rows};
      const SE3 middle = pose_at((lines.first + lines.last - 1) / 2.0);
      std::vector<Eigen::Matrix3f> rotations;
      for (int line = lines.first; line < lines.last; ++line) {
        rotations.emplace_back((middle.R.transpose() * pose_at(line).R).cast<float>());
      }
      const RayTable part = rotated_lines(rays, lines, rotations);
      render(world_, part, middle, some);
      for (int v = 0; v < part.height; ++v) {
        const std::size_t to = are_rows ? rays.at(0, v + first) : rays.at(first, v);
        std::copy_n(some.begin() + static_cast<std::ptrdiff_t>(part.at(0, v)), part.width,
                    light.begin() + static_cast<std::ptrdiff_t>(to));
      }
    }
    return light;
  }

  // The mean over the exposure; the frame's time is its middle, that of the first line.
  std::vector<float> light_at(double time, std::size_t camera) const {
    if (settings_.exposure_time == 0) return light_of(time, camera);
    std::vector<float> sum;
    const auto part = 1.0F / static_cast<float>(settings_.blur_samples);
    for (int k = 0; k < settings_.blur_samples; ++k) {
      const double shift = ((k + 0.5) / settings_.blur_samples - 0.5) * settings_.exposure_time;
      const double at = std::clamp(time + shift, 0.0, motion_.duration);
      const std::vector<float> light = light_of(at, camera);
      sum.resize(light.size());
      for (std::size_t i = 0; i < light.size(); ++i) sum[i] += part * light[i];
    }
    return sum;
  }

  InertialSettings settings_;
  RenderSensor sensor_;
  PaintedWorld world_;
  Spline motion_;
  std::vector<Time> times_;
  std::vector<std::vector<RayFace>> faces_;
  std::vector<SE3> imu_T_cam_;
  std::vector<Shutter> shutters_;
};

// The last entry that is not later, or the first.
TrueMotion biases_at(const std::vector<TrueMotion>& truth, Time time) {
  const auto next = std::ranges::upper_bound(truth, time, {}, &TrueMotion::time);
  return next == truth.begin() ? *next : *std::prev(next);
}

void take_true_biases(const InertialScene& scene, const Spline& motion, Recording& recording) {
  if (scene.imu.empty() || scene.imu_truth.empty()) return;
  for (const auto& [time, pose] : recording.truth) {
    TrueMotion now = biases_at(scene.imu_truth, time);
    now.time = time;
    now.v_world = motion_at(motion, to_seconds(time - motion.start)).v_world;
    recording.true_motion.push_back(now);
  }
}

}  // namespace

std::shared_ptr<const ImageSource> make_image_source(const InertialSettings& settings,
                                                     std::uint64_t run, PaintedWorld world,
                                                     const std::vector<Camera>& cameras,
                                                     const Spline& motion,
                                                     const std::vector<Time>& times) {
  return std::make_shared<RenderedImages>(settings, run, std::move(world), cameras, motion, times);
}

Recording render_inertial(const InertialScene& scene, std::uint64_t run) {
  const Spline motion = inertial_motion(scene);
  Recording recording = simulate_sensors(scene, motion, run);
  take_true_biases(scene, motion, recording);
  std::vector<Time> times;
  for (const auto& [time, pose] : recording.truth) times.push_back(time);
  const InertialSettings& settings = scene.settings;
  recording.images = make_image_source(
      settings, run,
      paint_world(make_render_world(settings, motion), settings.texel_size, settings.seed,
                  {.period = settings.texture_period, .changed = settings.texture_changed}),
      recording.cameras, motion, times);
  recording.exact_calibration = true;
  return recording;
}

}  // namespace chasles
