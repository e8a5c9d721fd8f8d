#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {
namespace {

TEST(PoseAt, IsOfTheStampOrBetweenTwo) {
  const Eigen::Vector3d turn(0, 0, 0.2);
  Trajectory truth{{.time = from_seconds(1), .pose = {}},
                   {.time = from_seconds(1.1), .pose = {}},
                   {.time = from_seconds(1.4), .pose = {}}};
  truth[1].pose.p = {1, 2, 3};
  truth[1].pose.R = so3::exp(turn);
  EXPECT_EQ(pose_at(truth, from_seconds(1.1))->p, truth[1].pose.p);
  const auto between = pose_at(truth, from_seconds(1.025));
  ASSERT_TRUE(between);
  EXPECT_LT((between->p - truth[1].pose.p / 4).norm(), 1e-9);
  EXPECT_LT((so3::log(between->R) - turn / 4).norm(), 1e-9);
  EXPECT_FALSE(pose_at(truth, from_seconds(1.2))) << "the gap is too long";
  EXPECT_TRUE(pose_at(truth, from_seconds(1.2), from_seconds(0.3)));
  EXPECT_TRUE(pose_at(truth, from_seconds(1.4)));
  EXPECT_FALSE(pose_at(truth, from_seconds(0.9)));
  EXPECT_FALSE(pose_at(truth, from_seconds(1.5)));
  EXPECT_FALSE(pose_at({}, from_seconds(1)));
}

TEST(PoseAt, AStampThatWasRoundedIsStillOne) {
  const Trajectory truth{{.time = from_seconds(1), .pose = {}},
                         {.time = from_seconds(2), .pose = {.R = {}, .p = {1, 2, 3}}}};
  for (const double time : {2.0001, 1.9999, 0.9999}) {
    EXPECT_TRUE(pose_at(truth, from_seconds(time))) << time;
  }
  EXPECT_EQ(pose_at(truth, from_seconds(1.99995))->p, Eigen::Vector3d(1, 2, 3));
  for (const double time : {2.00011, 1.99989, 0.99989}) {
    EXPECT_FALSE(pose_at(truth, from_seconds(time))) << time;
  }
}

}  // namespace
}  // namespace chasles
