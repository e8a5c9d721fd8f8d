#include <cmath>
#include <limits>

#include <chasles/base/constants.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;

// f = (x, 2, 3), w = (-x, 1, 10 x): x identifies the sample, or the mixture of samples, of a value.
ImuSample sample(Time time, double x) {
  return {.time = time, .specific_force_imu = {x, 2, 3}, .angular_rate_imu = {-x, 1, 10 * x}};
}

// Samples at 10, 20, 30, 40 ms with the values 1, 2, 4, 8.
ImuBuffer four_samples(ImuConvention convention) {
  ImuBuffer buffer({.convention = convention});
  double x = 1;
  for (int i = 1; i <= 4; ++i, x *= 2) buffer.add(sample(milliseconds(10 * i), x));
  return buffer;
}

struct Expected {
  double tau, x, noise_scale = 1;
};
void expect_intervals(const std::vector<ImuInterval>& actual,
                      const std::vector<Expected>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    const auto [tau, x, noise_scale] = expected[i];
    SCOPED_TRACE(::testing::Message() << "interval " << i);
    EXPECT_DOUBLE_EQ(actual[i].tau, tau);
    EXPECT_TRUE(test::agree(actual[i].specific_force_imu, Eigen::Vector3d(x, 2, 3), 1e-14));
    EXPECT_TRUE(test::agree(actual[i].angular_rate_imu, Eigen::Vector3d(-x, 1, 10 * x), 1e-14));
    EXPECT_DOUBLE_EQ(actual[i].noise_scale, noise_scale);
  }
}

TEST(ImuBuffer, InstantsAreJoinedByStraightLines) {
  ImuBuffer buffer = four_samples(ImuConvention::kInstant);
  expect_intervals(buffer.between(milliseconds(10), milliseconds(30)), {{0.01, 1.5}, {0.01, 3}});
  // From 12 to 20 ms the line goes from 1.2 to 2, from 30 to 35 ms from 4 to 6.
  expect_intervals(buffer.between(milliseconds(12), milliseconds(35)),
                   {{0.008, 1.6}, {0.01, 3}, {0.005, 5}});
  expect_intervals(buffer.between(milliseconds(32), milliseconds(36)), {{0.004, 5.6}});
  EXPECT_EQ(buffer.counts().extrapolated, 0);
}

TEST(ImuBuffer, IntervalMeansHoldSinceTheSampleBefore) {
  ImuBuffer buffer = four_samples(ImuConvention::kIntervalMean);
  expect_intervals(buffer.between(milliseconds(10), milliseconds(30)), {{0.01, 2}, {0.01, 4}});
  expect_intervals(buffer.between(milliseconds(12), milliseconds(35)),
                   {{0.008, 2}, {0.01, 4}, {0.005, 8}});
  expect_intervals(buffer.between(milliseconds(32), milliseconds(36)), {{0.004, 8}});
  EXPECT_EQ(buffer.counts().extrapolated, 0);
}

TEST(ImuBuffer, CutsNeitherLoseTimeNorSignal) {
  test::Random random(1);
  for (const ImuConvention convention : {ImuConvention::kInstant, ImuConvention::kIntervalMean}) {
    ImuBuffer buffer({.convention = convention});
    Time time(1'700'000'000'123'456'789);
    const Time begin = time;
    for (int i = 0; i < 200; ++i) {
      buffer.add(sample(time, random.normal()));
      time += Time(4'000'000 + static_cast<long long>(random.next() % 3'000'000));
    }
    const auto sum = [](const std::vector<ImuInterval>& intervals) {
      Eigen::Vector2d total = Eigen::Vector2d::Zero();
      for (const ImuInterval& i : intervals) {
        EXPECT_GT(i.tau, 0);
        total += i.tau * Eigen::Vector2d(1, i.specific_force_imu.x());
      }
      return total;
    };
    const Time from = begin + Time(1'234'567);
    const Time to = begin + Time(654'321'987);
    const Eigen::Vector2d whole = sum(buffer.between(from, to));
    EXPECT_NEAR(whole.x(), to_seconds(to - from), 1e-15);
    Eigen::Vector2d parts = Eigen::Vector2d::Zero();
    for (Time start = from; start < to;) {
      const Time end =
          std::min(to, start + Time(1 + static_cast<long long>(random.next() % 20'000'000)));
      parts += sum(buffer.between(start, end));
      start = end;
    }
    EXPECT_TRUE(test::agree(parts, whole, 1e-14));
    EXPECT_EQ(buffer.counts().extrapolated, 0);
  }
}

