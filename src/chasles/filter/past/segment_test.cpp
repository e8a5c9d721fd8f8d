#include <chasles/filter/past/segment.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

// Segments against the sums that define them, for matrices at random.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// A segment from a state with `starts` rows to one with `rows`, with two items.
Segment some_segment(test::Random& random, Index starts, Index rows, int first_number) {
  Segment segment;
  segment.starts = starts;
  segment.items = {{.number = first_number, .size = 3}, {.number = first_number + 1, .size = 6}};
  const Index q = starts + 9;
  segment.X = test::random_matrix(random, rows, q);
  segment.G = test::random_covariance(random, static_cast<int>(q), 1);
  segment.g = random.normal_vector(q);
  return segment;
}

// Landmarks of the past, before a state with `rows` rows.
Carried some_past(test::Random& random, Index rows) {
  Carried past;
  past.items = {{.number = 0, .size = 3}, {.number = 1, .size = 3}};
  past.C = test::random_matrix(random, 6, rows);
  past.P = test::random_covariance(random, 6, 2);
  past.correction = random.normal_vector(6);
  return past;
}

void expect_same(const Segment& a, const Segment& b) {
  EXPECT_EQ(a.starts, b.starts);
  EXPECT_EQ(a.length, b.length);
  ASSERT_EQ(a.items.size(), b.items.size());
  for (std::size_t i = 0; i < a.items.size(); ++i) EXPECT_EQ(a.items[i].number, b.items[i].number);
  EXPECT_TRUE(test::agree(a.X, b.X, 1e-12, 0));
  EXPECT_TRUE(test::agree(a.G, b.G, 1e-12, 0));
  EXPECT_TRUE(test::agree(a.g, b.g, 1e-12, 0));
}

void expect_same(const Carried& a, const Carried& b) {
  ASSERT_EQ(a.items.size(), b.items.size());
  for (std::size_t i = 0; i < a.items.size(); ++i) EXPECT_EQ(a.items[i].number, b.items[i].number);
  EXPECT_TRUE(test::agree(a.C, b.C, 1e-12, 0));
  EXPECT_TRUE(test::agree(a.P, b.P, 1e-12, 0));
  EXPECT_TRUE(test::agree(a.correction, b.correction, 1e-12, 0));
}

// p = A s + e for an item s, so that its covariances follow.
TEST(Segment, DerivedItemsAreLinearFunctionsOfTheirSource) {
  test::Random random(9);
  const Segment before = some_segment(random, 5, 7, 10);
  const MatrixXd A = test::random_matrix(random, 3, 6), own = test::random_covariance(random, 3, 1);
  // Two of them; their numbers are before and after the first item's.
  const MatrixXd B = test::random_matrix(random, 3, 6);
  const Segment after =
      with_derived(before, 11,
                   {{.item = {20, 3}, .by_source = A, .own = own},
                    {.item = {4, 3}, .by_source = B, .own = MatrixXd::Zero(3, 3)}});
  std::vector<int> numbers;
  for (const Segment::Item& item : after.items) numbers.push_back(item.number);
  ASSERT_EQ(numbers, (std::vector{4, 10, 11, 20}));
  expect_same(with_items(after, {10, 11}), before);
  const Index a = after.place(20), b = after.place(4), s = before.place(11);
  const MatrixXd S = before.G.block(s, s, 6, 6);
  EXPECT_TRUE(test::agree(after.G.block(a, a, 3, 3), A * S * A.transpose() + own, 1e-12, 0));
  EXPECT_TRUE(test::agree(after.G.block(a, b, 3, 3), A * S * B.transpose(), 1e-12, 0));
  EXPECT_TRUE(test::agree(after.G.block(a, 0, 3, 5), A * before.G.block(s, 0, 6, 5), 1e-12, 0));
  EXPECT_TRUE(
      test::agree(after.X.middleCols(b, 3), before.X.middleCols(s, 6) * B.transpose(), 1e-12, 0));
  EXPECT_TRUE(test::agree(after.g.segment(a, 3), A * before.g.segment(s, 6), 1e-12, 0));
}

TEST(Segment, CompositionIsAssociative) {
  test::Random random(1);
  const Segment a = some_segment(random, 8, 7, 10), b = some_segment(random, 7, 9, 20),
                c = some_segment(random, 9, 6, 30);
  expect_same(compose(compose(a, b), c), compose(a, compose(b, c)));
}

TEST(Segment, CarriesThePastAsItsDefinitionSays) {
  test::Random random(2);
  const Segment s = some_segment(random, 7, 5, 10);
  const Carried before = some_past(random, 7);
  Carried after = before;
  carry(after, s, {10});
  const MatrixXd C = before.C;
  MatrixXd P(9, 9);
  P << before.P + C * s.G.topLeftCorner(7, 7) * C.transpose(), C * s.G.block(0, 7, 7, 3),
      (C * s.G.block(0, 7, 7, 3)).transpose(), s.G.block(7, 7, 3, 3);
  MatrixXd with_state(9, 5);
  with_state << C * s.X.leftCols(7).transpose(), s.X.middleCols(7, 3).transpose();
  EXPECT_TRUE(test::agree(after.P, P, 1e-13, 0));
  EXPECT_TRUE(test::agree(after.C, with_state, 1e-13, 0));
  EXPECT_TRUE(test::agree(after.correction.head(6), before.correction + C * s.g.head(7), 1e-13, 0));
  EXPECT_EQ(after.correction.tail(3), s.g.segment(7, 3));
}

TEST(Segment, ACompositionCarriesAsItsPartsDoOneAfterTheOther) {
  test::Random random(3);
  const Segment a = some_segment(random, 8, 7, 10), b = some_segment(random, 7, 9, 20);
  const std::vector<int> numbers{10, 11, 20, 21};
  Carried together = some_past(random, 8);
  Carried apart = together;
  carry(together, compose(a, b), numbers);
  carry(apart, a, numbers);
  carry(apart, b, numbers);
  expect_same(together, apart);
}

// What leaves later then sees them as rows of the state.
TEST(Segment, WhatIsTakenAlongIsARowOfTheNextState) {
  test::Random random(4);
  const Segment a = some_segment(random, 8, 7, 10);
  Carried observer = some_past(random, 8);
  const MatrixXd C = observer.C;
  Segment taken = a;
  take_along(taken, {10});
  ASSERT_EQ(taken.X.rows(), 7 + 3);
  carry(observer, taken, {});
  MatrixXd expected(C.rows(), 10);
  expected << C * a.X.leftCols(8).transpose(), C * a.G.block(0, 8, 8, 3);
  EXPECT_TRUE(test::agree(observer.C, expected, 1e-12, 0));
}

TEST(Segment, SelectsItems) {
  test::Random random(5);
  const Segment a = some_segment(random, 4, 5, 10);
  const Segment one = with_items(a, {11});
  ASSERT_EQ(one.items.size(), 1u);
  EXPECT_EQ(one.items[0].number, 11);
  EXPECT_EQ(one.X.rightCols(6), a.X.rightCols(6));
  EXPECT_EQ(one.G.bottomLeftCorner(6, 4), a.G.bottomLeftCorner(6, 4));
  EXPECT_EQ(one.place(11), 4);
  EXPECT_EQ(one.place(10), -1);
}

}  // namespace
}  // namespace chasles
