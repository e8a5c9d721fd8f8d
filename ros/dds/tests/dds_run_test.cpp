#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chasles/lie/so3.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/run.hpp>

#include "cdr.hpp"
#include "cli_test.hpp"
#include "messages_testing.hpp"
#include "process.hpp"
#include "robot_driver.hpp"

// The bridge and a robot whose drivers speak another implementation of DDS: its estimates are those
// of the command, and its messages say what its run folder says.
namespace chasles::test {
namespace {

using std::chrono::seconds;

// Tests may run at the same time, each in a process of its own.
const int kDomain = 100 + ::getpid() % 100;

const SE3 kBaseTImu{so3::exp(Eigen::Vector3d(0.1, -0.2, 0.3)), {0.3, -0.1, 0.2}};

std::string base_T_imu_text() {
  const Eigen::Quaterniond q(kBaseTImu.R);
  const Eigen::Vector3d& p = kBaseTImu.p;
  std::ostringstream text;
  text.precision(17);
  text << p.x() << ',' << p.y() << ',' << p.z() << ',' << q.x() << ',' << q.y() << ',' << q.z()
       << ',' << q.w();
  return text.str();
}

// A stamp of 0 is none, and the simulated time begins there: the walk is one second later.
void begin_later(const std::filesystem::path& table) {
  std::istringstream lines(slurp(table));
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t comma = line.find(',');
    const bool header = line.starts_with('#');
    text += header ? line
                   : std::to_string(std::stoll(line.substr(0, comma)) + 1'000'000'000) +
                         line.substr(comma);
    text += '\n';
  }
  spill(table, text);
}

// Two cameras, of which the second is compressed.
void simulate_walk(const Scratch& folder) {
  const Outcome made =
      chasles(folder,
              "simulate hallway --images -o walk --quiet --set sections=1 --set hall_length=6 "
              "--set rest_duration=1 --set frame_rate=10 --set cameras=2 --set focal_length=160 "
              "--set image_width=240 --set image_height=180 --set center_u=119.5 "
              "--set center_v=89.5");
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* sensor : {"cam0", "cam1", "imu0", "state_groundtruth_estimate0"}) {
    begin_later(folder / (std::string("walk/mav0/") + sensor + "/data.csv"));
  }
}

std::vector<std::string> bridge_command(const Scratch& folder,
                                        const std::vector<std::string>& more) {
  std::vector<std::string> command{
      CHASLES_DDS_BINARY, folder / "walk", "--domain", std::to_string(kDomain),
      "--camera",         camera_topic(0), "--camera", camera_topic(1)};
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

/// The topics of the bridge.
struct Listener {
  explicit Listener(FastClient& client)
      : odometry(client, {"rt/odometry", "nav_msgs::msg::dds_::Odometry_"}, true),
        tf(client, {"rt/tf", "tf2_msgs::msg::dds_::TFMessage_"}, true),
        px4(client, {"rt/fmu/in/vehicle_visual_odometry", "px4_msgs::msg::dds_::VehicleOdometry_"},
            false),
        points(client, {"rt/points", "sensor_msgs::msg::dds_::PointCloud2_"}, true),
        diagnostics(client, {"rt/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_"},
                    true) {}
  FastReader odometry, tf;
  FastReader px4;  ///< best effort, as PX4's
  FastReader points, diagnostics;
};

const RunState* state_at(const Run& run, Time time) {
  const auto found = std::ranges::find(run.states, time, &RunState::time);
  return found == run.states.end() ? nullptr : &*found;
}

// The base's error from that of the IMU, by differences of exp and of the motion.
Matrix6d base_covariance(const RunState& s) {
  Matrix6d J;  // of [dp; theta] by [theta; dp]
  const Eigen::Vector3d arm = kBaseTImu.inverse().p;
  const double h = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Matrix3d turned = so3::exp(h * Eigen::Vector3d::Unit(i)) * s.world_T_imu.R;
    J.block<3, 1>(0, i) = (turned * arm - s.world_T_imu.R * arm) / h;
  }
  J.topRightCorner<3, 3>().setIdentity();
  J.bottomLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<3, 3>().setZero();
  return J * s.pose_covariance * J.transpose();
}

/// Reliably and as fast as it goes; then the bridge ends.
bool plays_all(FastClient& client, const Recording& recording, Process& bridge,
               const Listener& listener, bool apart = false) {
  RobotDriver driver(client, recording, true, {}, apart);
  if (!driver.await_bridge(listener.diagnostics, seconds(20))) return false;
  driver.play(0);
  if (!driver.acknowledged(seconds(20))) return false;
  bridge.interrupt();
  if (bridge.wait(seconds(30)) != 0) return false;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  return true;
}

void expect_odometry_of(const Run& run, const std::vector<FastReader::Message>& messages) {
  ASSERT_GT(messages.size(), 20u);
  // A start may give several estimates at once.
  EXPECT_GE(messages.size() + 12, run.states.size());
  for (const FastReader::Message& message : messages) {
    const Odometry o = odometry(message.bytes);
    const RunState* state = state_at(run, o.time);
    ASSERT_NE(state, nullptr) << o.time.count();
    EXPECT_EQ(o.frame, "odom");
    EXPECT_EQ(o.child, "base_link");
    const SE3 expected = state->world_T_imu * kBaseTImu.inverse();
    EXPECT_LT((o.pose.p - expected.p).norm(), 1e-9);
    EXPECT_LT((o.pose.R - expected.R).norm(), 1e-9);
    const Matrix6d P = base_covariance(*state);
    EXPECT_LT((o.pose_covariance - P).norm(), 1e-4 * P.norm());
    // Without the turning of the arm, the velocity in the world is that of the IMU.
    const Eigen::Vector3d v(state->extra[0], state->extra[1], state->extra[2]);
    const Eigen::Vector3d arm_imu = kBaseTImu.inverse().p;
    const Eigen::Vector3d omega_imu = kBaseTImu.R.transpose() * o.angular;
    const Eigen::Vector3d of_base =
        kBaseTImu.R * (state->world_T_imu.R.transpose() * v + omega_imu.cross(arm_imu));
    EXPECT_LT((o.linear - of_base).norm(), 1e-9);
    EXPECT_GT(o.twist_covariance.diagonal().minCoeff(), 0);
  }
}

void expect_transforms_of(const std::vector<FastReader::Message>& odometries,
                          const std::vector<FastReader::Message>& messages) {
  ASSERT_EQ(messages.size(), odometries.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const std::vector<Transform> all = transforms(messages[i].bytes);
    const Odometry o = odometry(odometries[i].bytes);
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].parent, "odom");
    EXPECT_EQ(all[0].child, "base_link");
    EXPECT_EQ(all[0].time, o.time);
    EXPECT_EQ(all[0].parent_T_child.p, o.pose.p);
    EXPECT_EQ(all[0].parent_T_child.R, o.pose.R);
  }
}

