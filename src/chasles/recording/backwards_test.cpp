#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/recording/backwards.hpp>

namespace chasles {
namespace {

constexpr Time kStep = std::chrono::milliseconds(10);
const Eigen::Vector3d kGravity(0, 0, -kStandardGravity);

Recording some_recording(ImuConvention convention) {
  Recording r;
  r.imu_convention = convention;
  for (int k = 0; k <= 100; ++k) {
    ImuSample sample{.time = k * kStep};
    sample.specific_force_imu << 0.5 * std::sin(0.1 * k), 0.3, 9.7 + 0.2 * std::cos(0.07 * k);
    sample.angular_rate_imu << 0.4 * std::cos(0.05 * k), 0.1, 0.3;
    r.imu.push_back(sample);
  }
  return r;
}

InertialState driven(const Recording& r, InertialState state) {
  ImuBuffer buffer({.convention = r.imu_convention});
  for (const ImuSample& sample : r.imu) buffer.add(sample);
  for (const ImuInterval& interval : buffer.between(Time(0), 100 * kStep)) {
    state = integrate(state, interval, kGravity);
  }
  return state;
}

// Forward and back: integrating the reversed samples leads back to the initial state.
TEST(Backwards, ImuDrivesBackToTheBeginning) {
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    SCOPED_TRACE(name);
    const Recording r = some_recording(convention);
    InertialState start;
    start.v_world = {1, 2, 0.5};
    InertialState end = driven(r, start);
    EXPECT_GT((end.world_T_imu.p - start.world_T_imu.p).norm(), 1);
    end.v_world = -end.v_world;
    const InertialState back = driven(backwards(r), end);
    // The step is not symmetric in time: rotation first, over steps of 10 ms.
    EXPECT_LT((back.world_T_imu.p - start.world_T_imu.p).norm(), 1e-3);
    EXPECT_LT((back.v_world + start.v_world).norm(), 1e-3);
    EXPECT_LT((back.world_T_imu.R - start.world_T_imu.R).norm(), 1e-9);
  }
}

TEST(Backwards, TwiceIsTheSame) {
  Recording r = some_recording(ImuConvention::kInstant);
  for (const int t : {3, 50}) {
    r.frames.push_back({.time = t * kStep, .pixels = {{.landmark = t}}});
    r.truth.push_back({.time = t * kStep, .pose = {Eigen::Matrix3d::Identity(), {1.0 * t, 0, 0}}});
  }
  const Recording once = backwards(r);
  EXPECT_EQ(once.frames.front().time, 50 * kStep);
  EXPECT_EQ(once.frames.front().pixels.front().landmark, 50);
  EXPECT_EQ(once.truth.front().pose.p.x(), 50);
  const Recording twice = backwards(once);
  ASSERT_EQ(twice.imu.size(), r.imu.size());
  for (std::size_t k = 0; k < r.imu.size(); ++k) {
    EXPECT_EQ(twice.imu[k].time, r.imu[k].time);
    EXPECT_EQ(twice.imu[k].angular_rate_imu, r.imu[k].angular_rate_imu);
  }
  EXPECT_EQ(twice.frames.front().time, r.frames.front().time);
}

// The last line of the image would be the first.
TEST(Backwards, RejectsARollingShutter) {
  Recording r = some_recording(ImuConvention::kInstant);
  r.name = "phone";
  r.cameras.emplace_back().shutter.readout = 0.02;
  try {
    backwards(r);
    ADD_FAILURE();
  } catch (const UsageError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("cam0 of phone has a rolling shutter"), std::string::npos) << text;
    EXPECT_NE(text.find("expected global shutters"), std::string::npos) << text;
  }
}

TEST(Backwards, MayBeEmptyOrHaveOneSample) {
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    Recording r;
    r.imu_convention = convention;
    EXPECT_TRUE(backwards(r).imu.empty()) << name;
    r.imu.resize(1);
    EXPECT_EQ(backwards(r).imu.size(), is_force_of_instant(convention) ? 1U : 0U) << name;
  }
}

}  // namespace
}  // namespace chasles
