#include <chasles/filter/covariance.hpp>
#include <chasles/filter/testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;

TEST(Covariance, AppendsRowsOfZerosAndKeepsTheRest) {
  test::Random random(1);
  const MatrixXd initial = test::random_covariance(random, 9, 2);
  Covariance P(initial);
  EXPECT_EQ(P.append(6), 9);
  MatrixXd expected = MatrixXd::Zero(15, 15);
  expected.topLeftCorner(9, 9) = initial;
  EXPECT_EQ(MatrixXd(P.all()), expected);
}

TEST(Covariance, AppendedRowsAreZeroWhereOthersStoodBefore) {
  Covariance P(MatrixXd::Constant(6, 6, 3.0));
  P.keep({0, 1});
  P.append(4);
  MatrixXd expected = MatrixXd::Zero(6, 6);
  expected.topLeftCorner(2, 2).setConstant(3);
  EXPECT_EQ(MatrixXd(P.all()), expected);
}

TEST(Covariance, KeepsTheNumbersOfTheRowsThatStay) {
  test::Random random(2);
  const MatrixXd initial = test::random_covariance(random, 20, 1);
  const std::vector<std::vector<int>> choices = {
      {}, {19}, {0}, {0, 1, 2}, {3, 4, 7, 12, 19}, {1, 3, 5, 7, 9, 11, 13, 15, 17, 19}};
  for (const std::vector<int>& rows : choices) {
    Covariance P(initial);
    P.keep(rows);
    EXPECT_EQ(MatrixXd(P.all()), MatrixXd(initial(rows, rows)));
  }
}

TEST(Covariance, SpreadPutsRowsWhereTheyWereBeforeAndZerosBetween) {
  test::Random random(5);
  const std::vector<std::vector<int>> choices = {
      {}, {19}, {0}, {0, 1, 2}, {3, 4, 7, 12, 18}, {1, 3, 5, 7, 9, 11, 13, 15, 17, 19}};
  for (const int size : {20, 300}) {
    for (const std::vector<int>& rows : choices) {
      Covariance P(test::random_covariance(random, 20, 1));  // leaves values in the memory
      P.keep(rows);
      MatrixXd expected = MatrixXd::Zero(size, size);
      expected(rows, rows) = P.all();
      P.spread(rows, size);
      EXPECT_EQ(MatrixXd(P.all()), expected);
    }
  }
}

TEST(Covariance, TruncateDropsTheLastRows) {
  test::Random random(6);
  const MatrixXd initial = test::random_covariance(random, 20, 1);
  Covariance P(initial);
  P.truncate(11);
  EXPECT_EQ(MatrixXd(P.all()), MatrixXd(initial.topLeftCorner(11, 11)));
}

TEST(Covariance, GrowsPastItsFirstRoom) {
  test::Random random(3);
  const MatrixXd initial = test::random_covariance(random, 100, 1);
  Covariance P(initial);
  MatrixXd expected = initial;
  for (int i = 0; i < 30; ++i) {
    const int first = P.append(30);
    P.all().rightCols(1).setConstant(i);
    P.all().bottomRows(1).setConstant(i);
    expected.conservativeResize(first + 30, first + 30);
    expected.rightCols(30).setZero();
    expected.bottomRows(30).setZero();
    expected.rightCols(1).setConstant(i);
    expected.bottomRows(1).setConstant(i);
  }
  EXPECT_EQ(P.size(), 1000);
  EXPECT_EQ(MatrixXd(P.all()), expected);
}

TEST(Covariance, TakesAnInitialLargerThanItsFirstRoom) {
  test::Random random(4);
  const MatrixXd initial = test::random_covariance(random, 300, 1);
  EXPECT_EQ(MatrixXd(Covariance(initial).all()), initial);
}

}  // namespace
}  // namespace chasles
