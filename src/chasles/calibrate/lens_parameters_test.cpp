#include <gtest/gtest.h>

#include <chasles/calibrate/lens_parameters.hpp>

namespace chasles::test {
namespace {

// fx, fy, cx, cy and coefficients that no two rows share.
Eigen::VectorXd some_parameters(const LensForm& lens) {
  Eigen::VectorXd parameters(lens.parameters());
  parameters.head<4>() << 400, 410, 320, 240;
  for (int i = 4; i < lens.parameters(); ++i) parameters[i] = 0.1 + 0.07 * i - 0.005 * i * i;
  return parameters;
}

class SearchCoordinates : public testing::TestWithParam<const char*> {};

TEST_P(SearchCoordinates, LeadBackAndHaveTheirDerivative) {
  const LensForm lens = lens_form(GetParam(), "lens");
  const Eigen::VectorXd parameters = some_parameters(lens);
  const Eigen::VectorXd coordinates = search_coordinates(lens, parameters);
  EXPECT_LT((from_search_coordinates(lens, coordinates) - parameters).norm(), 1e-10);
  const Eigen::MatrixXd derivative = by_search_coordinates(lens, coordinates);
  for (int i = 0; i < lens.parameters(); ++i) {
    const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(lens.parameters(), i);
    const Eigen::VectorXd slope = (from_search_coordinates(lens, coordinates + step) -
                                   from_search_coordinates(lens, coordinates - step)) /
                                  2e-5;
    EXPECT_LT((slope - derivative.col(i)).norm(), 1e-5) << i << ": " << derivative.col(i);
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, SearchCoordinates,
                         testing::Values("radtan", "radtan:8", "equidistant", "ds", "eucm", "omni",
                                         "omni:5"));

}  // namespace
}  // namespace chasles::test
