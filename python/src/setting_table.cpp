#include "setting_table.hpp"

#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace chasles::python {
namespace {

namespace py = pybind11;

// The type of a setting, as Python's annotations have it.
std::string type_of(const Setting& setting) {
  const auto text = [&](const auto& value) -> std::string {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, Setting::ChoiceRef>) {
      return fmt::format("Literal['{}']", fmt::join(setting.limits.names, "', '"));
    } else if constexpr (std::is_same_v<Value, std::optional<double>*>) {
      return "Union[float, Literal['auto'], None]";
    } else if constexpr (std::is_same_v<Value, double*>) {
      return "float";
    } else if constexpr (std::is_same_v<Value, bool*>) {
      return "bool";
    } else if constexpr (std::is_same_v<Value, std::string*>) {
      return "str";
    } else {
      return "int";
    }
  };
  return std::visit(text, setting.value);
}

}  // namespace

py::dict table_of(const SettingList& settings) {
  py::dict result;
  for (const Setting& one : settings) {
    py::dict entry;
    entry["default"] = value_text(one);
    entry["unit"] = one.unit;
    entry["meaning"] = one.meaning;
    entry["type"] = type_of(one);
    result[py::str(one.name)] = entry;
  }
  return result;
}

}  // namespace chasles::python
