#include <memory>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/registered_names.hpp>
#include <chasles/filter/charts/registered_charts.hpp>

namespace chasles {
namespace {

struct RegisteredChart {
  CustomChart made;
  ErrorChart chart;  ///< of the functions in `made`

  explicit RegisteredChart(CustomChart its)
      : made(std::move(its)),
        chart{.name = made.name,
              .summary = made.summary,
              .retract = ChartFunction(made.retract),
              .local = ChartFunction(made.local),
              .motion_block = ChartFunction(made.motion_block),
              .landmark_block = ChartFunction(made.landmark_block)} {}
  RegisteredChart(const RegisteredChart&) = delete;
};

using RegisteredCharts = RegisteredNames<std::unique_ptr<const RegisteredChart>>;

// Never destroyed: filters may outlive other objects of the program.
RegisteredCharts& registered_charts() {
  static auto* const all = [] {
    std::vector<std::string_view> names;
    for (const ErrorChart& chart : error_charts()) names.push_back(chart.name);
    return new RegisteredCharts("error chart", std::move(names));
  }();
  return *all;
}

}  // namespace

const ErrorChart& register_error_chart(CustomChart chart) {
  registered_charts().check(chart.name);
  if (!chart.retract || !chart.local || !chart.motion_block) {
    throw UsageError("error chart '" + chart.name +
                     "': expected the functions retract, local and motion_block");
  }
  auto made = std::make_unique<const RegisteredChart>(std::move(chart));
  check_error_chart(made->chart);
  std::string name = made->made.name;
  return registered_charts().add(std::move(name), std::move(made))->chart;
}

std::span<const std::string_view> error_chart_names() { return registered_charts().names(); }

const ErrorChart& error_chart(std::string_view name) {
  for (const ErrorChart& chart : error_charts()) {
    if (chart.name == name) return chart;
  }
  if (const auto* registered = registered_charts().find(name)) return (*registered)->chart;
  registered_charts().throw_unknown(name);
}

}  // namespace chasles
