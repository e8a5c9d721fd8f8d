#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>

#include "completion.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {

// Hidden: packages run it, and users who have no package (docs/packages.md).
Action declare_completion(CLI::App& parser) {
  const auto shell = std::make_shared<std::string>();
  parser.group("");
  parser.add_option("SHELL", *shell, "bash or zsh")->required()->type_name("");
  parser.footer(
      "bash: source <(chasles completion bash)\n"
      "zsh: chasles completion zsh > FOLDER_OF_FPATH/_chasles");
  return [&parser, shell] {
    if (*shell != "bash" && *shell != "zsh") {
      throw UsageError(fmt::format("chasles completion: found '{}', expected bash or zsh", *shell));
    }
    const OfferedCommand program = offered(*parser.get_parent());
    app::print("{}", *shell == "bash" ? bash_completion(program) : zsh_completion(program));
    return 0;
  };
}

}  // namespace chasles::app
