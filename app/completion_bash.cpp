#include <fmt/format.h>
#include <fmt/ranges.h>

#include "completion.hpp"

namespace chasles::app {
namespace {

// Bash splits words at = and :, so that the word under the cursor is taken from the line. What it
// has already as a word of its own is cut off the answers.
constexpr const char* kBashHead =
    R"bash(# Completion of chasles in bash, written by `chasles completion bash`.

_chasles_words() {
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$cur")
  [[ ${COMPREPLY[0]-} != *[:=] ]] || compopt -o nospace
}

_chasles_list() {
  local head=${cur%"${cur##*,}"}
  mapfile -t COMPREPLY < <(compgen -P "$head" -W "$1" -- "${cur##*,}")
  compopt -o nospace
}

_chasles_files() { compopt -o default; }

# Keys of settings, or the values of one: `names` lists them as "key= key=value key=value".
_chasles_settings() {
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$cur")
  if [[ $cur != *=* ]]; then
    local name keys=
    for name in "${COMPREPLY[@]}"; do keys+="${name%%=*}= "; done
    mapfile -t COMPREPLY < <(compgen -W "$keys" -- "$cur" | uniq)
    compopt -o nospace
  fi
}

_chasles() {
  local line=${COMP_LINE:0:COMP_POINT} cur= previous= command= word words at
  read -ra words <<< "$line"
  [[ $line == *[[:space:]] ]] && words+=('')
  at=$((${#words[@]} - 1))
  cur=${words[at]} COMPREPLY=()
  ((at < 2)) || previous=${words[at - 1]}
  for word in "${words[@]:1:at-1}"; do
    case "$command $word" in
)bash";

constexpr const char* kBashMiddle = R"bash(    esac
  done
  if [[ $cur == --*=* ]]; then
    previous=${cur%%=*} cur=${cur#*=}
  fi
  case "$command" in
)bash";

constexpr const char* kBashTail = R"bash(  esac
  local breaks=
  [[ $COMP_WORDBREAKS != *=* ]] || breaks+='='
  [[ $COMP_WORDBREAKS != *:* ]] || breaks+=':'
  if [[ $breaks && $cur == *["$breaks"]* ]]; then
    COMPREPLY=("${COMPREPLY[@]#"${cur%"${cur##*["$breaks"]}"}"}")
  fi
}

complete -F _chasles chasles
)bash";

std::string settings_words(const std::vector<OfferedSetting>& settings) {
  std::string words;
  for (const OfferedSetting& setting : settings) {
    words += fmt::format("\n          {}=", setting.key);
    for (const std::string& value : setting.values) {
      words += fmt::format(" {}={}", setting.key, value);
    }
  }
  return words;
}

std::string bash_offer(const OfferedOption& option) {
  switch (option.offer) {
    case Offer::kNothing:
      return ":";
    case Offer::kPath:
      return "_chasles_files";
    case Offer::kChoice:
      return fmt::format("_chasles_words '{}'", fmt::join(option.choices, " "));
    case Offer::kChoices:
      return fmt::format("_chasles_list '{}'", fmt::join(option.choices, " "));
    case Offer::kSettings:
      return fmt::format("_chasles_settings '{}'", settings_words(option.settings));
  }
  return ":";
}

// What is offered where no option waits for its value.
std::string other_words(const OfferedCommand& command) {
  std::vector<std::string> options, names;
  for (const OfferedOption& option : command.options) {
    options.insert(options.end(), option.names.begin(), option.names.end());
  }
  for (const OfferedCommand& sub : command.commands) names.push_back(sub.name);
  std::string text = fmt::format(
      "          if [[ $cur == -* ]]; then\n"
      "            _chasles_words '{}'\n",
      fmt::join(options, " "));
  if (!names.empty()) {
    text += fmt::format("          else\n            _chasles_words '{}'\n", fmt::join(names, " "));
  }
  text += "          fi\n";
  if (!command.positionals.empty()) {
    // The first decides: no command mixes scenes with files.
    text += fmt::format("          [[ $cur == -* || ${{COMPREPLY[0]-}} ]] || {}\n",
                        bash_offer(command.positionals.front()));
  }
  return text;
}

std::string bash_case(const std::string& path, const OfferedCommand& command) {
  std::string text = fmt::format("    '{}')\n      case \"$previous\" in\n", path);
  for (const OfferedOption& option : command.options) {
    if (!option.needs_value) continue;
    text += fmt::format("        {}) {} ;;\n", fmt::join(option.names, " | "), bash_offer(option));
  }
  text += fmt::format("        *)\n{}          ;;\n      esac\n      ;;\n", other_words(command));
  for (const OfferedCommand& sub : command.commands) {
    text += bash_case(fmt::format("{} {}", path, sub.name), sub);
  }
  return text;
}

std::string bash_paths(const std::string& path, const OfferedCommand& command) {
  std::string text;
  for (const OfferedCommand& sub : command.commands) {
    const std::string longer = fmt::format("{} {}", path, sub.name);
    text += fmt::format("      '{}') command='{}' ;;\n", longer, longer);
    text += bash_paths(longer, sub);
  }
  return text;
}

}  // namespace

std::string bash_completion(const OfferedCommand& program) {
  return kBashHead + bash_paths("", program) + kBashMiddle + bash_case("", program) + kBashTail;
}

}  // namespace chasles::app
