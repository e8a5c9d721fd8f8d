#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace chasles::app {

/// Adds an option whose value is a finite number in [low, high]. Parsing throws UsageError with the
/// option, the value found and the value expected.
CLI::Option* add_number(CLI::App& parser, const std::string& name, std::optional<double>& value,
                        const std::string& unit, const std::string& meaning,
                        double low = -std::numeric_limits<double>::infinity(),
                        double high = std::numeric_limits<double>::infinity());

/// For a path's CLI::Option::check(): an empty one is an error (-o "$UNSET").
std::string require_path(const std::string& path);

/// The long names of the options and the names of the subcommands, for suggestions.
std::vector<std::string> known_words(const CLI::App& parser);

}  // namespace chasles::app
