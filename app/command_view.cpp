#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/report/study.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/report_run.hpp>

#include "follow_run.hpp"
#include "live_view.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

constexpr std::chrono::milliseconds kBetweenPolls{50};

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
    if (is_growing(folder)) {
      throw UsageError(
          fmt::format("{}: a run is being written into it; view it alone, or wait until it ends",
                      folder.string()));
    }
    runs.push_back(read_with_timing(folder));
  }
  return runs;
}

// Serves until interrupted.
int serve(const ViewOptions& o, std::uint16_t port, LiveFeed& feed,
          const std::function<void()>& work) {
  const Interrupt interrupt;
  const LiveServer server({.address = o.address, .port = port}, live_page(), feed);
  for (const std::string& url : urls(server.gate())) app::print("{}\n", url);
  flush_stdout();
  while (!interrupt.requested()) {
    work();
    std::this_thread::sleep_for(kBetweenPolls);
  }
  return 0;
}

int view(const ViewOptions& o) {
  const std::uint16_t port = port_of("--port", o.port);  // before the slow reading
  if (o.folders.size() == 1 && is_growing(o.folders.front())) {
    LiveRun run({});
    FollowedRun followed(o.folders.front(), run);
    return serve(o, port, run, [&] { followed.poll(); });
  }
  FinishedRuns feed(read_runs(o.folders));
  return serve(o, port, feed, [] {});
}

}  // namespace

Action declare_view(CLI::App& parser) {
  const auto o = std::make_shared<ViewOptions>();
  parser
      .add_option("RUN", o->folders,
                  "Run folders, as `chasles run -o` writes them; a single folder may be of a run "
                  "in progress")
      ->required()
      ->type_name("");
  parser.add_option("--port", o->port, "Port to listen on (default: any free port)")
      ->type_name("PORT");
  parser
      .add_option(
          "--address", o->address,
          "Numeric address to listen on (default: only this machine). With an address other "
          "than loopback, viewers need the token of the printed URL")
      ->type_name("ADDRESS");
  return [o] { return view(*o); };
}

}  // namespace chasles::app
