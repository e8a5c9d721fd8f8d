#include <cmath>
#include <limits>

#include <chasles/base/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

struct Value {
  double probability, dof, x;
};

// /usr/bin/python3 -c "import scipy.stats as s
// for p,k in [(.95,1),(.95,2),(.95,3),(.975,3),(.025,3),(.95,6),(.975,6),(.025,6),(.99,4),(.5,1),
//             (1e-6,2),(.999999,9),(.025,300),(.975,300),(.025,6600),(.975,6600),(.975,123456),
//             (.3,.5),(.025,19),(.9,21)]: print(f'{{{p}, {k}, {s.chi2.ppf(p,k):.17g}}},')"
// The first eight are also in every printed table (3.841, 5.991, 7.815, 9.348, 0.216, 12.592,
// 14.449, 1.237).
const std::vector<Value> kScipy = {
    {0.95, 1, 3.841458820694124},        {0.95, 2, 5.991464547107979},
    {0.95, 3, 7.8147279032511792},       {0.975, 3, 9.3484036044961485},
    {0.025, 3, 0.21579528262389785},     {0.95, 6, 12.591587243743977},
    {0.975, 6, 14.44937533544792},       {0.025, 6, 1.2373442457912027},
    {0.99, 4, 13.276704135987622},       {0.5, 1, 0.454936423119572},
    {1e-06, 2, 2.0000010000006676e-06},  {0.999999, 9, 44.810937870620258},
    {0.025, 300, 253.91232260248975},    {0.975, 300, 349.87446882991526},
    {0.025, 6600, 6376.7175333006417},   {0.975, 6600, 6827.0709959064234},
    {0.975, 123456, 124431.80373685221}, {0.3, 0.5, 0.010982604948550948},
    {0.025, 19, 8.9065164819879712},     {0.9, 21, 29.615089436182739},
};

TEST(Chi2, QuantilesAreThePublishedOnes) {
  for (const Value& v : kScipy) {
    EXPECT_NEAR(chi2_quantile(v.probability, v.dof) / v.x, 1, 1e-11)
        << v.probability << " " << v.dof;
  }
}

TEST(Chi2, TheDistributionAtItsQuantilesIsTheProbability) {
  for (const Value& v : kScipy) {
    EXPECT_NEAR(chi2_cdf(v.x, v.dof), v.probability, 1e-12) << v.probability << " " << v.dof;
  }
}

TEST(Chi2, OfTwoDegreesIsTheExponentialDistribution) {
  for (double x = 0.01; x < 60; x *= 1.3) {
    EXPECT_NEAR(chi2_cdf(x, 2), -std::expm1(-x / 2), 1e-15) << x;
  }
}

TEST(Chi2, OfOneDegreeIsTheSquareOfANormal) {
  for (double x = 0.001; x < 60; x *= 1.3) {
    EXPECT_NEAR(chi2_cdf(x, 1), std::erf(std::sqrt(x / 2)), 1e-14) << x;
  }
}

TEST(Chi2, TheDistributionGrowsAcrossTheSwitchOfExpansions) {
  for (const double dof : {0.5, 1.0, 6.0, 19.9, 20.1, 600.0, 60000.0}) {
    const double before = chi2_cdf((dof + 2) * (1 - 1e-12), dof);
    const double after = chi2_cdf((dof + 2) * (1 + 1e-12), dof);
    EXPECT_NEAR(before, after, 1e-9) << dof;
    EXPECT_LE(before, after + 1e-13) << dof;
  }
}

TEST(Chi2, EndsOfTheRange) {
  EXPECT_EQ(chi2_cdf(0, 3), 0);
  EXPECT_EQ(chi2_cdf(-1, 3), 0);
  EXPECT_EQ(chi2_cdf(std::numeric_limits<double>::infinity(), 3), 1);
  EXPECT_EQ(chi2_quantile(0, 3), 0);
  EXPECT_TRUE(std::isnan(chi2_cdf(std::nan(""), 3)));
}

TEST(Chi2, RejectsWhatHasNoMeaning) {
  EXPECT_THROW(chi2_cdf(1, 0), UsageError);
  EXPECT_THROW(chi2_cdf(1, std::nan("")), UsageError);
  EXPECT_THROW(chi2_quantile(1, 3), UsageError);
  EXPECT_THROW(chi2_quantile(-0.1, 3), UsageError);
  EXPECT_THROW(chi2_quantile(std::nan(""), 3), UsageError);
  EXPECT_THROW(chi2_band(3, 0), UsageError);
  EXPECT_THROW(chi2_band(3, 1, 1), UsageError);
}

TEST(Chi2, TheBandOfFiftyRunsIsTheTextbookOne) {
  // Bar-Shalom, Li, Kirubarajan (2001), example of §5.4.2: N = 50, nx = 2: [1.5, 2.6].
  const Band band = chi2_band(2, 50);
  EXPECT_NEAR(band.low, 1.5, 0.05);
  EXPECT_NEAR(band.high, 2.6, 0.05);
}

TEST(Chi2, TheBandHoldsTheMeanOfDrawsAsOftenAsItSays) {
  test::Random random(21);
  const Band band = chi2_band(3, 20);
  int inside = 0;
  constexpr int kRepeats = 4000;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    inside += band.contains(random.normal_vector(60).squaredNorm() / 20);
  }
  // Four standard deviations of a binomial with p = 0.95.
  EXPECT_NEAR(inside, 0.95 * kRepeats, 4 * std::sqrt(kRepeats * 0.95 * 0.05));
}

TEST(Nis, IsOnePerDegreeOfFreedomForInnovationsOfTheirCovariance) {
  test::Random random(22);
  std::vector<Nis> updates;
  for (int i = 0; i < 500; ++i) {
    const int dof = static_cast<int>(random.next() % 9) * 4;
    updates.push_back({random.normal_vector(dof).squaredNorm(), dof});
  }
  const NisSummary summary = summarize_nis(updates);
  EXPECT_LT(summary.frames, 500U);
  EXPECT_TRUE(summary.band.contains(summary.per_dof)) << summary.per_dof;
  EXPECT_NEAR(summary.band.high - summary.band.low, 2 * 1.96 * std::sqrt(2 / summary.dof), 1e-4);
}

TEST(Nis, WithoutObservationsIsEmpty) {
  const std::vector<Nis> nothing = {{0, 0}, {0, 0}};
  EXPECT_EQ(summarize_nis(nothing).frames, 0U);
  EXPECT_EQ(summarize_nis(nothing).per_dof, 0);
  EXPECT_EQ(summarize_nis({}).frames, 0U);
}

}  // namespace
}  // namespace chasles