// The same odometry in forward, right, down; best effort may lose one.
void expect_px4_of(const std::vector<FastReader::Message>& odometries,
                   const std::vector<FastReader::Message>& messages) {
  std::map<std::uint64_t, Odometry> by_time;
  for (const FastReader::Message& message : odometries) {
    const Odometry o = odometry(message.bytes);
    by_time[static_cast<std::uint64_t>(o.time.count() / 1000)] = o;
  }
  ASSERT_GT(messages.size(), odometries.size() / 2);
  const Eigen::Vector3d frd(1, -1, -1);
  const auto expect_near = [](const Eigen::VectorXd& found, const Eigen::VectorXd& expected) {
    EXPECT_LT((found - expected).norm(), 1e-6 * (1 + expected.norm()));
  };
  for (const FastReader::Message& message : messages) {
    const VehicleOdometry v = vehicle_odometry(message.bytes);
    EXPECT_EQ(v.timestamp, v.timestamp_sample);
    ASSERT_TRUE(by_time.contains(v.timestamp)) << v.timestamp;
    const Odometry& o = by_time.at(v.timestamp);
    EXPECT_EQ(v.pose_frame, 2) << "FRD";
    EXPECT_EQ(v.velocity_frame, 3) << "FRD of the body";
    expect_near(v.position, frd.cwiseProduct(o.pose.p));
    expect_near(v.velocity, frd.cwiseProduct(o.linear));
    expect_near(v.angular_velocity, frd.cwiseProduct(o.angular));
    // The vehicle's forward, right and down in the local frame.
    const Eigen::Matrix3d R = Eigen::Quaterniond(v.q[0], v.q[1], v.q[2], v.q[3]).toRotationMatrix();
    expect_near(R.col(0), frd.cwiseProduct(o.pose.R.col(0)));
    expect_near(R.col(1), -frd.cwiseProduct(o.pose.R.col(1)));
    expect_near(R.col(2), -frd.cwiseProduct(o.pose.R.col(2)));
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(v.position_variance[k], o.pose_covariance(k, k), 1e-6);
      EXPECT_NEAR(v.velocity_variance[k], o.twist_covariance(k, k), 1e-6);
      const Eigen::Vector3d axis = o.pose.R.col(k);  // of the body, in the world
      EXPECT_NEAR(v.orientation_variance[k],
                  axis.dot(o.pose_covariance.bottomRightCorner<3, 3>() * axis), 1e-7);
    }
    EXPECT_EQ(v.reset_counter, 0);
    EXPECT_TRUE(v.quality == 100 || v.quality == 50) << v.quality;
  }
}

