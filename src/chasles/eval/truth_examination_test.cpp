#include <algorithm>
#include <functional>
#include <random>
#include <sstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/eval/truth_examination.hpp>
#include <chasles/eval/truth_reading.hpp>
#include <chasles/eval/truth_walk_testing.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using test::camera;
using test::changed;
using test::estimate;
using test::sampled;
using test::truth;
using test::walk_at;

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
  // A truth that states it is accepted where the body does not turn either.
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

// A point on the body, far away, explains their positions almost as well.
TEST(TruthExamination, InversePosesOfAShortPathFarFromTheOriginAreWhole) {
  TruthReference short_path = estimate();
  for (StampedPose& row : short_path.poses) row.pose.p *= 0.1;
  const auto inverse = changed([](StampedPose& row) {
    row.pose.p = 0.1 * row.pose.p + Eigen::Vector3d(1.5, -0.9, 4.9);
    row.pose = row.pose.inverse();
  });
  EXPECT_EQ(faults(examine_truth(short_path, inverse)), "inverse_poses");
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
  EXPECT_EQ(faults(examine_truth(estimate(), sparse, {.gap = std::chrono::seconds(2)})),
            "interpolated");
  EXPECT_EQ(faults(examine_truth(estimate(), sparse, {.interpolated = false})), "");
}

TEST(TruthExamination, LittleMotionFindsNothing) {
  const TruthReference reference = estimate();
  const auto still = [](double) { return walk_at(3); };
  TruthReference static_reference = reference;
  static_reference.poses = sampled(20, 1, 20, still);
  EXPECT_EQ(faults(examine_truth(static_reference, sampled(200, 0, 22, still))), "");
  EXPECT_EQ(faults(examine_truth(reference, {})), "");
  EXPECT_EQ(faults(examine_truth(reference, sampled(200, 3, 3.2))), "");
}

Eigen::Vector3d advised_point(const TruthFinding& finding) {
  const std::size_t begin = finding.advice.find("as estimated: ") + 14;
  std::string text = finding.advice.substr(begin);
  std::ranges::replace(text, ';', ' ');
  std::istringstream stream(text);
  Eigen::Matrix4d M;
  for (int i = 0; i < 16; ++i) stream >> M(i / 4, i % 4);
  return M.topRightCorner<3, 1>();
}

// The longer the lever arm, the less the positions look like the path of the IMU.
TEST(TruthExamination, ALongLeverArmIsFoundLikeAShortOne) {
  for (const double length : {0.1, 0.3, 1.0, 3.0, 8.0}) {
    const Eigen::Vector3d lever = length * Eigen::Vector3d(0.5, -0.2, 0.84).normalized();
    const auto beside = changed([&](StampedPose& row) { row.pose.p += row.pose.R * lever; });
    const TruthExamination found = examine_truth(estimate(), beside);
    ASSERT_EQ(faults(found), "point") << length;
    EXPECT_NEAR(found.findings[0].value, length, 5 * found.findings[0].sigma);
    EXPECT_LT(found.findings[0].sigma, 0.02 + 0.05 * length);
    EXPECT_EQ(faults(examine_truth(estimate(), beside, {.positions_only = true})),
              "positions_only point");
    // With axes of its own, too: the advice has the lever arm, and what is advised leaves nothing.
    const SE3 marker{so3::exp({0.4, -0.5, 0.9}), lever};
    const auto turned = changed([&](StampedPose& row) { row.pose = row.pose * marker; });
    const TruthExamination frame = examine_truth(estimate(), turned);
    ASSERT_EQ(faults(frame), "frame") << length;
    const Eigen::Vector3d point = advised_point(frame.findings[0]);
    EXPECT_LT((point - lever).norm(), 0.02 + 0.05 * length);
    const SE3 left = marker * SE3{marker.R, point}.inverse();
    EXPECT_EQ(faults(changed([&](StampedPose& row) { row.pose = row.pose * left; })), "");
  }
}

TEST(TruthExamination, WFirstAndInverseAreFoundTogether) {
  const auto w_first = [](StampedPose& row) {
    const Eigen::Quaterniond q(row.pose.R);
    row.pose.R = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
  };
  EXPECT_EQ(faults(changed([&](StampedPose& row) {
              row.pose.R.transposeInPlace();
              w_first(row);
            })),
            "w_first inverse_rotations");
  EXPECT_EQ(faults(changed([&](StampedPose& row) {
              row.pose = row.pose.inverse();
              w_first(row);
            })),
            "w_first inverse_poses");
}

