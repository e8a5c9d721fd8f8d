#include "messages.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/street.hpp>

#include "arrays.hpp"
#include "inertial_settings_io.hpp"
#include "scene_options.hpp"
#include "settings_io.hpp"
#include "velocity_settings_io.hpp"

namespace chasles::python {
namespace {

// After an option these are no value of it.
constexpr std::array kNoValue{"and", "are", "but",       "for",   "gives", "has",
                              "is",  "it",  "lists",     "means", "must",  "needs",
                              "of",  "or",  "overrides", "was",   "with",  "without"};

bool is_of_option(char c) { return std::islower(static_cast<unsigned char>(c)) != 0 || c == '-'; }
bool is_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

// Whether the text, from after an option on, has a value of it.
bool has_value(std::string_view rest) {
  if (rest.size() < 2 || rest[0] != ' ' || !is_of_word(rest[1])) return false;
  std::size_t end = 1;
  while (end < rest.size() && is_of_word(rest[end])) ++end;
  return std::ranges::find(kNoValue, rest.substr(1, end - 1)) == kNoValue.end();
}

void replace(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

}  // namespace

std::string in_python(const std::string& message) {
  std::string text = message;
  replace(text, "--help lists", "chasles.settings() lists");
  replace(text, "`chasles check`", "chasles.check(recording)");
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const bool begins = i == 0 || !(is_of_word(text[i - 1]) || text[i - 1] == '-');
    const bool option = begins && i + 2 < text.size() && text.compare(i, 2, "--") == 0 &&
                        std::islower(static_cast<unsigned char>(text[i + 2])) != 0;
    if (!option) {
      result += text[i++];
      continue;
    }
    for (i += 2; i < text.size() && is_of_option(text[i]); ++i) {
      result += text[i] == '-' ? '_' : text[i];
    }
    if (!has_value(std::string_view(text).substr(i))) continue;
    result += '=';
    ++i;
  }
  return result;
}

std::vector<std::string> setting_names() {
  InertialRunSettings inertial;
  app::VelocityCommandSettings velocity;
  std::vector<std::string> names;
  const auto add = [&](const app::SettingList& list) {
    for (const app::Setting& one : list) names.push_back(one.name);
  };
  add(app::setting_list(inertial.filter));
  add(app::list_of(inertial.start, "start."));
  add(app::list_of(inertial.frontend, "frontend."));
  add(app::setting_list(inertial.batch));
  add(app::setting_list(velocity.filter));
  add(app::list_of(velocity.batch, "batch."));
  add(app::setting_list(velocity.reader));
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  return names;
}

void check_keys(const std::string& function, const py::dict& arguments,
                const std::vector<std::string>& own) {
  std::vector<std::string> known = setting_names();
  known.insert(known.end(), own.begin(), own.end());
  for (const std::string& assignment : assignments(arguments)) {
    const std::string name = assignment.substr(0, assignment.find('='));
    if (std::ranges::find(known, name) != known.end()) continue;
    throw UsageError(
        fmt::format("{}: unknown argument '{}'{}; expected {}, or a setting of chasles.settings()",
                    function, name, did_you_mean(name, known), fmt::join(own, ", ")));
  }
}

void check_scene_keys(const std::string& function, const std::string& scene,
                      const py::dict& settings) {
  app::check_scene(scene);
  const bool inertial = app::is_inertial_scene(scene);
  InertialSettings of_scene;
  StreetSettings of_street;
  std::vector<std::string> known;
  for (const app::Setting& one : inertial ? app::list_of(of_scene) : app::list_of(of_street)) {
    known.push_back(one.name);
  }
  for (const std::string& assignment : assignments(settings)) {
    const std::string name = assignment.substr(0, assignment.find('='));
    if (std::ranges::find(known, name) != known.end()) continue;
    throw UsageError(fmt::format(
        "{}: unknown setting '{}' of the scene {}{}; expected one of chasles.settings(\"{}\")",
        function, name, scene, did_you_mean(name, known), inertial ? "scene" : "street"));
  }
}

}  // namespace chasles::python
