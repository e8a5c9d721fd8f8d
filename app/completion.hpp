#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace chasles::app {

/// What a shell offers for the value of an option or for a positional argument.
enum class Offer {
  kNothing,   ///< a number or another text
  kPath,      ///< files and folders
  kChoice,    ///< `choices`
  kChoices,   ///< several of `choices`, with commas between them
  kSettings,  ///< KEY=VALUE of `settings`
};

/// A setting as the help lists it.
struct OfferedSetting {
  std::string key;
  std::string meaning;
  std::vector<std::string> values;  ///< empty for a number or another text
};

/// An option or a positional argument.
struct OfferedOption {
  std::vector<std::string> names;  ///< "-o", "--output"; that of a positional without dashes
  std::string meaning;
  std::string type;          ///< as the help shows it; empty for a flag
  bool takes_value = false;  ///< false: a flag
  bool needs_value = false;  ///< false for `--live [PORT]`
  bool may_be_repeated = false;
  Offer offer = Offer::kNothing;
  std::vector<std::string> choices;  ///< one that ends with ':' goes on, as "window:"
  std::vector<OfferedSetting> settings;
};

/// A command with its subcommands.
struct OfferedCommand {
  std::string name;  ///< "chasles", "map"
  std::string meaning;
  std::vector<OfferedOption> options;
  std::vector<OfferedOption> positionals;
  std::vector<OfferedCommand> commands;
};

/// What the parser accepts, read from its options and from the texts of its help, so that nothing
/// is declared twice: names of choices from types like `mono|stereo`, settings and scenes from the
/// footers. Commands without a group are hidden, here too. Throws std::logic_error for a type of
/// value that completion.cpp does not know.
OfferedCommand offered(const CLI::App& parser);

/// The programs that complete the command's arguments in bash (4 or later) and in zsh. They need
/// neither another file nor the command at run time.
std::string bash_completion(const OfferedCommand& program);
std::string zsh_completion(const OfferedCommand& program);

}  // namespace chasles::app
