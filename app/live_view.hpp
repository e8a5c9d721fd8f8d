#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/foxglove/service.hpp>
#include <chasles/live/live_run.hpp>
#include <chasles/live/server.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/session/run_recorder.hpp>

#include "live_frames.hpp"

namespace CLI {
class App;
}

namespace chasles::app {

/// What serves the run in progress.
struct LiveOptions {
  bool wanted = false;     ///< the page
  std::uint16_t port = 0;  ///< 0: any free port
  std::string address = "127.0.0.1";
  std::optional<std::uint16_t> foxglove =
      {};  ///< port of the server for Foxglove, 0: any free port
};

/// Declares --live, --live-address and --foxglove.
void declare_live(CLI::App& parser, LiveOptions& options);

/// Parses a port of the command line; 0 for an empty text. Throws UsageError that names the option.
std::uint16_t port_of(const std::string& option, const std::string& text);

/// Shows a run in progress: to viewers if --live or --foxglove was given, and in the run folder if
/// there is one.
class LiveView : public RunObserver {
 public:
  /// Starts the servers and prints their URLs to stderr. `stop` is called where a viewer asks the
  /// run to stop. `output` is the run folder; empty: none. Throws UsageError if the options do not
  /// fit.
  LiveView(const LiveOptions& options, std::function<void()> stop,
           const std::filesystem::path& output);
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;
  ~LiveView() override;  ///< sends viewers the rest, for some seconds

  /// Before the first frame. `known`: the part of the summary that is known then. Recorder and
  /// recording must outlive the run.
  void begin(const RunRecorder& recorder, const nlohmann::ordered_json& known,
             const Recording& recording);
  void on_images(const ImageFrame& images) override;
  void on_frame(const FeatureFrame& frame) override;
  void on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) override;
  void on_progress(std::size_t frames, Time now) override;
  void on_smoothing() override;
  /// Announces the complete run, after the run folder was written. `summary` includes the timing.
  void finish(const Run& run, std::string summary, bool interrupted);
  void fail(const std::string& why);

 private:
  void serve_page(const LiveOptions& options, std::function<void()> stop);
  void serve_foxglove(std::uint16_t port);

  const RunRecorder* recorder_ = nullptr;  ///< from begin() to the end of the run
  std::unique_ptr<LiveRun> run_;
  std::unique_ptr<FoxgloveService> foxglove_;
  std::optional<LiveFrames> frames_;  ///< that viewers can see; none where nobody can
  std::unique_ptr<LiveServer> server_, foxglove_server_;
  std::unique_ptr<GrowingRun> growing_;
  std::size_t shown_ = 0;  ///< number of states published
};

}  // namespace chasles::app
