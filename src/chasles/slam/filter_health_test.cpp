#include <limits>

#include <gtest/gtest.h>

#include <chasles/slam/filter_health.hpp>

namespace chasles {
namespace {

Estimate with_use(double seconds, int used, int rejected = 0) {
  Estimate e;
  e.time = from_seconds(seconds);
  e.v_world = Eigen::Vector3d::Zero();
  e.used = used;
  e.rejected = rejected;
  return e;
}

// The last of ten frames a second, all alike.
Estimate last_of(FilterHealth& health, double from, double until, int used, int rejected = 0) {
  Estimate e;
  for (double t = from; t < until; t += 0.1) {
    e = with_use(t, used, rejected);
    health.assess(e, true);
  }
  return e;
}

TEST(FilterHealth, IsGoodWhileObservationsAreUsed) {
  FilterHealth health;
  const Estimate e = last_of(health, 0, 5, 20, 2);
  EXPECT_EQ(e.health, Health::kOk);
  EXPECT_EQ(e.degradation, Degradation::kNone);
}

TEST(FilterHealth, ASecondWithoutObservationsDegradesItAndOneMoreAfter) {
  FilterHealth health;
  last_of(health, 0, 1, 20);
  EXPECT_EQ(last_of(health, 1, 1.8, 0).health, Health::kOk);
  EXPECT_EQ(last_of(health, 1.8, 3, 0).degradation, Degradation::kFewObservations);
  EXPECT_EQ(last_of(health, 3, 3.8, 20).degradation, Degradation::kFewObservations);
  EXPECT_EQ(last_of(health, 3.8, 5, 20).health, Health::kOk);
}

TEST(FilterHealth, RejectionsDegradeIt) {
  FilterHealth health;
  EXPECT_EQ(last_of(health, 0, 0.9, 5, 20).health, Health::kOk);
  EXPECT_EQ(last_of(health, 0.9, 2, 5, 20).degradation, Degradation::kRejections);
}

TEST(FilterHealth, InnovationsThatAreTooLargeDegradeIt) {
  FilterHealth health;
  Estimate e;
  for (int i = 0; i < 20; ++i) {
    e = with_use(0.1 * i, 20);
    e.nis_dof = 40;
    e.nis = 4 * e.nis_dof;
    health.assess(e, true);
  }
  EXPECT_EQ(e.degradation, Degradation::kInnovations);
}

TEST(FilterHealth, AStandstillNeedsNoObservation) {
  FilterHealth health;
  Estimate e;
  for (int i = 0; i < 50; ++i) {
    e = with_use(0.1 * i, 0);
    e.zero_velocity = true;
    health.assess(e, true);
  }
  EXPECT_EQ(e.health, Health::kOk);
}

TEST(FilterHealth, AnInvalidEstimateIsLost) {
  FilterHealth health;
  Estimate e = with_use(0, 20);
  health.assess(e, false);
  EXPECT_EQ(e.health, Health::kLost) << "of a clock without bounds";
  e = with_use(0, 20);
  e.covariance(2, 2) = -1;
  health.assess(e, true);
  EXPECT_EQ(e.health, Health::kLost);
  e = with_use(0, 20);
  e.world_T_imu.p.x() = std::numeric_limits<double>::quiet_NaN();
  health.assess(e, true);
  EXPECT_EQ(e.health, Health::kLost);
}

}  // namespace
}  // namespace chasles
