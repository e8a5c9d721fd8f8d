#include "messages.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/street.hpp>

#include "arrays.hpp"
#include "inertial_settings_io.hpp"
#include "scene_options.hpp"
#include "settings_io.hpp"
#include "velocity_settings_io.hpp"

namespace chasles::python {
namespace {

// What sentences of the command are in Python.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kSentences{{
    {"--help lists", "chasles.settings() lists"},
    {"`chasles check`", "chasles.check(recording)"},
    {"`chasles run --save-map`", "chasles.run(recording, save_map=FILE)"},
    {"chasles run --map MAP --extend", "`chasles run --map MAP --extend`"},
    {"give the recording; chasles report and chasles evaluate read runs",
     "chasles.read_run(folder) reads it; this function takes the recording"},
    {"holds a study: --resume continues it; expected",
     "holds a study: `chasles montecarlo --resume` continues it; expected"},
    {"gyroscope_random_walk into its calibration",
     "gyroscope_random_walk into its calibration, or give Recording.from_arrays "
     "imu_noise=chasles.ImuNoise(...)"},
    {"--set ", ""},
}};
// Other commands keep their options.
constexpr std::string_view kCommand = "`chasles ";

// After an option these are no value of it.
constexpr std::array kNoValue{"and", "are", "but",       "for",   "gives", "has",
                              "is",  "it",  "lists",     "means", "must",  "needs",
                              "of",  "or",  "overrides", "was",   "with",  "without"};

bool is_of_option(char c) { return std::islower(static_cast<unsigned char>(c)) != 0 || c == '-'; }
bool is_of_number(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

// Whether the text, from after an option on, has a value of it.
bool has_value(std::string_view rest) {
  if (rest.size() < 2 || rest[0] != ' ') return false;
  const bool negative =
      rest.size() > 2 && rest[1] == '-' && (is_of_number(rest[2]) || rest[2] == '.');
  if (negative) return true;
  if (!is_of_word(rest[1])) return false;
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
  for (const auto& [from, to] : kSentences) replace(text, from, to);
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    if (text.compare(i, kCommand.size(), kCommand) == 0) {  // a command stays as it is
      const std::size_t end = text.find('`', i + 1);
      const std::size_t length = end == std::string::npos ? end : end + 1 - i;
      result += text.substr(i, length);
      i = length == std::string::npos ? text.size() : i + length;
      continue;
    }
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

namespace {

template <typename Use>
void with_all_settings(const Use& use) {
  InertialRunSettings inertial;
  app::VelocityCommandSettings velocity;
  use(app::setting_list(inertial.filter));
  use(app::list_of(inertial.start, "start."));
  use(app::list_of(inertial.frontend, "frontend."));
  use(app::setting_list(inertial.batch));
  use(app::setting_list(velocity.filter));
  use(app::list_of(velocity.batch, "batch."));
  use(app::setting_list(velocity.reader));
}

}  // namespace

std::vector<std::string> setting_names() {
  std::vector<std::string> names;
  with_all_settings([&](const app::SettingList& list) {
    for (const app::Setting& one : list) names.push_back(one.name);
  });
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  return names;
}

namespace {

// Arguments of chasles.read, which cut and change what is read.
constexpr std::array kOfRead{"start",       "stop",        "backwards",     "cameras",
                             "truth",       "truth_level", "pairing",       "max_truth_gap",
                             "truth_frame", "truth_scale", "truth_inverse", "truth_time_offset"};

// A prefix of settings whose value is no dictionary, and arguments of chasles.read.
void check_kinds(const std::string& function, const py::dict& arguments,
                 const std::vector<std::string>& known, const std::vector<std::string>& own) {
  for (const auto& [key, value] : arguments) {
    const std::string name = py::str(key).cast<std::string>();
    const bool prefix = std::ranges::any_of(
        known, [&](const std::string& one) { return one.starts_with(name + "."); });
    const bool of_read = std::ranges::find(kOfRead, name) != kOfRead.end();
    const std::string hint =
        of_read ? fmt::format(
                      "; {} is also an argument of chasles.read: {}(chasles.read(path, "
                      "{}={}))",
                      name, function, name, description(value))
                : std::string();
    if (prefix && !py::isinstance<py::dict>(value)) {
      throw UsageError(fmt::format(
          "{}: {}: found {}, expected a dictionary of settings of this prefix, such as {{'{}': "
          "...}}{}",
          function, name, description(value),
          std::ranges::find_if(known,
                               [&](const std::string& one) { return one.starts_with(name + "."); })
              ->substr(name.size() + 1),
          hint));
    }
    if (of_read && !prefix && std::ranges::find(known, name) == known.end() &&
        std::ranges::find(own, name) == own.end()) {
      throw UsageError(fmt::format("{}: unknown argument '{}'{}", function, name, hint));
    }
  }
}

// None is the value `auto`, which most settings do not have.
void check_none(const std::string& function, const py::dict& arguments,
                const std::string& prefix = "") {
  for (const auto& [key, value] : arguments) {
    const std::string name = prefix + py::str(key).cast<std::string>();
    if (py::isinstance<py::dict>(value)) {
      check_none(function, value.cast<py::dict>(), name + ".");
    }
    if (!value.is_none()) continue;
    std::string usual;
    bool good = false;
    with_all_settings([&](const app::SettingList& list) {
      const auto found = std::ranges::find(list, name, &app::Setting::name);
      if (found == list.end()) return;
      usual = app::value_text(*found);
      good |= std::holds_alternative<std::optional<double>*>(found->value) ||
              std::ranges::find(found->limits.names, "auto") != found->limits.names.end();
    });
    if (good || usual.empty()) continue;
    throw UsageError(fmt::format("{}: {}: found None, expected a value; the default is {}",
                                 function, name, usual));
  }
}

}  // namespace

void check_keys(const std::string& function, const py::dict& arguments,
                const std::vector<std::string>& own) {
  std::vector<std::string> known = setting_names();
  known.insert(known.end(), own.begin(), own.end());
  check_kinds(function, arguments, known, own);
  check_none(function, arguments);
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