TEST(ImuBuffer, OutsideItsSamplesTheNearestIsHeldAndCounted) {
  for (const ImuConvention convention : {ImuConvention::kInstant, ImuConvention::kIntervalMean}) {
    ImuBuffer buffer = four_samples(convention);
    expect_intervals(buffer.between(milliseconds(2), milliseconds(7)), {{0.005, 1}});
    EXPECT_EQ(buffer.counts().extrapolated, 1);
    expect_intervals(buffer.between(milliseconds(40), milliseconds(41)), {{0.001, 8}});
    EXPECT_EQ(buffer.counts().extrapolated, 2);
    EXPECT_EQ(buffer.between(milliseconds(0), milliseconds(60)).size(), 5U);
    EXPECT_EQ(buffer.counts().extrapolated, 3);
    // The variance grows with the time of holding: 110 and 200 ms, compared with the 50 ms limit.
    expect_intervals(buffer.between(milliseconds(-100), milliseconds(10)), {{0.11, 1, 2.2}});
    expect_intervals(buffer.between(milliseconds(-100), milliseconds(-60)), {{0.04, 1, 2.2}});
    expect_intervals(buffer.between(milliseconds(140), milliseconds(240)), {{0.1, 8, 4}});
  }
}

TEST(ImuBuffer, OneSampleIsHeldOnBothSides) {
  ImuBuffer buffer({});
  buffer.add(sample(milliseconds(10), 5));
  expect_intervals(buffer.between(milliseconds(0), milliseconds(20)), {{0.01, 5}, {0.01, 5}});
  EXPECT_EQ(buffer.counts().extrapolated, 1);
}

TEST(ImuBuffer, NothingToGiveIsEmpty) {
  ImuBuffer empty({});
  EXPECT_TRUE(empty.between(milliseconds(0), milliseconds(10)).empty());
  EXPECT_EQ(empty.counts().extrapolated, 0);
  ImuBuffer buffer = four_samples(ImuConvention::kInstant);
  EXPECT_TRUE(buffer.between(milliseconds(15), milliseconds(15)).empty());
  EXPECT_TRUE(buffer.between(milliseconds(25), milliseconds(15)).empty());
  EXPECT_TRUE(buffer.between(milliseconds(95), milliseconds(95)).empty());
  EXPECT_TRUE(buffer.between(milliseconds(95), milliseconds(85)).empty());
  EXPECT_EQ(buffer.counts().extrapolated, 0);
}

TEST(ImuBuffer, SamplesThatAreNotFiniteAreDropped) {
  ImuBuffer buffer = four_samples(ImuConvention::kInstant);
  ImuSample bad = sample(milliseconds(50), 1);
  bad.specific_force_imu.z() = kNaN;
  buffer.add(bad);
  bad = sample(milliseconds(50), 1);
  bad.angular_rate_imu.y() = std::numeric_limits<double>::infinity();
  buffer.add(bad);
  buffer.add(sample(milliseconds(50), 16));
  EXPECT_EQ(buffer.counts().not_finite, 2);
  EXPECT_EQ(buffer.counts().used, 5);
  expect_intervals(buffer.between(milliseconds(40), milliseconds(50)), {{0.01, 12}});
}

TEST(ImuBuffer, SamplesThatRepeatOrGoBackAreDropped) {
  ImuBuffer buffer = four_samples(ImuConvention::kInstant);
  buffer.add(sample(milliseconds(40), 100));
  buffer.add(sample(milliseconds(25), 100));
  EXPECT_EQ(buffer.counts().not_later, 2);
  EXPECT_EQ(buffer.counts().used, 4);
  expect_intervals(buffer.between(milliseconds(20), milliseconds(40)), {{0.01, 3}, {0.01, 6}});
  buffer.drop_before(milliseconds(1000));
  buffer.add(sample(milliseconds(30), 100));  // also after the later samples are removed
  EXPECT_EQ(buffer.counts().not_later, 3);
}

TEST(ImuBuffer, GapsAreBridgedWithMoreNoise) {
  ImuBuffer instants({.convention = ImuConvention::kInstant, .max_interval = 0.02});
  ImuBuffer means({.convention = ImuConvention::kIntervalMean, .max_interval = 0.02});
  for (ImuBuffer* buffer : {&instants, &means}) {
    buffer->add(sample(milliseconds(0), 1));
    buffer->add(sample(milliseconds(20), 2));  // just below the limit of a gap
    buffer->add(sample(milliseconds(120), 12));
    buffer->add(sample(milliseconds(130), 14));
    buffer->add(sample(milliseconds(160), 18));
    EXPECT_EQ(buffer->counts().gaps, 2);
    EXPECT_EQ(buffer->counts().used, 5);
  }
  expect_intervals(instants.between(milliseconds(0), milliseconds(160)),
                   {{0.02, 1.5}, {0.1, 7, 5}, {0.01, 13}, {0.03, 16, 1.5}});
  // Per second, a part of the gap is as uncertain as the whole.
  expect_intervals(instants.between(milliseconds(40), milliseconds(60)), {{0.02, 5, 5}});
  expect_intervals(means.between(milliseconds(0), milliseconds(160)),
                   {{0.02, 2}, {0.1, 12, 5}, {0.01, 14}, {0.03, 18, 1.5}});
}

