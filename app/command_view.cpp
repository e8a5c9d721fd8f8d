#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/error.hpp>
#include <chasles/report/study.hpp>

#include "interrupt.hpp"
#include "live_view.hpp"
#include "run_folder.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{50};

struct ViewOptions {
  std::vector<std::filesystem::path> folders;
  std::string port;
  std::string address = "127.0.0.1";
};

std::vector<ReportRun> read_runs(const std::vector<std::filesystem::path>& folders) {
  std::vector<ReportRun> runs;
  for (const std::filesystem::path& folder : folders) {
    if (is_study(folder)) {
      throw UsageError(
          fmt::format("{} is a study: its page is written by `chasles report`", folder.string()));
    }
    runs.push_back(read_with_timing(folder));
  }
  return runs;
}

// Until it is interrupted, which is how it ends.
int view(const ViewOptions& o) {
  const std::uint16_t port = port_of("--port", o.port);
  FinishedRuns feed(read_runs(o.folders));
  const Interrupt interrupt;
  const LiveServer server({.address = o.address, .port = port}, live_page(), feed);
  for (const std::string& url : urls(server.gate())) fmt::print("{}\n", url);
  std::fflush(stdout);
  while (!interrupt.requested()) std::this_thread::sleep_for(kBetweenLooks);
  return 0;
}

}  // namespace

Action declare_view(CLI::App& parser) {
  const auto o = std::make_shared<ViewOptions>();
  parser.add_option("RUN", o->folders, "Run folders, as `chasles run -o` writes them")
      ->required()
      ->type_name("");
  parser.add_option("--port", o->port, "Port to listen on (default: one that is free)")
      ->type_name("PORT");
  parser
      .add_option("--address", o->address,
                  "Numeric address to listen on (default: this machine alone); other than loopback "
                  "the printed URL has a token that viewers need")
      ->type_name("ADDRESS");
  return [o] { return view(*o); };
}

}  // namespace chasles::app