TEST(TruthExamination, PositionsOfAnotherPathAreNamed) {
  const auto other = [](double t) {
    return SE3{walk_at(t).R, {std::sin(1.9 * t), std::cos(1.1 * t), std::sin(2.7 * t)}};
  };
  EXPECT_EQ(faults(examine_truth(estimate(), sampled(200, 0, 22, other))), "unlike_path");
  EXPECT_EQ(faults(changed([](StampedPose& row) { row.pose.p.setZero(); })), "unlike_path");
  // Degrees of latitude and longitude, in either order, with attitudes and without.
  for (const bool swapped : {false, true}) {
    const auto degrees = changed([&](StampedPose& row) {
      const Eigen::Vector3d p = row.pose.p;
      row.pose.p << 47.4 + p.y() / 111195, 8.5 + p.x() / (111195 * std::cos(47.4 * kRadians)),
          400 + p.z();
      if (swapped) std::swap(row.pose.p.x(), row.pose.p.y());
    });
    const TruthExamination found = examine_truth(estimate(), degrees);
    ASSERT_EQ(faults(found), "unlike_path");
    EXPECT_NE(found.findings[0].what.find(swapped ? "longitude and latitude in degrees"
                                                  : "latitude and longitude in degrees"),
              std::string::npos)
        << found.findings[0].what;
  }
}

TEST(TruthExamination, AttitudesOfOneAxisAreNamed) {
  const auto heading = changed([](StampedPose& row) {
    const Eigen::Vector3d x = row.pose.R.col(0);
    row.pose.R = so3::exp({0, 0, 3 * std::atan2(x.y(), x.x())});
  });
  EXPECT_EQ(faults(heading), "unlike");
}

// A drift of the positions hides what the clock does to them.
TEST(TruthExamination, AClockThatTheAttitudesShowIsReported) {
  TruthReference drifting = estimate();
  for (std::size_t i = 0; i < drifting.poses.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(drifting.poses.size());
    drifting.poses[i].pose.p += Eigen::Vector3d(0.5, -0.3, 0.2) * share * share;
  }
  EXPECT_EQ(faults(examine_truth(drifting, truth())), "");
  for (const double off : {-0.05, 0.05, 0.02}) {
    const auto late = changed([&](StampedPose& row) { row.time += from_seconds(off); });
    const TruthExamination found = examine_truth(drifting, late);
    ASSERT_EQ(faults(found), "clock") << off;
    EXPECT_NEAR(found.findings[0].value, -off, 5 * found.findings[0].sigma);
    EXPECT_NE(found.findings[0].what.find("the attitudes are off by"), std::string::npos);
  }
}

TEST(TruthExamination, OfTwoCamerasTheNearerIsNamed) {
  TruthReference reference = estimate();
  const SE3 second = camera().imu_T_frame * SE3{so3::exp({0.02, 0.01, 0}), {0.11, 0, 0}};
  const SE3 beside = camera().imu_T_frame * SE3{{}, {0.5, 0, 0}};  // the same axes
  reference.frames.push_back({"cam1", second});
  reference.frames.push_back({"cam2", beside});
  for (const KnownFrame& frame : reference.frames) {
    const TruthExamination found = examine_truth(
        reference, changed([&](StampedPose& row) { row.pose = row.pose * frame.imu_T_frame; }));
    ASSERT_EQ(faults(found), "frame");
    EXPECT_EQ(found.findings[0].advice, "--truth-frame " + frame.name + " moves it to the IMU");
  }
}

// The sentence says "with the extrinsics of cam0".
TEST(TruthExamination, TheResidualIsThatWithTheExtrinsics) {
  const SE3 nearly = camera().imu_T_frame * SE3{so3::exp({0, 0.05, 0}), {0, 0, 0}};
  const auto poses = changed([&](StampedPose& row) { row.pose = row.pose * nearly; });
  TruthReference exact = estimate();
  exact.poses = sampled(20, 1, 20);
  const TurningEvidence evidence = explain_turning(exact, poses, kLongestTruthGap);
  ASSERT_TRUE(evidence.explanation && evidence.explanation->frame);
  EXPECT_GT(evidence.explanation->residual, 1.5 * evidence.explanation->fit.residual);
}