void expect_points_of(const Run& run, const std::vector<FastReader::Message>& messages) {
  ASSERT_FALSE(messages.empty());
  const Cloud last = cloud(messages.back().bytes);
  EXPECT_EQ(last.frame, "odom");
  EXPECT_EQ(last.height, 1u);
  ASSERT_EQ(last.width, run.landmarks.size());
  EXPECT_EQ(last.row_step, last.width * last.point_step);
  EXPECT_EQ(last.data.size(), last.row_step);
  EXPECT_EQ(last.datatypes.at("x"), 7);  // FLOAT32
  std::map<float, const RunLandmark*> by_x;
  for (const RunLandmark& l : run.landmarks) by_x[static_cast<float>(l.p_world.x())] = &l;
  for (std::size_t i = 0; i < last.width; ++i) {
    const auto found = by_x.find(last.at<float>(i, "x"));
    ASSERT_NE(found, by_x.end()) << i;
    const RunLandmark& l = *found->second;
    EXPECT_EQ(last.at<float>(i, "y"), static_cast<float>(l.p_world.y()));
    EXPECT_EQ(last.at<float>(i, "z"), static_cast<float>(l.p_world.z()));
    EXPECT_FLOAT_EQ(last.at<float>(i, "sigma"),
                    static_cast<float>(std::sqrt(l.covariance.trace())));
    EXPECT_EQ(last.at<std::uint32_t>(i, "observations"),
              static_cast<std::uint32_t>(l.observations));
  }
}

void expect_diagnostics_of(std::size_t frames, const std::vector<FastReader::Message>& messages) {
  ASSERT_FALSE(messages.empty());
  const Status last = status(messages.back().bytes);
  EXPECT_EQ(last.name, "chasles: robot");
  EXPECT_LT(last.level, 2) << last.message;
  EXPECT_EQ(last.values.at("frames"), std::to_string(frames));
  EXPECT_EQ(last.values.at("frames dropped"), "0");
}

TEST(DdsRun, EqualsTheCommandToTheByteAndPublishesIt) {
  const Scratch folder;
  simulate_walk(folder);
  const Outcome command = chasles(folder, "run walk -o command --quiet");
  ASSERT_EQ(command.code, 0) << command.err;
  const Recording recording = read_recording(folder / "walk");

  Process bridge(
      bridge_command(
          folder, {"--reliable", "--lossless", "-o", folder / "bridge", "--points-period", "1e-6",
                   "--base-T-imu", base_T_imu_text(), "--px4", "/fmu/in/vehicle_visual_odometry"}),
      folder / "log.txt");
  FastClient client(kDomain);
  const Listener listener(client);
  ASSERT_TRUE(plays_all(client, recording, bridge, listener)) << slurp(folder / "log.txt");

  for (const char* file : {"states.csv", "trajectory.tum", "landmarks.csv"}) {
    ASSERT_FALSE(slurp(folder / "command" / file).empty()) << file;
    EXPECT_EQ(slurp(folder / "bridge" / file), slurp(folder / "command" / file)) << file;
  }
  const chasles::Run run = read_run(folder / "bridge");
  const auto odometries = listener.odometry.messages();
  expect_odometry_of(run, odometries);
  expect_transforms_of(odometries, listener.tf.messages());
  expect_px4_of(odometries, listener.px4.messages());
  expect_points_of(run, listener.points.messages());
  expect_diagnostics_of(recording.images->size(), listener.diagnostics.messages());
}

