#include <algorithm>
#include <deque>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/window/window_detail.hpp>

// The prior of a window at other values than its own, and its independence of the scale, which
// pixels do not determine.
namespace chasles::smooth_detail {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

WindowKeyframe keyframe_of(const InertialState& state) {
  WindowKeyframe keyframe{.additive = state.biases()};
  write_motion(state, keyframe.motion.data());
  return keyframe;
}

// Four keyframes and six landmarks of the prior, at three to ten metres.
Window window_of(const ErrorChart& chart, bool anchored, test::Random& random) {
  Window window{.sizes = {}, .chart = &chart, .anchored = anchored};
  for (int k = 0; k < 4; ++k) {
    window.keyframes.push_back(
        keyframe_of({.world_T_imu = {.R = so3::exp(0.2 * random.normal_vector(3)),
                                     .p = Eigen::Vector3d(0.5 * k, 0.1 * k, 0) +
                                          0.05 * random.normal_vector(3)},
                     .v_world = Eigen::Vector3d(1, 0.2, 0) + 0.1 * random.normal_vector(3)}));
  }
  for (int i = 0; i < 6; ++i) {
    const double depth = random.uniform(3, 10);
    const Eigen::Vector3d way(random.uniform(-2, 2), random.uniform(-2, 2), depth);
    WindowPoint point{.id = i, .anchor = 3};
    point.parameters = anchored ? Eigen::Vector3d(way.x(), way.y(), 1) / depth : way;
    point.in_prior = true;
    window.points.emplace(i, std::move(point));
  }
  return window;
}

ScaledNumbers numbers_of(const Window& window) {
  ScaledNumbers numbers;
  numbers.keyframes = {window.keyframes.begin(), window.keyframes.end()};
  for (const auto& [number, point] : window.points)
    numbers.points.emplace(number, point.parameters);
  return numbers;
}

// Possible information from pixels: none along that direction.
WindowSystem blind_along(const VectorXd& s, test::Random& random) {
  const auto n = static_cast<int>(s.size());
  MatrixXd A = MatrixXd::NullaryExpr(3 * n, n, [&] { return 10 * random.normal(); });
  A -= A * s * s.transpose() / s.squaredNorm();
  return {.S = A.transpose() * A, .g = A.transpose() * random.normal_vector(3 * n)};
}

// A window with the prior of such a system.
Window blind_window(const ErrorChart& chart, bool anchored, test::Random& random) {
  Window window = window_of(chart, anchored, random);
  const WindowRows rows(window, 4, 1);
  window.prior.keyframes = numbers_of(window).keyframes;
  const VectorXd s = scale_direction(window, rows, numbers_of(window));
  set_prior(window, blind_along(s, random));
  return window;
}

WindowSystem system_of(const Window& window) {
  const WindowSystem system = prior_system(window);
  return {.S = system.S.selfadjointView<Eigen::Lower>(), .g = system.g};
}

// Changes everything, and scales it by the exponential of `log`.
void move(double size, double log, test::Random& random, Window& window) {
  const ScaledNumbers grown = scaled(window, log);
  const ChartManifold manifold(*window.chart, true);
  for (std::size_t k = 0; k < window.keyframes.size(); ++k) {
    const VectorXd xi = size * random.normal_vector(kMotionErrors);
    manifold.Plus(grown.keyframes[k].motion.data(), xi.data(), window.keyframes[k].motion.data());
  }
  for (auto& [number, point] : window.points) {
    point.parameters = grown.points.at(number) + 0.1 * size * random.normal_vector(3);
  }
  window.stale = true;
}

// A prior with full information, but none on errors without rows.
Window informed_window(const ErrorChart& chart, bool anchored, test::Random& random) {
  Window window = window_of(chart, anchored, random);
  const int n = WindowRows(window, window.count(), 1).size;
  const MatrixXd A = MatrixXd::NullaryExpr(2 * n, n, [&] { return random.normal(); });
  set_prior(window, {.S = A.transpose() * A, .g = random.normal_vector(n)});
  return window;
}

class WindowPriorOver : public test::OverCharts {};

TEST_P(WindowPriorOver, IsAsItWasSetAtTheNumbersOfThen) {
  test::Random random(1);
  for (const bool anchored : {false, true}) {
    const Window window = informed_window(chart(), anchored, random);
    const WindowSystem system = prior_system(window);
    EXPECT_EQ(system.S, window.prior.information);
    EXPECT_TRUE(test::agree(system.g, window.prior.gradient, 1e-12));
    EXPECT_NEAR(prior_cost(window), 0, 1e-12);
  }
}

TEST_P(WindowPriorOver, TurnsAsTheChartDoes) {
  test::Random random(2);
  for (const bool anchored : {false, true}) {
    Window window = informed_window(chart(), anchored, random);
    window.prior.scale_weights = {};
    const WindowSystem prior{.S = window.prior.information.selfadjointView<Eigen::Lower>(),
                             .g = window.prior.gradient};
    const WindowRows rows = prior_rows(window);
    const std::deque<WindowKeyframe> at = window.keyframes;
    move(0.1, 0, random, window);
    MatrixXd G = MatrixXd::Identity(rows.size, rows.size);
    for (int k = 0; k < window.count(); ++k) {
      const auto n = std::min(rows.errors_of(k), kMotionErrors);
      const auto block = [&](const WindowKeyframe& keyframe) -> MatrixXd {
        return chart_block(window, keyframe).topLeftCorner(n, n);
      };
      G.block(rows.keyframe(k), rows.keyframe(k), n, n) =
          block(at[static_cast<std::size_t>(k)]).inverse() * block(window.keyframe(k));
    }
    const WindowSystem system = prior_system(window);
    const MatrixXd S = system.S.selfadjointView<Eigen::Lower>();
    EXPECT_TRUE(test::agree(S, G.transpose() * prior.S * G, 1e-10));
    // the gradient determines y and so the cost.
    const VectorXd y = prior.S.inverse() * (G.transpose().inverse() * system.g - prior.g);
    EXPECT_NEAR(prior_cost(window), y.dot(prior.S * y) / 2 + prior.g.dot(y),
                1e-8 * y.dot(prior.S * y));
  }
}

INSTANTIATE_TEST_SUITE_P(Charts, WindowPriorOver, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

class WindowScale : public test::OverCharts {};

// Up to the effect of the body axes on its position, which the chart rotates to first order.
TEST_P(WindowScale, ThatThePriorWasBlindToItStaysBlindTo) {
  test::Random random(3);
  for (const bool anchored : {false, true}) {
    for (const double log : {0.0, 0.02, -0.2}) {
      Window window = blind_window(chart(), anchored, random);
      move(0.02, log, random, window);
      const WindowSystem system = system_of(window);
      const VectorXd s = scale_direction(window, prior_rows(window), numbers_of(window));
      const double all = s.dot(system.S.diagonal().asDiagonal() * s);
      EXPECT_LT(s.dot(system.S * s), 1e-9 * all) << anchored << log;
      EXPECT_LT(std::abs(s.dot(system.g)), 1e-9 * s.norm() * system.g.norm()) << anchored << log;
    }
  }
}

TEST_P(WindowScale, OfItselfCostsNothing) {
  test::Random random(4);
  for (const bool anchored : {false, true}) {
    Window window = blind_window(chart(), anchored, random);
    move(0, 0.3, random, window);
    EXPECT_NEAR(scale_of(window, prior_rows(window)).log, 0.3, 0.02);
    EXPECT_LT(std::abs(prior_cost(window)), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Charts, WindowScale, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

// In the chart whose coordinates are differences; in others the derivative is exact to first order.
TEST(WindowScaleGradient, IsThatOfTheCost) {
  test::Random random(5);
  for (const bool anchored : {false, true}) {
    Window window = blind_window(kStandardChart, anchored, random);
    move(0.01, 0.05, random, window);
    const WindowSystem system = system_of(window);
    const WindowRows rows = prior_rows(window);
    const double h = 1e-6;
    const auto check = [&](int row, double* number) {
      const double before = *number;
      *number = before + h;
      const double above = prior_cost(window);
      *number = before - h;
      const double below = prior_cost(window);
      *number = before;
      EXPECT_NEAR((above - below) / (2 * h), system.g[row], 1e-5 * system.g.norm()) << row;
    };
    for (int k = 0; k < 4; ++k) {
      double* motion = window.keyframe(k).motion.data();
      const int count = rows.errors_of(k) > kPoseErrors ? 6 : 3;  // velocities of the oldest only
      for (int i = 0; i < count; ++i) check(rows.keyframe(k) + 3 + i, motion + 9 + i);
    }
    for (auto& [number, point] : window.points) {
      for (int i = 0; i < 3; ++i) check(rows.points.at(number) + i, &point.parameters[i]);
    }
  }
}

}  // namespace
}  // namespace chasles::smooth_detail
