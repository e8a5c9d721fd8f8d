#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/growing_run.hpp>
#include <chasles/live/live_run.hpp>
#include <chasles/live/server.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

class Interrupt;

/// Where a live server listens.
struct LiveOptions {
  bool wanted = false;
  std::uint16_t port = 0;  ///< 0: one that is free
  std::string address = "127.0.0.1";
};

/// --live and --live-address.
void declare_live(CLI::App& parser, LiveOptions& options);

/// A port as it stands on the command line; empty: 0. Throws UsageError that names the option.
std::uint16_t port_of(const std::string& option, const std::string& text);

/// A run as it is seen from outside while it goes: by viewers, where that was asked for, and in the
/// folder that it is written to, where there is one.
class LiveView {
 public:
  /// Serves from now on, and prints the URL to stderr. A viewer's wish to stop is an interrupt.
  /// `output`: the run folder; empty: none.
  LiveView(const LiveOptions& options, const Interrupt& interrupt,
           const std::filesystem::path& output);
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;
  ~LiveView();  ///< viewers get what they lack, for some seconds

  /// `known`: what is known of the summary.
  void begin(const Run& header, const nlohmann::ordered_json& known, std::size_t frames);
  /// Those states are new; so many frames are done, which cover that many seconds.
  void advance(const Run& run, std::size_t frames, double recorded_seconds,
               const std::function<std::vector<RunLandmark>()>& map);
  void smoothing();
  /// The run folder is written. `summary`: with the timing.
  void finish(const Run& run, std::string summary, bool interrupted);
  void fail(const std::string& why);

 private:
  std::unique_ptr<LiveRun> run_;
  std::unique_ptr<LiveServer> server_;
  std::unique_ptr<GrowingRun> growing_;
  std::size_t told_ = 0;  ///< states
};

}  // namespace chasles::app