// A table of the gyroscope, and one of every second sample of the accelerometer.
void write_imu_apart(const std::filesystem::path& mav) {
  std::istringstream lines(slurp(mav / "imu0/data.csv"));
  std::string accel = "timestamp,ax,ay,az\n", gyro = "timestamp,wx,wy,wz\n", line;
  std::getline(lines, line);
  for (int row = 0; std::getline(lines, line); ++row) {
    std::size_t middle = 0;
    for (int comma = 0; comma < 4; ++comma) middle = line.find(',', middle) + 1;
    gyro += line.substr(0, middle - 1) + "\n";
    if (row % 2 == 0) accel += line.substr(0, line.find(',') + 1) + line.substr(middle) + "\n";
  }
  for (const char* name : {"accel0", "gyro0"}) std::filesystem::create_directory(mav / name);
  spill(mav / "accel0/data.csv", accel);
  spill(mav / "gyro0/data.csv", gyro);
  std::filesystem::remove(mav / "imu0/data.csv");
}

TEST(DdsRun, AnAccelerometerAndAGyroscopeApartGiveTheBytesOfTheCommand) {
  const Scratch folder;
  simulate_walk(folder);
  const Recording recording = read_recording(folder / "walk");
  write_imu_apart(folder / "walk/mav0");
  const Outcome command = chasles(folder, "run walk -o command --quiet");
  ASSERT_EQ(command.code, 0) << command.err;
  Process bridge(bridge_command(folder, {"--reliable", "--lossless", "-o", folder / "bridge",
                                         "--imu", "/gyro", "--accelerometer", "/accel"}),
                 folder / "log.txt");
  FastClient client(kDomain);
  const Listener listener(client);
  ASSERT_TRUE(plays_all(client, recording, bridge, listener, true)) << slurp(folder / "log.txt");
  for (const char* file : {"states.csv", "trajectory.tum", "landmarks.csv"}) {
    ASSERT_FALSE(slurp(folder / "command" / file).empty()) << file;
    EXPECT_EQ(slurp(folder / "bridge" / file), slurp(folder / "command" / file)) << file;
  }
  const Status last = status(listener.diagnostics.messages().back().bytes);
  EXPECT_EQ(last.values.at("gyroscope samples"), std::to_string(recording.imu.size()));
  EXPECT_EQ(last.values.at("gyroscope samples not joined"), "0");
}

// REP 105: the robot is at map_T_odom odom_T_base in the map, which is where the run found itself.
TEST(DdsRun, PlacesTheEstimatesInASavedMap) {
  const Scratch folder;
  simulate_walk(folder);
  const Outcome mapped = chasles(folder, "run walk --save-map walk.map --quiet");
  ASSERT_EQ(mapped.code, 0) << mapped.err;
  const Recording recording = read_recording(folder / "walk");
  Process bridge(bridge_command(folder, {"--reliable", "--lossless", "-o", folder / "bridge",
                                         "--map", folder / "walk.map", "--map-frame", "building"}),
                 folder / "log.txt");
  FastClient client(kDomain);
  const Listener listener(client);
  ASSERT_TRUE(plays_all(client, recording, bridge, listener)) << slurp(folder / "log.txt");

  const chasles::Run run = read_run(folder / "bridge");
  ASSERT_FALSE(run.in_map.empty());
  std::map<Time, SE3> map_T_odom, odom_T_base;
  for (const FastReader::Message& message : listener.tf.messages()) {
    for (const Transform& t : transforms(message.bytes)) {
      (t.parent == "building" ? map_T_odom : odom_T_base)[t.time] = t.parent_T_child;
    }
  }
  EXPECT_EQ(map_T_odom.size(), run.in_map.size());
  for (const SmoothedPose& pose : run.in_map) {
    const SE3 found = map_T_odom.at(pose.time) * odom_T_base.at(pose.time);
    EXPECT_LT((found.p - pose.world_T_imu.p).norm(), 1e-9);
    EXPECT_LT((found.R - pose.world_T_imu.R).norm(), 1e-9);
  }
}

