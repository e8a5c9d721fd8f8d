#include <cstdio>
#include <string>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/run_drive_testing.hpp>
#include <chasles/filter/simulated_drive_testing.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/lie/se3.hpp>

// Results of lie/, imu/, camera/ and filter/ with all digits, for compare.py: the same source
// prints them on two machines. A line has a name and the numbers of one vector or matrix.
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

}  // namespace
}  // namespace chasles::test

int main() {
  chasles::test::Random random(7);
  chasles::test::print_lie(random);
  chasles::test::print_strapdown(random);
  chasles::test::print_cameras(random);
  chasles::test::print_filters();
  return 0;
}
