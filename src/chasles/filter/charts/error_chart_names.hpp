#pragma once

#include <span>
#include <string_view>

namespace chasles {

/// The names of error_charts() (error_chart.hpp), in its order, and of those that the program has
/// registered (registered_charts.hpp). Stays valid when more are registered.
std::span<const std::string_view> error_chart_names();

}  // namespace chasles