// A camera that is wired up wrongly, or late: the run goes on without it, and is written.
TEST(DdsRun, AFirstImageThatIsDamagedEndsNoRunThatGoesOn) {
  const Scratch folder;
  simulate_walk(folder);
  const Recording recording = read_recording(folder / "walk");
  Process bridge({CHASLES_DDS_BINARY, folder / "walk", "--domain", std::to_string(kDomain),
                  "--camera", camera_topic(0), "--camera", "/late", "-o", folder / "bridge"},
                 folder / "log.txt");
  FastClient client(kDomain);
  RobotDriver driver(client, recording, false);
  FastWriter late(client, {"rt/late", "sensor_msgs::msg::dds_::Image_"},
                  {.reliable = false, .depth = 10});
  std::this_thread::sleep_for(seconds(3));  // until both sides know each other
  driver.play(2);
  const Time end = recording.imu.back().time;
  for (int i = 0; i < 10; ++i) {
    late.write(image_bytes(end, 7, 1, "mono8", "1234567"));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  bridge.interrupt();
  EXPECT_EQ(bridge.wait(seconds(30)), 0) << slurp(folder / "log.txt");
  EXPECT_NE(slurp(folder / "log.txt").find("cam1 (/late): is 7 x 1 pixels"), std::string::npos);
  EXPECT_GT(read_run(folder / "bridge").states.size(), 20u);
}

// In real time, with best effort on both sides: a state for each sample, and no image is late.
TEST(DdsRun, PredictsAtTheRateOfTheSamples) {
  const Scratch folder;
  simulate_walk(folder);
  Recording recording = read_recording(folder / "walk");
  Process bridge(bridge_command(folder, {"--rate", "samples", "--points-period", "0", "--no-tf"}),
                 folder / "log.txt");
  FastClient client(kDomain);
  const Listener listener(client);
  RobotDriver driver(client, recording, false);
  ASSERT_TRUE(driver.await_bridge(listener.diagnostics, seconds(20))) << slurp(folder / "log.txt");
  driver.play(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  bridge.interrupt();
  ASSERT_EQ(bridge.wait(seconds(30)), 0) << slurp(folder / "log.txt");
  EXPECT_TRUE(listener.tf.messages().empty());
  EXPECT_TRUE(listener.points.messages().empty());

  // Up to the truth's own length: position and velocity of the simulated walk.
  const auto messages = listener.odometry.messages();
  ASSERT_GT(messages.size(), recording.imu.size() / 4);
  std::vector<Time> times;
  for (const FastReader::Message& message : messages) times.push_back(odometry(message.bytes).time);
  EXPECT_TRUE(std::ranges::is_sorted(times));
  std::size_t samples = 0;
  for (const ImuSample& s : recording.imu) samples += std::ranges::binary_search(times, s.time);
  EXPECT_EQ(samples, times.size());  // each is at the time of a sample
  const Odometry first = odometry(messages.front().bytes), last = odometry(messages.back().bytes);
  const auto truth_at = [&](Time time) -> Eigen::Vector3d {
    const Trajectory& truth = recording.truth;
    const auto found = std::ranges::lower_bound(truth, time, {}, &StampedPose::time);
    return found == truth.end() ? truth.back().pose.p : found->pose.p;
  };
  const double walked = (truth_at(last.time) - truth_at(first.time)).norm();
  EXPECT_NEAR((last.pose.p - first.pose.p).norm(), walked, 0.1 + 0.02 * walked);
}

}  // namespace
}  // namespace chasles::test
