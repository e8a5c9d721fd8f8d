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

/// Address of the live server.
struct LiveOptions {
  bool wanted = false;
  std::uint16_t port = 0;  ///< 0: any free port
  std::string address = "127.0.0.1";
};

/// Declares --live and --live-address.
void declare_live(CLI::App& parser, LiveOptions& options);

/// Parses a port of the command line; 0 for an empty text. Throws UsageError that names the option.
std::uint16_t port_of(const std::string& option, const std::string& text);

/// Shows a run in progress: to viewers if --live was given, and in the run folder if there is one.
class LiveView {
 public:
  /// Starts the server and prints its URL to stderr. `stop` is called where a viewer asks the run
  /// to stop. `output` is the run folder; empty: none. Throws UsageError if the options do not fit.
  LiveView(const LiveOptions& options, std::function<void()> stop,
           const std::filesystem::path& output);
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;
  ~LiveView();  ///< sends viewers the rest, for some seconds

  /// `known` is the part of the summary that is known before the run.
  void begin(const Run& header, const nlohmann::ordered_json& known, std::size_t frames);
  /// Publishes the new states of `run`. `frames` frames are done, which cover `recorded_seconds`
  /// [s].
  void advance(const Run& run, std::size_t frames, double recorded_seconds,
               const std::function<LiveMap()>& map);
  void smoothing();
  /// Announces the complete run, after the run folder was written. `summary` includes the timing.
  void finish(const Run& run, std::string summary, bool interrupted);
  void fail(const std::string& why);

 private:
  std::unique_ptr<LiveRun> run_;
  std::unique_ptr<LiveServer> server_;
  std::unique_ptr<GrowingRun> growing_;
  std::size_t shown_ = 0;  ///< number of states published
};

}  // namespace chasles::app
