#include <cmath>
#include <random>

#include <fmt/format.h>

#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sample_batches.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::expect_parts;

constexpr Time kPeriod = milliseconds(5);

// Samples of a smooth motion at 200 Hz, each with its true time.
std::vector<ImuSample> smooth(std::size_t count) {
  std::vector<ImuSample> imu;
  for (std::size_t i = 0; i < count; ++i) {
    const Time time = milliseconds(1000) + static_cast<int>(i) * kPeriod;
    const double t = to_seconds(time);
    imu.push_back({.time = time,
                   .specific_force_imu = {std::sin(t), std::cos(2 * t), 9.8},
                   .angular_rate_imu = {0.1 * std::cos(t), t, 0.2}});
  }
  return imu;
}

// As a driver delivers them: batches of `sizes`, each with the time of its last sample.
std::vector<ImuSample> batched(std::vector<ImuSample> imu, const std::vector<std::size_t>& sizes) {
  for (std::size_t i = 0, b = 0; i < imu.size(); ++b) {
    const std::size_t end = std::min(imu.size(), i + sizes[b % sizes.size()]);
    for (; i < end; ++i) imu[i].time = imu[end - 1].time;
  }
  return imu;
}

struct Spread {
  std::vector<ImuSample> imu;
  std::vector<std::string> remarks;
};

Spread spread(std::vector<ImuSample> imu) {
  Spread result{.imu = std::move(imu), .remarks = {}};
  spread_batches(result.imu, "IMU samples", result.remarks);
  return result;
}

Time largest_error(const std::vector<ImuSample>& found, const std::vector<ImuSample>& truth) {
  Time most{};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    most = std::max(most, std::chrono::abs(found[i].time - truth[i].time));
  }
  return most;
}

TEST(SampleBatches, OfAnySizeGetTheirTimesBack) {
  const std::vector<ImuSample> truth = smooth(900);
  for (const std::size_t size : {2u, 3u, 4u, 7u, 10u}) {
    const Spread all = spread(batched(truth, {size}));
    EXPECT_LE(largest_error(all.imu, truth), microseconds(1)) << size;
    ASSERT_EQ(all.remarks.size(), 1u) << size;
    expect_parts(all.remarks[0], {"of 900 IMU samples", "5.00 ms from one to the next"});
  }
  const Spread mixed = spread(batched(truth, {3, 1, 10, 2, 1, 6}));
  EXPECT_LE(largest_error(mixed.imu, truth), microseconds(1));
  expect_parts(mixed.remarks.at(0), {"in batches of 2 to 10"});
}

// A timer of the system delivers what has come since: the sizes vary, the times of delivery do too.
TEST(SampleBatches, DeliveredAtRandomStayWithinTheirWait) {
  const std::vector<ImuSample> truth = smooth(2000);
  std::vector<ImuSample> imu = truth;
  std::mt19937 random(7);
  for (std::size_t i = 0; i < imu.size();) {
    const std::size_t end = std::min(imu.size(), i + 2 + random() % 9);
    const Time late = microseconds(random() % 4000);
    for (; i < end; ++i) imu[i].time = truth[end - 1].time + late;
  }
  const Spread all = spread(imu);
  EXPECT_LE(largest_error(all.imu, truth), microseconds(4000));
  EXPECT_GE(largest_error(imu, truth), milliseconds(45)) << "as it was";
  for (std::size_t i = 1; i < all.imu.size(); ++i) {
    ASSERT_LT(all.imu[i - 1].time, all.imu[i].time) << i;
  }
}

TEST(SampleBatches, AfterAGapKeepTheUsualDistance) {
  std::vector<ImuSample> truth = smooth(400);
  truth.erase(truth.begin() + 200, truth.begin() + 300);
  EXPECT_LE(largest_error(spread(batched(truth, {4})).imu, truth), microseconds(1));
}

TEST(SampleBatches, CopiesStayCopies) {
  std::vector<ImuSample> twice;
  for (const ImuSample& sample : smooth(300)) twice.insert(twice.end(), 2, sample);
  EXPECT_EQ(spread(twice).remarks.size(), 0u);
  EXPECT_EQ(largest_error(spread(twice).imu, twice), Time{});
  // Batches of two, each written twice: a b a b.
  const std::vector<ImuSample> truth = smooth(300);
  const std::vector<ImuSample> pairs = batched(truth, {2});
  Recording recording;
  for (std::size_t i = 0; i < pairs.size(); i += 2) {
    for (const std::size_t k : {i, i + 1, i, i + 1}) recording.imu.push_back(pairs[k]);
  }
  tidy_samples("imu.csv", recording);
  ASSERT_EQ(recording.imu.size(), truth.size());
  EXPECT_LE(largest_error(recording.imu, truth), microseconds(1));
}

// Of a driver with a few repeated stamps the second of two was left out before, and is so still.
TEST(SampleBatches, AFewRepeatedStampsAreNone) {
  std::vector<ImuSample> imu = smooth(400);
  for (std::size_t i = 0; i < 400; i += 40) imu[i].time = imu[i + 1].time;
  const Spread all = spread(imu);
  EXPECT_EQ(all.remarks.size(), 0u);
  EXPECT_EQ(largest_error(all.imu, imu), Time{});
}

// The reader of a table passes here, as that of a bag does.
TEST(SampleBatches, OfATableAreSpread) {
  const std::vector<ImuSample> truth = smooth(200);
  std::string table = test::kEurocImuColumns;
  for (const ImuSample& s : batched(truth, {3, 5, 2})) {
    const Eigen::Vector3d &w = s.angular_rate_imu, &a = s.specific_force_imu;
    table += fmt::format("{},{},{},{},{},{},{}\n", s.time.count(), w.x(), w.y(), w.z(), a.x(),
                         a.y(), a.z());
  }
  const auto file = test::scratch() / "walk_imu.csv";
  test::spill(file, table);
  const Recording recording = read_recording(file);
  ASSERT_EQ(recording.imu.size(), truth.size());
  EXPECT_LE(largest_error(recording.imu, truth), microseconds(1));
  expect_parts(recording.remarks.at(0), {"200 of 200 IMU samples", "in batches of 2 to 5"});
}

TEST(SampleBatches, RoundedStampsAreStillRejected) {
  Recording recording;
  recording.imu = smooth(2000);
  for (ImuSample& sample : recording.imu) {
    sample.time = std::chrono::floor<std::chrono::seconds>(sample.time);
  }
  expect_parts(test::input_error([&] { tidy_samples("imu.csv", recording); }),
               {"imu.csv: 2000 IMU samples have only 10 different times"});
}

}  // namespace
}  // namespace chasles
