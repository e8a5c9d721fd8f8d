#include <vector>

#include <chasles/base/validate.hpp>
#include <chasles/filter/charts/error_chart_names.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>

namespace chasles {

std::span<const std::string_view> batch_chart_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all{"filter"};
    for (const std::string_view chart : error_chart_names()) all.push_back(chart);
    return all;
  }();
  return names;
}

void validate(const BatchSettings& settings) { validate_fields(settings, "batch."); }

}  // namespace chasles
