#include <fmt/format.h>
#include <fmt/ranges.h>

#include "completion.hpp"

namespace chasles::app {
namespace {

constexpr const char* kZshHead = R"zsh(#compdef chasles
# Completion of chasles in zsh, written by `chasles completion zsh`.

# Names; one that ends with : goes on.
_chasles_names() {
  local name
  for name; do
    if [[ $name == *: ]]; then compadd -S '' -- $name; else compadd -- $name; fi
  done
}

# Keys of settings with their meanings, or the values of one.
_chasles_setting() {
  local -a keys
  local -A values
  "_chasles_settings_$1"
  if compset -P '*='; then
    local key=${${IPREFIX%=}##*=}
    [[ -n ${values[$key]} ]] && compadd -- ${=values[$key]}
  else
    _describe -t settings setting keys -S '=' -q
  fi
}
)zsh";

constexpr const char* kZshTail = R"zsh(
if [[ $funcstack[1] == _chasles ]]; then
  _chasles "$@"
else
  compdef _chasles chasles
fi
)zsh";

std::string escaped(std::string_view text, std::string_view special) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
      continue;
    }
    if (special.find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

// The first words of a meaning, for one line of a list.
std::string brief(const std::string& meaning) {
  constexpr std::size_t kMost = 72;
  if (meaning.size() <= kMost) return meaning;
  return meaning.substr(0, meaning.rfind(' ', kMost)) + " ...";
}

std::string function_name(const std::string& path, const OfferedOption& option) {
  std::string name = path + option.names.back();
  for (char& c : name) c = c == ' ' || c == '-' ? '_' : c;
  return name;
}

std::string zsh_offer(const std::string& path, const OfferedOption& option) {
  switch (option.offer) {
    case Offer::kNothing:
      return " ";
    case Offer::kPath:
      return "_files";
    // With a space in front no arguments are put between these.
    case Offer::kChoice:
      return fmt::format(" _chasles_names {}", fmt::join(option.choices, " "));
    case Offer::kChoices:
      return fmt::format("_sequence compadd - {}", fmt::join(option.choices, " "));
    case Offer::kSettings:
      return " _chasles_setting " + function_name(path, option);
  }
  return " ";
}

// ":message:action" of an option's value or of a positional; one that may be missing has a colon
// more.
std::string zsh_value(const std::string& path, const OfferedOption& option) {
  return fmt::format("{}:{}:{}", option.needs_value ? "" : ":", escaped(option.type, ":"),
                     escaped(zsh_offer(path, option), ":"));
}

std::string zsh_specs(const std::string& path, const OfferedCommand& command) {
  std::string text;
  for (const OfferedOption& option : command.options) {
    const std::string others =
        option.may_be_repeated ? "*" : fmt::format("({})", fmt::join(option.names, " "));
    for (const std::string& name : option.names) {
      const bool is_long = name.starts_with("--");
      text += fmt::format(
          " \\\n    '{}{}{}[{}]{}'", others, name, option.takes_value && is_long ? "=" : "",
          escaped(brief(option.meaning), "[]"), option.takes_value ? zsh_value(path, option) : "");
    }
  }
  if (!command.commands.empty()) return text;  // zsh_functions() has both
  for (const OfferedOption& positional : command.positionals) {
    text += fmt::format(" \\\n    '{}{}'", positional.may_be_repeated ? "*" : "",
                        zsh_value(path, positional));
  }
  return text;
}

std::string zsh_settings(const std::string& path, const OfferedCommand& command) {
  std::string text;
  for (const OfferedOption& option : command.options) {
    if (option.offer != Offer::kSettings) continue;
    text += fmt::format("\n_chasles_settings_{}() {{\n  keys=(\n", function_name(path, option));
    for (const OfferedSetting& setting : option.settings) {
      text += fmt::format("    '{}:{}'\n", setting.key, escaped(brief(setting.meaning), ":"));
    }
    text += "  )\n  values=(\n";
    for (const OfferedSetting& setting : option.settings) {
      if (setting.values.empty()) continue;
      text += fmt::format("    '{}' '{}'\n", setting.key, fmt::join(setting.values, " "));
    }
    text += "  )\n}\n";
  }
  return text;
}

// A function for the command, after those of its subcommands and settings.
std::string zsh_functions(const std::string& path, const OfferedCommand& command) {
  std::string functions = zsh_settings(path, command), list, cases;
  for (const OfferedCommand& sub : command.commands) {
    const std::string longer = fmt::format("{}_{}", path, sub.name);
    functions += zsh_functions(longer, sub);
    list += fmt::format("    '{}:{}'\n", sub.name, escaped(brief(sub.meaning), ":"));
    cases += fmt::format("      {}) _chasles{} ;;\n", sub.name, longer);
  }
  const std::string specs = zsh_specs(path, command);
  const char* files = command.positionals.empty() ? "" : "\n      _files && ret=0";
  if (list.empty()) {
    return functions + fmt::format("\n_chasles{}() {{\n  _arguments -s{}\n}}\n", path, specs);
  }
  return functions + fmt::format(R"zsh(
_chasles{}() {{
  local curcontext=$curcontext state ret=1
  local -a commands
  commands=(
{}  )
  _arguments -C -s{} \
    '1: :->command' '*:: :->arguments' && ret=0
  case $state in
    command)
      _describe -t commands command commands && ret=0{}
      ;;
    arguments)
      case $words[1] in
{}      esac
      ret=$?
      ;;
  esac
  return ret
}}
)zsh",
                                 path, list, specs, files, cases);
}

}  // namespace

std::string zsh_completion(const OfferedCommand& program) {
  return kZshHead + zsh_functions("", program) + kZshTail;
}

}  // namespace chasles::app
