#include <limits>
#include <string>

#include <chasles/base/error.hpp>
#include <chasles/filter/charts/chart_detail.hpp>
#include <chasles/filter/charts/registered_charts.hpp>
#include <chasles/filter/testing.hpp>

namespace chasles {
namespace {

// The functions of a chart of the library as a program's own.
CustomChart copy_of(const ErrorChart& chart, std::string name) {
  CustomChart made{.name = std::move(name),
                   .summary = "a copy",
                   .retract = [&chart](State& x, const ErrorRef& xi) { chart.retract(x, xi); },
                   .local = [&chart](const State& x, const State& y) { return chart.local(x, y); },
                   .motion_block = [&chart](const State& x) { return chart.motion_block(x); }};
  if (chart.landmark_block) {
    made.landmark_block = [&chart](const Eigen::Vector3d& p) { return chart.landmark_block(p); };
  }
  return made;
}

std::string message_of(CustomChart chart) {
  try {
    register_error_chart(std::move(chart));
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(RegisteredCharts, ThoseOfTheLibraryHoldTheInvariants) {
  for (const ErrorChart& chart : error_charts()) EXPECT_NO_THROW(check_error_chart(chart));
}

TEST(RegisteredCharts, AreFoundByTheirNameAndReplacedByLaterOnes) {
  const std::size_t before = error_chart_names().size();
  const ErrorChart& first = register_error_chart(copy_of(kStandardChart, "mine"));
  EXPECT_EQ(&error_chart("mine"), &first);
  EXPECT_FALSE(first.landmark_block);
  const auto names = error_chart_names();
  const ErrorChart& second = register_error_chart(copy_of(kRightSen3Chart, "mine"));
  EXPECT_EQ(&error_chart("mine"), &second);
  EXPECT_TRUE(second.landmark_block);
  EXPECT_EQ(error_chart_names().size(), before + 1);
  EXPECT_EQ(names.back(), "mine");  // stays valid
  EXPECT_EQ(first.name, "mine");
}

TEST(RegisteredCharts, AWrongChartIsRejectedWithTheFactThatDoesNotHold) {
  CustomChart moves = copy_of(kStandardChart, "moves");
  moves.retract = [](State& x, const ErrorRef& xi) {
    kStandardChart.retract(x, xi);
    x.world_T_imu.p.x() += 1e-6;
  };
  EXPECT_NE(message_of(moves).find("expected retract(x, 0) = x, but they differ by 1e-06"),
            std::string::npos)
      << message_of(moves);
  CustomChart turned = copy_of(kStandardChart, "turned");
  turned.local = kRightSe3Chart.local;
  EXPECT_NE(message_of(turned).find("expected local(x, retract(x, xi)) = xi"), std::string::npos)
      << message_of(turned);
  CustomChart slope = copy_of(kRightSe3Chart, "slope");
  slope.motion_block = kStandardChart.motion_block;
  EXPECT_NE(message_of(slope).find("to be the derivative of local()"), std::string::npos)
      << message_of(slope);
  CustomChart nan = copy_of(kStandardChart, "nan");
  nan.motion_block = [](const State&) {
    return Eigen::Matrix<double, 9, 9>(
        Eigen::Matrix<double, 9, 9>::Constant(std::numeric_limits<double>::quiet_NaN()));
  };
  EXPECT_NE(message_of(nan).find("they differ by nan"), std::string::npos) << message_of(nan);
  CustomChart short_one = copy_of(kStandardChart, "short");
  short_one.local = [](const State&, const State&) { return Eigen::VectorXd(3); };
  EXPECT_NE(message_of(short_one).find("local() has 3 numbers"), std::string::npos);
}

TEST(RegisteredCharts, NamesAreChecked) {
  EXPECT_NE(message_of(copy_of(kStandardChart, "standard")).find("is one of the library"),
            std::string::npos);
  EXPECT_NE(message_of(copy_of(kStandardChart, "a b")).find("expected letters"), std::string::npos);
  EXPECT_NE(message_of(copy_of(kStandardChart, "")).find("expected letters"), std::string::npos);
  EXPECT_NE(
      message_of({.name = "empty", .summary = {}, .retract = {}, .local = {}, .motion_block = {}})
          .find("expected the functions"),
      std::string::npos);
}

}  // namespace
}  // namespace chasles