TEST(ImuBuffer, DroppingKeepsWhatLaterIntervalsNeed) {
  for (const ImuConvention convention : {ImuConvention::kInstant, ImuConvention::kIntervalMean}) {
    for (const int ms : {5, 10, 14, 20, 29, 30, 37, 40, 55}) {
      ImuBuffer kept = four_samples(convention);
      ImuBuffer shortened = four_samples(convention);
      shortened.drop_before(milliseconds(ms));
      const auto expected = kept.between(milliseconds(ms), milliseconds(150));
      const auto actual = shortened.between(milliseconds(ms), milliseconds(150));
      ASSERT_EQ(actual.size(), expected.size());
      for (std::size_t i = 0; i < actual.size(); ++i) {
        EXPECT_EQ(actual[i].tau, expected[i].tau);
        EXPECT_EQ(actual[i].specific_force_imu, expected[i].specific_force_imu);
        EXPECT_EQ(actual[i].noise_scale, expected[i].noise_scale);
      }
    }
  }
  ImuBuffer buffer = four_samples(ImuConvention::kInstant);
  buffer.drop_before(milliseconds(35));  // removes the earlier samples: 30 ms is now the first
  expect_intervals(buffer.between(milliseconds(12), milliseconds(25)), {{0.013, 4}});
  EXPECT_EQ(buffer.counts().extrapolated, 1);
}

// A walk with sway and bob, in closed form.
Eigen::Matrix3d attitude(double t) {
  return so3::exp({0, 0, 0.6 * t + 0.5 * std::sin(0.9 * t)}) *
         so3::exp({0, 0.15 * std::sin(5 * t), 0}) * so3::exp({0.2 * std::sin(3.5 * t + 1), 0, 0});
}
Eigen::Vector3d position(double t) {
  return {6 * std::sin(0.5 * t), 4 * std::cos(0.7 * t), 0.05 * std::sin(11 * t)};
}
Eigen::Vector3d velocity(double t) {
  return {3 * std::cos(0.5 * t), -2.8 * std::sin(0.7 * t), 0.55 * std::cos(11 * t)};
}
Eigen::Vector3d acceleration(double t) {
  return {-1.5 * std::sin(0.5 * t), -1.96 * std::cos(0.7 * t), -6.05 * std::sin(11 * t)};
}
const Eigen::Vector3d kGravity(0, 0, -kStandardGravity);

ImuSample instant(double t) {
  const auto turned = [t](double h) { return so3::log(attitude(t).transpose() * attitude(t + h)); };
  constexpr double h = 1e-3;
  const Eigen::Vector3d rate =
      (8 * (turned(h) - turned(-h)) - (turned(2 * h) - turned(-2 * h))) / (12 * h);
  return {.time = from_seconds(t),
          .specific_force_imu = attitude(t).transpose() * (acceleration(t) - kGravity),
          .angular_rate_imu = rate};
}

// The mean over [t - period, t], by Simpson's rule.
ImuSample interval_mean(double t, double period) {
  const ImuSample a = instant(t - period), b = instant(t - period / 2), c = instant(t);
  const auto mean = [](const auto& x, const auto& y, const auto& z) {
    return Eigen::Vector3d((x + 4 * y + z) / 6);
  };
  return {
      .time = c.time,
      .specific_force_imu = mean(a.specific_force_imu, b.specific_force_imu, c.specific_force_imu),
      .angular_rate_imu = mean(a.angular_rate_imu, b.angular_rate_imu, c.angular_rate_imu)};
}

// Final position error of dead reckoning over 60 s, from one image (20 Hz, out of step with the
// samples) to the next.
double dead_reckoning_error(ImuConvention device, ImuConvention stated, int rate) {
  constexpr double kSeconds = 60;
  const double period = 1. / rate;
  ImuBuffer buffer({.convention = stated});
  for (int i = 0; i <= 60 * rate + 1; ++i) {
    const double t = i * period;
    ImuSample sample = instant(t);
    const ImuSample mean = interval_mean(t, period);
    if (!is_force_of_instant(device)) sample.specific_force_imu = mean.specific_force_imu;
    if (!is_rate_of_instant(device)) sample.angular_rate_imu = mean.angular_rate_imu;
    buffer.add(sample);
  }
  InertialState x{.world_T_imu = {attitude(0), position(0)}, .v_world = velocity(0)};
  const Time end = from_seconds(kSeconds);
  for (Time from{}; from < end;) {
    const Time to = std::min(end, from + Time(50'000'123));
    for (const ImuInterval& interval : buffer.between(from, to)) {
      x = integrate(x, interval, kGravity);
    }
    buffer.drop_before(to);
    from = to;
  }
  EXPECT_EQ(buffer.counts().extrapolated, 0);
  return (x.world_T_imu.p - position(kSeconds)).norm();
}

