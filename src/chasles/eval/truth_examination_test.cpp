#include <functional>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/constants.hpp>
#include <chasles/eval/position_fit.hpp>
#include <chasles/eval/truth_examination.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// A walk of 20 s with turns about all axes, none of which repeats: the sines have no common period.
SE3 walk_at(double t) {
  return {so3::exp({0.3 * std::sin(0.9 * t), 0.25 * std::sin(1.3 * t + 1), 0}) *
              so3::exp({0, 0, 0.8 * std::sin(0.5 * t) + 0.3 * std::sin(2.1 * t)}),
          {2 * std::sin(0.4 * t) + 0.2 * std::sin(1.7 * t), 1.5 * std::cos(0.3 * t),
           0.4 * std::sin(0.7 * t)}};
}

Trajectory sampled(double hz, double begin, double end,
                   const std::function<SE3(double)>& pose = walk_at) {
  Trajectory trajectory;
  const double base = 1e9;
  for (int i = 0; begin + i / hz <= end; ++i) {
    const double t = begin + i / hz;
    trajectory.push_back(
        {std::chrono::seconds(static_cast<long>(base)) + from_seconds(t), pose(t)});
  }
  return trajectory;
}

KnownFrame camera() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {"cam0", {so3::exp({0.02, -0.03, 0.01}) * R, {0.1, 0.05, -0.04}}};
}

// 2 mm and 0.1 deg of noise, as an estimate has them, without randomness.
TruthReference estimate() {
  TruthReference reference{
      .name = "the estimate", .poses = sampled(20, 1, 20), .level = true, .frames = {camera()}};
  for (std::size_t i = 0; i < reference.poses.size(); ++i) {
    const auto k = static_cast<double>(i);
    SE3& pose = reference.poses[i].pose;
    pose.p += 0.002 * Eigen::Vector3d(std::sin(7.1 * k), std::sin(5.3 * k), std::cos(3.7 * k));
    pose.R *= so3::exp(0.0017 * Eigen::Vector3d(std::sin(6.1 * k), std::cos(4.9 * k), 0));
  }
  return reference;
}

Trajectory truth() { return sampled(200, 0, 22); }

Trajectory changed(const std::function<void(StampedPose&)>& change) {
  Trajectory poses = truth();
  for (StampedPose& row : poses) change(row);
  return poses;
}

std::string faults(const TruthExamination& examination) {
  std::string text;
  for (const TruthFinding& f : examination.findings) {
    text += (text.empty() ? "" : " ") + std::string(name(f.fault));
  }
  return text;
}

std::string faults(const Trajectory& poses) { return faults(examine_truth(estimate(), poses)); }

TEST(TruthExamination, ARightTruthHasNoFinding) {
  const TruthExamination examination = examine_truth(estimate(), truth());
  EXPECT_EQ(faults(examination), "");
  ASSERT_TRUE(examination.clock);
  EXPECT_LT(std::abs(examination.clock->offset), 4 * examination.clock->sigma);
  EXPECT_LT(examination.clock->sigma, 0.002);
  // Nor in another world whose z axis is vertical, nor at 20 Hz.
  const SE3 other{so3::exp({0, 0, 2}), {100, -50, 3}};
  EXPECT_EQ(faults(changed([&](StampedPose& row) { row.pose = other * row.pose; })), "");
  EXPECT_EQ(faults(sampled(20, 0.013, 22)), "");
}

TEST(TruthExamination, AClockThatIsOffIsMeasured) {
  for (const double off : {0.02, -0.05, 0.2, 1.0, 37.0, -1e9}) {
    const auto late = changed([&](StampedPose& row) { row.time += from_seconds(off); });
    const TruthExamination examination = examine_truth(estimate(), late);
    ASSERT_EQ(faults(examination), "clock") << off;
    ASSERT_TRUE(examination.clock);
    EXPECT_NEAR(examination.clock->offset, -off, 5 * examination.clock->sigma) << off;
    EXPECT_LT(examination.clock->sigma, 0.002) << off;
    EXPECT_TRUE(examination.clock->by_rotations);
    const std::string text = sentence(examination.findings.front());
    EXPECT_NE(text.find(off > 0 ? " s late by" : " s early by"), std::string::npos) << text;
    EXPECT_NE(text.find("--truth-time-offset"), std::string::npos) << text;
  }
}

