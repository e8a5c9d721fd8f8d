#include <chasles/slam/innovation_correlation.hpp>
#include <chasles/slam/step_testing.hpp>

namespace chasles {
namespace {

TEST(InnovationCorrelation, IsThatOfSuccessiveFrames) {
  const std::vector<PixelObservation> pixels{{.landmark = 1}, {.landmark = 2}};
  const auto report = [](double a, double b) {
    UpdateReport r;
    r.accepted = {true, true};
    r.whitened = {Eigen::Vector2d(a, 0), Eigen::Vector2d(b, 0)};
    return r;
  };
  InnovationCorrelation correlation;
  Estimate first, second, third;
  correlation.add(test::pointers(pixels), report(1, 2), first);
  EXPECT_EQ(first.innovation_products, 0);
  correlation.add(test::pointers(pixels), report(3, -1), second);
  EXPECT_DOUBLE_EQ(second.innovation_products, 1 * 3 - 2 * 1);
  EXPECT_DOUBLE_EQ(second.innovation_squares, (1 + 9) / 2. + (4 + 1) / 2.);
  UpdateReport rejected = report(5, 5);
  rejected.accepted = {false, false};
  correlation.add(test::pointers(pixels), rejected, third);
  EXPECT_EQ(third.innovation_squares, 0);
}

}  // namespace
}  // namespace chasles
