#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/numeric/random.hpp>

namespace chasles {
namespace {

using Words = std::array<std::uint32_t, 4>;

constexpr std::size_t kSamples = 200'000;
constexpr double kRandomSigmas = 4;  // of the statistic under test; the seeds are fixed

std::vector<double> draw(const std::function<double(std::size_t)>& number) {
  std::vector<double> numbers(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i) numbers[i] = number(i);
  return numbers;
}

double mean_of(const std::vector<double>& numbers, const std::function<double(double)>& f) {
  double sum = 0;
  for (const double x : numbers) sum += f(x);
  return sum / static_cast<double>(numbers.size());
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum / static_cast<double>(a.size());
}

const double kRoot = std::sqrt(static_cast<double>(kSamples));

TEST(Random, PhiloxGivesTheWordsThatItsAuthorsPublish) {
  // Known-answer test vectors of the Random123 distribution for philox4x32, 10 rounds.
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, SameNumbersEverywhere) {
  // From a Python implementation of the same definition.
  const Random random{42};
  EXPECT_DOUBLE_EQ(random.uniform(Stream::kBirth, 7, 3), 0.9353369120288438);
  EXPECT_DOUBLE_EQ(random.normal(Stream::kPixelNoise, 123456789012345, 1), 0.1827566292756502);
}

TEST(Random, NormalNumbersHaveTheMomentsOfTheNormalDistribution) {
  for (const std::uint64_t seed : {1ULL, 2ULL, 0xffffffffffffffffULL}) {
    const Random random{seed};
    const auto x = draw([&](std::size_t i) { return random.normal(Stream::kPixelNoise, i); });
    const auto moment = [&](int n) { return mean_of(x, [&](double v) { return std::pow(v, n); }); };
    // The variances of the powers: E x^2n - (E x^n)^2 = 1, 2, 15, 96.
    EXPECT_LT(std::abs(moment(1)), kRandomSigmas * 1 / kRoot);
    EXPECT_LT(std::abs(moment(2) - 1), kRandomSigmas * std::sqrt(2) / kRoot);
    EXPECT_LT(std::abs(moment(3)), kRandomSigmas * std::sqrt(15) / kRoot);
    EXPECT_LT(std::abs(moment(4) - 3), kRandomSigmas * std::sqrt(96) / kRoot);
  }
}

TEST(Random, NormalTailsAreThere) {
  const Random random{3};
  const auto x = draw([&](std::size_t i) { return random.normal(Stream::kLinearNoise, i); });
  const double beyond_three = mean_of(x, [](double v) { return std::abs(v) > 3 ? 1.0 : 0.0; });
  EXPECT_NEAR(beyond_three, 0.0026998, kRandomSigmas * std::sqrt(0.0027) / kRoot);
}

TEST(Random, UniformNumbersFillEveryCellOfTheUnitIntervalEqually) {
  const Random random{5};
  std::vector<double> counts(100);
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double u = random.uniform(Stream::kBirth, i);
    ASSERT_GT(u, 0);
    ASSERT_LT(u, 1);
    counts[static_cast<std::size_t>(100 * u)] += 1;
  }
  const double expected = kSamples / 100.0;
  double chi2 = 0;
  for (const double n : counts) chi2 += (n - expected) * (n - expected) / expected;
  // 99 degrees of freedom: mean 99, standard deviation sqrt(198).
  EXPECT_NEAR(chi2, 99, kRandomSigmas * std::sqrt(198));
}

TEST(Random, StreamsSeedsComponentsAndNeighboursAreUncorrelated) {
  const Random a{9}, b{10};
  const auto x = draw([&](std::size_t i) { return a.normal(Stream::kLinearNoise, i); });
  const std::vector<std::vector<double>> others = {
      draw([&](std::size_t i) { return a.normal(Stream::kAngularNoise, i); }),
      draw([&](std::size_t i) { return a.normal(Stream::kLinearNoise, i, 1); }),
      draw([&](std::size_t i) { return a.normal(Stream::kLinearNoise, i + 1); }),
      draw([&](std::size_t i) { return b.normal(Stream::kLinearNoise, i); }),
  };
  for (const auto& y : others) EXPECT_LT(std::abs(correlation(x, y)), kRandomSigmas / kRoot);
}

TEST(Random, EveryPartOfTheAddressCounts) {
  std::set<double> seen;
  for (const std::uint64_t seed : {0ULL, 1ULL, 1ULL << 32}) {
    for (const std::uint64_t index : {0ULL, 1ULL, 1ULL << 32}) {
      for (const Stream stream : {Stream::kBirth, Stream::kLife}) {
        for (const std::uint32_t component : {0U, 1U}) {
          seen.insert(Random{seed}.uniform(stream, index, component));
        }
      }
    }
  }
  EXPECT_EQ(seen.size(), 36U);
}

}  // namespace
}  // namespace chasles