TEST(TruthExamination, PositionsAloneGiveTheClockToo) {
  const auto late = changed([](StampedPose& row) {
    row.time += std::chrono::milliseconds(300);
    row.pose.R.setIdentity();
  });
  const TruthExamination examination = examine_truth(estimate(), late);
  EXPECT_EQ(faults(examination), "positions_only clock");
  EXPECT_FALSE(examination.attitudes);
  ASSERT_TRUE(examination.clock);
  EXPECT_FALSE(examination.clock->by_rotations);
  EXPECT_NEAR(examination.clock->offset, -0.3, 5 * examination.clock->sigma);
  // A truth that states it is believed where the body does not turn either.
  TruthReference still = estimate();
  for (StampedPose& row : still.poses) row.pose.R.setIdentity();
  EXPECT_TRUE(examine_truth(still, late).attitudes);
  EXPECT_FALSE(examine_truth(still, late, {.positions_only = true}).attitudes);
}

TEST(TruthExamination, TheReadingOfTheQuaternionsIsFound) {
  EXPECT_EQ(faults(changed([](StampedPose& row) {
              const Eigen::Quaterniond q(row.pose.R);  // w, x, y, z read as x, y, z, w
              row.pose.R = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
            })),
            "w_first");
  EXPECT_EQ(faults(changed([](StampedPose& row) { row.pose.R.transposeInPlace(); })),
            "inverse_rotations");
  EXPECT_EQ(faults(changed([](StampedPose& row) { row.pose = row.pose.inverse(); })),
            "inverse_poses");
}

TEST(TruthExamination, TheFrameOnTheBodyIsNamed) {
  const SE3 imu_T_cam = camera().imu_T_frame;
  const auto of_camera = changed([&](StampedPose& row) { row.pose = row.pose * imu_T_cam; });
  const TruthExamination known = examine_truth(estimate(), of_camera);
  ASSERT_EQ(faults(known), "frame");
  EXPECT_NE(known.findings[0].advice.find("--truth-frame cam0"), std::string::npos);
  const SE3 marker{so3::exp({0.4, -0.5, 0.6}), {0.3, -0.2, 0.1}};
  const auto of_marker = changed([&](StampedPose& row) { row.pose = row.pose * marker; });
  const TruthExamination other = examine_truth(estimate(), of_marker);
  ASSERT_EQ(faults(other), "frame");
  const double angle = kDegrees * so3::log(marker.R).norm();
  EXPECT_NEAR(other.findings[0].value, angle, 5 * other.findings[0].sigma);
  EXPECT_LT(other.findings[0].sigma, 0.5);
  EXPECT_NE(other.findings[0].what.find("0.37"), std::string::npos) << other.findings[0].what;
  // A point beside the IMU, by its positions.
  const auto of_point = changed([&](StampedPose& row) { row.pose.p += row.pose.R * marker.p; });
  const TruthExamination point = examine_truth(estimate(), of_point);
  ASSERT_EQ(faults(point), "point");
  EXPECT_NEAR(point.findings[0].value, marker.p.norm(), 5 * point.findings[0].sigma);
}

TEST(TruthExamination, UnitMirrorAndTiltAreFound) {
  EXPECT_EQ(faults(changed([](StampedPose& row) { row.pose.p *= 1000; })), "unit");
  EXPECT_EQ(faults(changed([](StampedPose& row) { row.pose.p /= 0.3048; })), "unit");
  EXPECT_EQ(faults(changed([](StampedPose& row) { row.pose.p.y() *= -1; })), "mirrored");
  EXPECT_EQ(faults(changed([](StampedPose& row) { std::swap(row.pose.p.x(), row.pose.p.z()); })),
            "mirrored");
  Eigen::Matrix3d x_up;
  x_up << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const TruthExamination tilted = examine_truth(estimate(), changed([&](StampedPose& row) {
                                                  row.pose = SE3{x_up, {}} * row.pose;
                                                }));
  ASSERT_EQ(faults(tilted), "tilted");
  EXPECT_NE(tilted.findings[0].what.find("its x axis points up"), std::string::npos);
}

TEST(TruthExamination, SeveralFaultsAreFoundTogether) {
  const SE3 imu_T_cam = camera().imu_T_frame;
  EXPECT_EQ(faults(changed([&](StampedPose& row) {
              row.pose = row.pose * imu_T_cam;
              row.pose.p *= 1000;
              row.time += std::chrono::milliseconds(100);
            })),
            "unit clock frame");
}

