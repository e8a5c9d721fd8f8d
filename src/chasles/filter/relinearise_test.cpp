#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/filter/pixel_testing.hpp>
#include <chasles/filter/relinearise.hpp>

// Gauss-Newton steps from measurements that are linearised elsewhere.
namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Relinearise : public testing::TestWithParam<ErrorChart> {};
INSTANTIATE_TEST_SUITE_P(Charts, Relinearise, testing::ValuesIn(error_charts()),
                         [](const auto& info) {
                           std::string name(info.param.name);
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

// A filter whose pose is far from the true one, and the pixels at the true state.
struct Far {
  Ekf filter;
  State truth;
  std::vector<PixelObservation> pixels;
};

Far far_from_truth(const ErrorChart& chart, double factor) {
  test::Random random(3);
  Ekf filter = test::inertial_filter(chart, random, true, true);
  const MatrixXd L = MatrixXd(filter.covariance()).llt().matrixL();
  VectorXd xi = factor * L * random.normal_vector(L.cols());
  push(chart, filter.state(), xi);
  Far far{.filter = filter, .truth = test::moved(chart, filter.state(), xi), .pixels = {}};
  for (std::size_t i = 0; i < far.truth.landmarks.size(); ++i) {
    for (int index = 0; index < 3; ++index) {
      const auto z = measure_pixel(test::kCameras[static_cast<std::size_t>(index)], 1, far.truth,
                                   static_cast<int>(i), Eigen::Vector2d::Zero(),
                                   Linearisation::kCurrent, index);
      if (!z) continue;
      far.pixels.push_back(
          {.landmark = static_cast<LandmarkId>(i), .camera = index, .pixel = -z->residual});
    }
  }
  return far;
}

std::vector<Measurement> measured_at(const State& y, const Far& far) {
  std::vector<Measurement> all;
  for (const PixelObservation& o : far.pixels) {
    all.push_back(measure_pixel(test::kCameras[static_cast<std::size_t>(o.camera)], 1, y,
                                static_cast<int>(o.landmark), o.pixel, Linearisation::kCurrent,
                                o.camera)
                      .value());
  }
  return all;
}

// What the update minimises, at y.
double cost(const Far& far, const State& y) {
  const State& x = far.filter.state();
  const VectorXd e = correction_between(far.filter.chart(), x, y);
  double sum = e.dot(MatrixXd(far.filter.covariance()).ldlt().solve(e));
  for (const Measurement& z : measured_at(y, far)) sum += z.residual.squaredNorm();
  return sum;
}

State step(const Far& far, const State& y) {
  const State& x = far.filter.state();
  const VectorXd correction = correction_between(far.filter.chart(), x, y);
  std::vector<Measurement> measurements = measured_at(y, far);
  for (Measurement& z : measurements) refer_to(far.filter.chart(), x, y, correction, z);
  return far.filter.updated_mean(measurements).value();
}

TEST_P(Relinearise, TheMeanOfAnUpdateIsThatOfTheUpdate) {
  Far far = far_from_truth(GetParam(), 0.2);
  const auto measurements = measured_at(far.filter.state(), far);
  const State mean = far.filter.updated_mean(measurements).value();
  far.filter.update(measurements);
  EXPECT_LT(test::distance(mean, far.filter.state()), 1e-12);
}

// It moves by nothing where the measurements are linearised at the mean itself.
TEST_P(Relinearise, AtTheSamePlaceNothingChanges) {
  const Far far = far_from_truth(GetParam(), 0.2);
  const State& x = far.filter.state();
  const State once = far.filter.updated_mean(measured_at(x, far)).value();
  EXPECT_LT(test::distance(step(far, x), once), 1e-9);
}

TEST_P(Relinearise, StepsLeadToAMinimumOfTheCost) {
  const Far far = far_from_truth(GetParam(), 0.7);
  const State& x = far.filter.state();
  const State once = step(far, x);
  State y = once;
  for (int i = 0; i < 8; ++i) y = step(far, y);
  EXPECT_LT(test::distance(step(far, y), y), 1e-3) << "has not converged";
  const double least = cost(far, y);
  EXPECT_LT(least, 0.5 * cost(far, once));
  EXPECT_LT(least, 1.1 * cost(far, far.truth));
  // No small step in any direction leads much lower.
  test::Random random(5);
  const MatrixXd L = MatrixXd(far.filter.covariance()).llt().matrixL();
  for (int i = 0; i < 50; ++i) {
    VectorXd xi = 0.02 * L * random.normal_vector(L.cols());
    push(far.filter.chart(), y, xi);
    EXPECT_GT(cost(far, test::moved(far.filter.chart(), y, xi)), 0.99 * least);
  }
}

}  // namespace
}  // namespace chasles
