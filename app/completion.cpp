#include "completion.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace chasles::app {
namespace {

// Types of values: those of paths, and those for which a shell has nothing to offer.
constexpr std::string_view kPaths[] = {"DIR",  "ESTIMATE",  "FILE", "FILE.html", "FOLDER",   "MAP",
                                       "MAPS", "RECORDING", "RUN",  "TRUTH",     "RUN|STUDY"};
constexpr std::string_view kTypes[] = {"ADDRESS", "DEG",  "I/N",  "K",      "M",    "N",     "PART",
                                       "PERCENT", "PORT", "S",    "W",      "X",    "SHARE", "MB",
                                       "REASON",  "AXES", "DICT", "MODELS", "m/s^2"};

bool is_in(std::string_view word, const auto& words) {
  return std::ranges::find(words, word) != std::ranges::end(words);
}

std::vector<std::string> parts(std::string_view text, char delimiter) {
  std::vector<std::string> found;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(delimiter), text.size());
    if (end > 0) found.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return found;
}

// The parts of a footer: which option a setting is for, and the names of the scenes.
struct Footer {
  std::vector<std::pair<std::string, OfferedSetting>> settings;  // by the option
  std::vector<std::string> scenes;

  std::vector<OfferedSetting> of(std::string_view option) const {
    std::vector<OfferedSetting> found;
    for (const auto& [of, setting] : settings) {
      const bool again = std::ranges::find(found, setting.key, &OfferedSetting::key) != found.end();
      if (of == option && !again) found.push_back(setting);
    }
    return found;
  }
};

// "key = value        choices": help_text() in settings_io.cpp writes it.
OfferedSetting setting_of(std::string_view line) {
  const std::size_t equals = line.find(" = ");
  const std::vector<std::string> words = parts(line.substr(equals + 3), ' ');
  OfferedSetting setting{.key = std::string(line.substr(0, equals)), .meaning = {}, .values = {}};
  const std::string value = words.empty() ? "" : words.front();
  if (words.size() == 2 && words[1].find('|') != std::string::npos) {
    setting.values = parts(words[1], '|');
  } else if (value == "true" || value == "false") {
    setting.values = {"true", "false"};
  } else if (value == "auto") {
    setting.values = {value};
  }
  return setting;
}

// A heading "Settings …, for --set and …:" names the option of the settings below it; one without
// an option belongs to that of the heading before.
Footer footer_of(const std::string& text) {
  Footer footer;
  std::string option, line;
  bool scenes = false;
  std::istringstream lines(text);
  while (std::getline(lines, line)) {
    if (line.starts_with("      ")) {
      if (!footer.settings.empty() && !scenes)
        footer.settings.back().second.meaning = line.substr(6);
    } else if (line.starts_with("  ") && scenes) {
      footer.scenes.push_back(line.substr(2, line.find(' ', 2) - 2));
    } else if (line.starts_with("  ") && line.find(" = ") != std::string::npos) {
      footer.settings.emplace_back(option, setting_of(std::string_view(line).substr(2)));
    } else if (!line.empty()) {
      scenes = line.starts_with("Scenes");
      const std::size_t dashes = line.find("--");
      if (dashes != std::string::npos)
        option = line.substr(dashes, line.find(' ', dashes) - dashes);
    }
  }
  return footer;
}

// Choices that a type names: "filter|batch|window:N"; N stands for a number, and what is in capital
// letters for any value: "S|auto".
std::vector<std::string> choices_of_type(std::string_view type) {
  if (type.find('|') == std::string_view::npos || is_in(type, kPaths)) return {};
  std::vector<std::string> names = parts(type, '|');
  std::erase_if(names, [](const std::string& name) { return name.front() < 'a'; });
  for (std::string& name : names) {
    if (name.ends_with(":N")) name.pop_back();
  }
  return names;
}

// An option for a name has the choices of the setting of the same name: --chart and --charts those
// of `chart`.
std::vector<std::string> choices_of_setting(std::string name, const Footer& footer) {
  name.erase(0, name.find_first_not_of('-'));
  for (const auto& [option, setting] : footer.settings) {
    if (setting.key == name || setting.key + "s" == name) return setting.values;
  }
  return {};
}

void offer_value(OfferedOption& option, bool several, const Footer& footer) {
  const std::string& name = option.names.back();
  option.choices = choices_of_type(option.type);
  if (option.type == "NAME") option.choices = choices_of_setting(name, footer);
  if (option.type == "SCENE") option.choices = footer.scenes;
  if (!option.choices.empty()) {
    option.offer = several ? Offer::kChoices : Offer::kChoice;
  } else if (option.type == "KEY=VALUE") {
    option.offer = Offer::kSettings;
    option.settings = footer.of(name);
  } else if (is_in(option.type, kPaths)) {
    option.offer = Offer::kPath;
  }
  const bool empty = option.offer == Offer::kSettings && option.settings.empty();
  if (empty || (option.offer == Offer::kNothing && !is_in(option.type, kTypes))) {
    throw std::logic_error(
        fmt::format("{}: found a value of type '{}', expected one that completion.cpp knows", name,
                    option.type));
  }
}

OfferedOption option_of(const CLI::Option& from, const Footer& footer) {
  OfferedOption option;
  for (const std::string& name : from.get_snames()) option.names.push_back("-" + name);
  for (const std::string& name : from.get_lnames()) option.names.push_back("--" + name);
  if (option.names.empty()) option.names.push_back(from.get_name());
  option.meaning = from.get_description();
  option.takes_value = from.get_items_expected_max() > 0;
  option.needs_value =
      from.get_positional() ? from.get_required() : from.get_items_expected_min() > 0;
  option.may_be_repeated = from.get_items_expected_max() > 1;
  if (!option.takes_value) return option;
  // Positionals have their type as their name.
  option.type = from.get_positional() ? from.get_name() : from.get_type_name();
  if (option.type.starts_with('[')) {
    option.type = option.type.substr(1, option.type.find(']') - 1);
  } else {
    // What a validator, a delimiter and a list add: "N:INT in [1 - 3]", "NAME,...", "DIR...".
    const bool names = option.type.find('|') != std::string::npos;
    option.type = option.type.substr(0, option.type.find_first_of(names ? " ," : " :,"));
    if (option.type.ends_with("...")) option.type.resize(option.type.size() - 3);
  }
  offer_value(option, from.get_delimiter() == ',', footer);
  return option;
}

}  // namespace

OfferedCommand offered(const CLI::App& parser) {
  OfferedCommand command;
  command.name = parser.get_name();
  command.meaning = parser.get_description();
  const Footer footer = footer_of(parser.get_footer());
  for (const CLI::Option* option : parser.get_options()) {
    (option->get_positional() ? command.positionals : command.options)
        .push_back(option_of(*option, footer));
  }
  const auto visible = [](const CLI::App* sub) { return !sub->get_group().empty(); };
  for (const CLI::App* sub : parser.get_subcommands(visible)) {
    command.commands.push_back(offered(*sub));
  }
  return command;
}

}  // namespace chasles::app