// The gyroscope alone: rotations that drift with a bias.
TEST(TruthExamination, AGyroscopeFindsClockAndFrame) {
  TruthReference gyroscope{.name = "the gyroscope",
                           .poses = {},
                           .positions = false,
                           .biased = true,
                           .frames = {camera()}};
  const double base = 1e9;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int i = 0; i <= 4000; ++i) {
    const double t = 1 + i / 200.0;
    gyroscope.poses.push_back(
        {std::chrono::seconds(static_cast<long>(base)) + from_seconds(t), {R, {0, 0, 0}}});
    const Eigen::Vector3d turn = so3::log(walk_at(t).R.transpose() * walk_at(t + 0.005).R) +
                                 Eigen::Vector3d(-0.002, 0.021, 0.077) * 0.005;
    R = R * so3::exp(turn);
  }
  EXPECT_EQ(faults(examine_truth(gyroscope, truth())), "");
  const TruthExamination late = examine_truth(
      gyroscope, changed([](StampedPose& row) { row.time += std::chrono::milliseconds(20); }));
  ASSERT_EQ(faults(late), "clock");
  EXPECT_NEAR(late.clock->offset, -0.02, 5 * late.clock->sigma);
  const SE3 imu_T_cam = camera().imu_T_frame;
  EXPECT_EQ(faults(examine_truth(
                gyroscope, changed([&](StampedPose& row) { row.pose = row.pose * imu_T_cam; }))),
            "frame");
}

TEST(TruthExamination, AnotherRecordingsTruthIsNamed) {
  const auto other = [](double t) {
    SE3 pose = walk_at(t);
    pose.R = so3::exp({0.5 * std::sin(2.7 * t), 0.4 * std::sin(1.9 * t), 0.7 * std::cos(3.1 * t)});
    return pose;
  };
  const TruthExamination examination = examine_truth(estimate(), sampled(200, 0, 22, other));
  EXPECT_NE(faults(examination).find("unlike"), std::string::npos) << faults(examination);
}

// The head of a walker turns alike again after half a step, to the other side.
TEST(TruthExamination, AGaitIsNotTakenForAnotherClock) {
  const auto gait = [](double t) {
    SE3 pose = walk_at(0.05 * t);
    pose.R = pose.R * so3::exp({0, 0, 0.1 * std::sin(2 * M_PI * 0.9 * t)});
    pose.p.y() += 0.05 * std::sin(2 * M_PI * 0.9 * t);
    return pose;
  };
  TruthReference reference = estimate();
  reference.poses = sampled(20, 1, 20, gait);
  Trajectory walked = sampled(200, 0, 22, gait);
  EXPECT_EQ(faults(examine_truth(reference, walked)), "");
  for (StampedPose& row : walked) row.time += std::chrono::milliseconds(100);
  const TruthExamination late = examine_truth(reference, walked);
  ASSERT_EQ(faults(late), "clock");
  EXPECT_NEAR(late.clock->offset, -0.1, 0.005);
}

TEST(TruthExamination, ATruthOfFewPosesIsNamed) {
  const Trajectory sparse = sampled(1, 0, 22);
  EXPECT_EQ(faults(sparse), "sparse");
  EXPECT_EQ(faults(examine_truth(estimate(), sparse, {.gap = std::chrono::seconds(2)})), "");
  EXPECT_EQ(faults(examine_truth(estimate(), sparse, {.interpolated = false})), "");
}

TEST(TruthExamination, LittleMotionFindsNothing) {
  const TruthReference reference = estimate();
  const auto still = [](double) { return walk_at(3); };
  TruthReference resting = reference;
  resting.poses = sampled(20, 1, 20, still);
  EXPECT_EQ(faults(examine_truth(resting, sampled(200, 0, 22, still))), "");
  EXPECT_EQ(faults(examine_truth(reference, {})), "");
  EXPECT_EQ(faults(examine_truth(reference, sampled(200, 3, 3.2))), "");
}

// The closed form: a path that is off by a known rigid motion, scale, time and point.
TEST(PositionFit, FindsTimeScaleAndPoint) {
  const Trajectory reference = sampled(20, 1, 20);
  const SE3 world{so3::exp({0.2, -0.4, 1.1}), {5, -3, 2}};
  const Eigen::Vector3d point(0.2, -0.1, 0.15);
  const Trajectory other = changed([&](StampedPose& row) {
    row.pose.p = world.R * (3 * (row.pose * point)) + world.p;
    row.time -= std::chrono::milliseconds(40);
  });
  const auto fit = fit_positions(reference, other, {.scale = true, .offset = true, .point = true});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->scale, 3, 1e-4);
  EXPECT_NEAR(fit->offset, 0.04, 1e-4);
  EXPECT_LT((fit->point - point).norm(), 1e-3);
  EXPECT_LT((fit->truth_T_estimate.R - world.R).norm(), 1e-3);
  EXPECT_LT(fit->rms, 1e-3);
}

}  // namespace
}  // namespace chasles
