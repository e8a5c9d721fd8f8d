#include <cstdio>
#include <string>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/run_drive_testing.hpp>
#include <chasles/filter/simulated_drive_testing.hpp>
#include <chasles/frontend/frontend_testing.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/lie/se3.hpp>

// Results of lie/, imu/, camera/, filter/ and frontend/ with all digits, for compare.py: the same
// source prints them on two machines. A line has a name and the numbers of one vector or matrix.
namespace chasles::test {
namespace {

void print(const std::string& name, const Eigen::MatrixXd& values) {
  std::printf("%s", name.c_str());
  for (const double value : values.reshaped()) std::printf(" %.17g", value);
  std::printf("\n");
}

void print_lie(Random& random) {
  for (const double angle : angles_below_pi()) {
    Vector6d xi;
    xi << angle * random.axis(), random.normal_vector(3);
    const SE3 X = se3::exp(xi);
    print("lie.exp", X.R);
    print("lie.log", se3::log(X));
    print("lie.jacobian", se3::left_jacobian(xi));
  }
}

void print_strapdown(Random& random) {
  InertialState state;
  for (int i = 0; i < 1000; ++i) {
    const ImuInterval interval{.tau = 0.005,
                               .specific_force_imu = random.normal_vector(3),
                               .angular_rate_imu = random.normal_vector(3)};
    state = integrate(state, interval, {0, 0, -9.81});
  }
  print("imu.attitude", state.world_T_imu.R);
  print("imu.position", state.world_T_imu.p);
}

void print_cameras(Random& random) {
  for (const Distortion distortion : {Distortion::kRadtan, Distortion::kEquidistant}) {
    Camera camera{
        .width = 752, .height = 480, .fx = 458, .fy = 457, .cx = 367, .cy = 248, .cam_T_imu = {}};
    camera.distortion = distortion;
    camera.coefficients = {-0.03, 0.01, 1e-4, -2e-4};
    for (int i = 0; i < 100; ++i) {
      const double z = random.uniform(2, 9), y = random.uniform(-2, 2), x = random.uniform(-2, 2);
      const Eigen::Vector3d point(x, y, z);
      const auto seen = project(camera, point);
      if (!seen) continue;
      print("camera.pixel", seen->pixel);
      const auto back = unproject(camera, seen->pixel);
      if (back) print("camera.ray", back->ray);
    }
  }
}

// A drive past random points, 200 frames: rounding errors go through every update.
void print_filters() {
  const Drive drive =
      simulate_drive({.frames = 200, .initial_points = 30, .points_a_frame = 2, .seed = 5});
  for (const ErrorChart& chart : error_charts()) {
    DrivenFilter filter(chart, drive, {}, initial_covariance(Motion::kVelocityState, 0.01),
                        Ekf::Map::kHistory);
    filter.run();
    const std::string name = "filter." + std::string(chart.name);
    print(name + ".position", filter.ekf().state().world_T_imu.p);
    print(name + ".attitude", filter.ekf().state().world_T_imu.R);
    print(name + ".covariance", filter.ekf().core_covariance());
    for (const MapLandmark& landmark : filter.ekf().past().map())
      print(name + ".landmark", landmark.p_world);
  }
}

// Two cameras on an arc in a room of random texture: integer patches, corners and pyramids.
void print_tracks() {
  const std::vector<Camera> rig = euroc_rig();
  Frontend frontend({}, rig);
  SE3 last;
  for (int i = 0; i < 12; ++i) {
    const SE3 world_T_imu{.R = so3::exp({0.01 * i, 0.02 * i, -0.015 * i}),
                          .p = {0.04 * i, -0.03 * i, 0.02 * i}};
    ImageFrame frame{.time = from_seconds(0.05 * i), .images = {}};
    double grey = 0;
    for (const Camera& camera : rig) {
      frame.images.push_back(room().render(camera, world_T_imu * camera.cam_T_imu.inverse()));
      for (const std::uint8_t pixel : frame.images.back().pixels) grey += pixel;
    }
    print("frontend.image", Eigen::Matrix<double, 1, 1>(grey));
    const FeatureFrame tracks = frontend.process(frame, gyroscope(last, world_T_imu));
    last = world_T_imu;
    for (const PixelObservation& o : tracks.pixels) {
      print("frontend.track", Eigen::Vector2d(static_cast<double>(o.landmark), o.camera));
      print("frontend.pixel", o.pixel);
    }
  }
}

}  // namespace
}  // namespace chasles::test

int main() {
  chasles::test::Random random(7);
  chasles::test::print_lie(random);
  chasles::test::print_strapdown(random);
  chasles::test::print_cameras(random);
  chasles::test::print_filters();
  chasles::test::print_tracks();
  return 0;
}
