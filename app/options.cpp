#include "options.hpp"

#include <cmath>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>

namespace chasles::app {
namespace {

double number_of(const std::string& name, const std::string& text) {
  try {
    return parse_finite(name, text);
  } catch (const InputError& error) {
    throw UsageError(error.what());
  }
}

std::string range(double low, double high) {
  if (std::isfinite(low) && std::isfinite(high)) return fmt::format("from {} to {}", low, high);
  return std::isfinite(low) ? fmt::format("not below {}", low) : fmt::format("up to {}", high);
}

}  // namespace

CLI::Option* add_number(CLI::App& parser, const std::string& name, std::optional<double>& value,
                        const std::string& unit, const std::string& meaning, double low,
                        double high) {
  const auto read = [name, &value, low, high](const std::string& text) {
    const double number = number_of(name, text);
    if (number < low || number > high) {
      throw UsageError(
          fmt::format("{}: found {}, expected a number {}", name, text, range(low, high)));
    }
    value = number;
  };
  return parser.add_option_function<std::string>(name, read, meaning)->type_name(unit);
}

std::string require_path(const std::string& path) {
  return path.empty() ? "is empty, expected a path" : "";
}

std::vector<std::string> known_words(const CLI::App& parser) {
  std::vector<std::string> words;
  for (const CLI::Option* option : parser.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
  }
  for (const CLI::App* command : parser.get_subcommands([](const CLI::App*) { return true; })) {
    words.push_back(command->get_name());
  }
  return words;
}

}  // namespace chasles::app
