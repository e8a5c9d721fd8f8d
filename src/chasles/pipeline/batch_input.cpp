#include <Eigen/Geometry>

#include <chasles/pipeline/batch_input.hpp>
#include <chasles/slam/imu_in_use.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/start_covariance.hpp>

namespace chasles {
namespace {

constexpr int kPlaceRow = 2;  // of [theta, dp, ...]: rotation about z, then position

// What an error of the place does to a point.
Eigen::Matrix<double, 3, 4> moved(const Eigen::Vector3d& p, const Place& place) {
  Eigen::Matrix<double, 3, 4> J;
  J << Eigen::Vector3d::UnitZ().cross(p - place.origin), Eigen::Matrix3d::Identity();
  return J;
}

// Rows of the errors of the calibration.
std::vector<int> considered_errors(const InertialSlamSettings& settings,
                                   const Calibration& calibration) {
  State x;
  x.imu_T_camera = calibration.imu_T_camera;
  x.time_offset = calibration.time_offset;
  x.intrinsics = calibration.intrinsics;
  x.imu = calibration.imu;
  std::vector<int> rows = considered_rows(settings, x);
  for (int& row : rows) row -= x.calibration_row();
  return rows;
}

}  // namespace

InertialBatchInput batch_input(const InertialSensors& sensors, const InertialSlamSettings& settings,
                               const InertialStart& start) {
  const auto calibration = stated_calibration(settings, sensors.cameras);
  return {
      .cameras = sensors.cameras,
      .noise = noise_in_use(settings, sensors.noise),
      .imu = imu_in_use(settings, sensors.imu),
      .pixel_sigma = settings.track_sigma.value_or(sensors.pixel_sigma),
      .match_sigma = settings.match_sigma.value_or(0),
      .time_offset = from_seconds(settings.initial_time_offset()),
      .calibration = calibration,
      .considered = calibration ? considered_errors(settings, *calibration) : std::vector<int>(),
      .samples = {},
      .frames = {},
      .start = start,
      .start_covariance = start_covariance(settings, start)};
}

Place take_place(InertialBatchInput& input) {
  Matrix15d& P = input.start_covariance;
  const Place place{.origin = input.start.nav_T_imu.p,
                    .covariance = P.block<4, 4>(kPlaceRow, kPlaceRow)};
  P.middleRows<4>(kPlaceRow).setZero();
  P.middleCols<4>(kPlaceRow).setZero();
  return place;
}

void add_place(const Place& place, Estimate& e) {
  Eigen::Matrix<double, 15, 4> J = Eigen::Matrix<double, 15, 4>::Zero();
  J(kPlaceRow, 0) = 1;
  J.middleRows<3>(3) = moved(e.world_T_imu.p, place);
  J.block<3, 1>(6, 0) = Eigen::Vector3d::UnitZ().cross(*e.v_world);
  e.covariance += J * place.covariance * J.transpose();
}

void add_place(const Place& place, MapLandmark& landmark) {
  const auto J = moved(landmark.p_world, place);
  landmark.covariance += J * place.covariance * J.transpose();
}

InertialStart start_at(const Estimate& e, const std::optional<InertialStart>& of_filter) {
  InertialStart start{.time = e.time,
                      .nav_T_imu = e.world_T_imu,
                      .v_nav = *e.v_world,
                      .accelerometer_bias = e.additive.head<3>(),
                      .gyroscope_bias = e.additive.tail<3>(),
                      .covariance = e.covariance};
  if (!of_filter || of_filter->by_imu.size() == 0 || of_filter->time != e.time) return start;
  start.covariance = of_filter->covariance;
  start.by_imu = of_filter->by_imu;
  start.calibration = e.calibration;
  return start;
}

void begin_at(const Calibration& calibration, const std::vector<Camera>& cameras,
              const Estimate& first, InertialBatchInput& input) {
  input.cameras = calibrated(cameras, calibration);
  if (!calibration.time_offset) return;
  const Time stated = input.time_offset;
  input.time_offset = from_seconds(*calibration.time_offset);
  const bool has_own = first.calibration && first.calibration->time_offset;
  const Time later =
      input.time_offset - (has_own ? from_seconds(*first.calibration->time_offset) : stated);
  input.start.time += later;
  input.start.nav_T_imu.p += to_seconds(later) * input.start.v_nav;
}

TimedMotion timed_motion(const Estimate& e, Time time_offset) {
  TimedMotion motion{.time = e.time,
                     .state = {.world_T_imu = e.world_T_imu,
                               .v_world = *e.v_world,
                               .accelerometer_bias = e.additive.head<3>(),
                               .gyroscope_bias = e.additive.tail<3>()}};
  if (!e.calibration || !e.calibration->time_offset) return motion;
  const Time later = time_offset - from_seconds(*e.calibration->time_offset);
  motion.time += later;
  motion.state.world_T_imu.p += to_seconds(later) * motion.state.v_world;
  return motion;
}

}  // namespace chasles