TEST(TruthExamination, ASmallTurnThatIsCertainIsReported) {
  for (const double degrees : {2.0, 3.7, 5.0, 10.0}) {
    const SE3 turn{so3::exp(degrees * kRadians * Eigen::Vector3d(0.6, -0.48, 0.64)), {0, 0, 0}};
    const TruthExamination found =
        examine_truth(estimate(), changed([&](StampedPose& row) { row.pose = row.pose * turn; }));
    ASSERT_EQ(faults(found), "frame") << degrees;
    EXPECT_NEAR(found.findings[0].value, degrees, 6 * found.findings[0].sigma);
    EXPECT_GT(found.findings[0].value, found.findings[0].threshold);
  }
  const SE3 half{so3::exp({0.5 * kRadians, 0, 0}), {0, 0, 0}};
  EXPECT_EQ(faults(changed([&](StampedPose& row) { row.pose = row.pose * half; })), "");
}

// A car turns about one axis: its rates leave the turn of a marker about that axis open.
SE3 car_at(double t) {
  const double heading = 0.9 * std::sin(0.3 * t) + 0.4 * std::sin(0.71 * t);
  return {so3::exp({0, 0, heading}), {3 * t + std::sin(0.3 * t), 8 * std::sin(0.21 * t), 0}};
}

TEST(TruthExamination, PositionsShowTheAxesOfADriveInAPlane) {
  TruthReference reference = estimate();
  const Trajectory walked = reference.poses;
  reference.poses = sampled(20, 1, 20, car_at);
  for (std::size_t i = 0; i < walked.size(); ++i) {  // the same noise
    const auto k = static_cast<double>(i);
    reference.poses[i].pose.R *= so3::exp(0.002 * Eigen::Vector3d(std::sin(6 * k), 0, 0));
    reference.poses[i].pose.p.x() += 0.02 * std::sin(5.3 * k);
  }
  const auto driven = [](const std::function<void(StampedPose&)>& change) {
    Trajectory poses = sampled(200, 0, 22, car_at);
    for (StampedPose& row : poses) change(row);
    return poses;
  };
  EXPECT_EQ(faults(examine_truth(reference, driven([](StampedPose&) {}))), "");
  const SE3 imu_T_cam = camera().imu_T_frame;
  const TruthExamination camera_found =
      examine_truth(reference, driven([&](StampedPose& row) { row.pose = row.pose * imu_T_cam; }));
  EXPECT_EQ(faults(camera_found), "frame");
  for (const double degrees : {180.0, 90.0, -45.0}) {
    const SE3 marker{so3::exp({0, 0, degrees * kRadians}), {0, 0, 0}};
    const TruthExamination found =
        examine_truth(reference, driven([&](StampedPose& row) { row.pose = row.pose * marker; }));
    ASSERT_EQ(faults(found), "frame") << degrees;
    EXPECT_NEAR(found.findings[0].value, std::abs(degrees), 2) << found.findings[0].what;
    // w first of that is not taken for inverse rotations.
    EXPECT_EQ(faults(examine_truth(
                  reference, driven([&](StampedPose& row) {
                    row.pose = row.pose * marker;
                    const Eigen::Quaterniond q(row.pose.R);
                    row.pose.R = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
                  }))),
              "w_first frame")
        << degrees;
  }
}

TEST(TruthExamination, InterpolationThatShowsInTheErrorsIsNamed) {
  TruthReference fine = estimate();
  fine.poses = sampled(20, 1, 20);
  EXPECT_EQ(faults(examine_truth(fine, sampled(5, 0, 22))), "interpolated");
  EXPECT_EQ(faults(examine_truth(fine, sampled(5, 0, 22), {.interpolated = false})), "");
  EXPECT_EQ(faults(examine_truth(estimate(), sampled(2, 0, 22), {.gap = Time(750'000'000)})),
            "interpolated");
  // Nothing is interpolated where each stamp of the estimate is one of the truth.
  EXPECT_EQ(faults(examine_truth(estimate(), sampled(20, 0, 22))), "");
}

// Attitudes of markers have white noise, which is large in rates over a tenth of a second.
TEST(TruthExamination, NoisyAttitudesAreNoFault) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (const double degrees : {0.2, 0.5, 1.0, 2.0}) {
    for (const double hz : {200.0, 25.0}) {
      Trajectory noisy = sampled(hz, 0, 22);
      for (StampedPose& row : noisy) {
        const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
        row.pose.R *= so3::exp(degrees * kRadians * turn);
      }
      EXPECT_EQ(faults(noisy), "") << degrees << " deg at " << hz << " Hz";
    }
  }
}

}  // namespace
}  // namespace chasles