// docs/derivations.md, D36: with the matching convention the error is of second order in the sample
// period. With the other one every sample is half a period off: an error of first order, hundreds
// of times larger.
TEST(ImuBuffer, TheRightConventionClosesAndTheWrongOneDoesNot) {
  using enum ImuConvention;
  for (const auto& [device, other] :
       {std::pair{kInstant, kIntervalMean}, {kIntervalMean, kInstant}, {kInstantForce, kInstant}}) {
    SCOPED_TRACE(name_of(device));
    const double right_100 = dead_reckoning_error(device, device, 100);
    const double right_200 = dead_reckoning_error(device, device, 200);
    const double wrong_100 = dead_reckoning_error(device, other, 100);
    const double wrong_200 = dead_reckoning_error(device, other, 200);
    EXPECT_LT(right_100, 0.3);
    EXPECT_NEAR(right_100 / right_200, 4, 0.2);
    EXPECT_GT(wrong_100, 200 * right_100);
    EXPECT_NEAR(wrong_100 / wrong_200, 2, 0.1);
  }
}

TEST(ImuBuffer, ShowsTheSignalAtAnInstant) {
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    SCOPED_TRACE(name);
    ImuBuffer buffer({.convention = convention});
    EXPECT_FALSE(buffer.at(Time(0)));
    EXPECT_FALSE(buffer.latest());
    for (int k = 1; k <= 3; ++k) {
      const Eigen::Vector3d value(k, 10 * k, -k);
      buffer.add({.time = Time(1'000'000 * k),
                  .specific_force_imu = value,
                  .angular_rate_imu = 2 * value});
    }
    const auto is_at = [&](int nanoseconds, double force, double rate) {
      const auto sample = buffer.at(Time(nanoseconds));
      EXPECT_DOUBLE_EQ(sample->specific_force_imu.x(), force) << nanoseconds;
      EXPECT_DOUBLE_EQ(sample->angular_rate_imu.x(), 2 * rate) << nanoseconds;
    };
    is_at(0, 1, 1);
    is_at(1'000'000, 1, 1);
    is_at(1'250'000, is_force_of_instant(convention) ? 1.25 : 2,
          is_rate_of_instant(convention) ? 1.25 : 2);
    is_at(2'000'000, 2, 2);
    is_at(9'000'000, 3, 3);
    EXPECT_EQ(buffer.latest(), Time(3'000'000));
  }
}

// A walk: what the straight line through a gap misses has the variance that the intervals state.
TEST(ImuBuffer, TheNoiseOfAGapIsTheErrorOfItsBridge) {
  const double dt = 0.005;
  const auto signal = [](double t) {
    return Eigen::Vector3d(2 * std::sin(6 * t) + std::sin(13 * t + 1), 1.5 * std::cos(8 * t),
                           9.8 + 2 * std::sin(11 * t));
  };
  for (const double gap : {0.06, 0.1, 0.2, 0.4}) {
    double squares = 0;
    int count = 0;
    for (double from = 3; from < 9; from += 0.1) {
      ImuBuffer buffer({});
      Eigen::Vector3d missed = Eigen::Vector3d::Zero();
      for (double t = 0; t < from + gap + 0.1; t += dt) {
        const bool inside = t > from && t < from + gap - dt / 2;
        if (!inside) buffer.add({.time = from_seconds(t), .specific_force_imu = signal(t)});
      }
      double variance = 0;
      for (const ImuInterval& i : buffer.between(from_seconds(from), from_seconds(from + gap))) {
        missed -= i.specific_force_imu * i.tau;
        variance += i.accelerometer_extra_density * i.accelerometer_extra_density * i.tau;
      }
      for (double t = from; t < from + gap - dt / 2; t += dt) missed += signal(t + dt / 2) * dt;
      squares += missed.squaredNorm() / variance;
      count += 3;
    }
    EXPECT_LT(squares / count, 2) << gap;
    EXPECT_GT(squares / count, 0.2) << gap;
  }
}

}  // namespace
}  // namespace chasles
