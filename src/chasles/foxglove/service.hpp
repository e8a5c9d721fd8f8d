#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <chasles/foxglove/foxglove_channels.hpp>
#include <chasles/live/pace.hpp>
#include <chasles/live/server.hpp>
#include <chasles/live/service.hpp>

namespace chasles {

/// The port that Foxglove proposes.
inline constexpr std::uint16_t kFoxglovePort = 8765;

/// Serves a run in progress in Foxglove's WebSocket protocol (docs/viewers.md). As LiveRun: the
/// run's thread reports its progress, copies a state under a short lock, never waits, and is not
/// changed by clients. They can only look on.
class FoxgloveService final : public LiveService {
 public:
  /// `server`: name and version of the program.
  explicit FoxgloveService(std::string server);

  // Called on the run's thread.

  void begin(FoxgloveStart start);
  void add(const RunState& state);
  /// Stores the map that `make` returns: only if there are clients, and at the pace of LiveRun.
  void map(const std::function<LiveMap()>& make);
  void finish(const Run& run, std::string summary, bool interrupted);
  void fail(const std::string& why);

  // Called on any of the run's threads.

  /// Whether a client has subscribed to a camera.
  bool shows_frames() const { return shows_frames_; }
  /// Whether it is time for another frame. True once; the caller then gives frame().
  bool claim_frame() { return wants_frame_ && wants_frame_.exchange(false); }
  void frame(FoxgloveFrame frame);

  // Called on the server's thread.

  HttpAnswer answer(const Gate& gate, const Request& request) const override;
  std::unique_ptr<LiveSession> open() override;
  void refresh(std::size_t viewers) override;

 private:
  struct End {
    Run run;
    std::string summary;
    bool interrupted = false;
  };
  /// What the run's thread has reported since the last refresh.
  struct Inbox {
    std::optional<FoxgloveStart> start;
    std::vector<RunState> states;
    std::optional<LiveMap> map;
    std::optional<FoxgloveFrame> frame;
    std::optional<End> end;
    std::optional<std::string> failure;
  };

  void take(Inbox news);
  void take_end(End end);
  void ask_for_frame();

  const std::string server_, id_;
  Pace maps_ = map_pace();

  std::atomic<bool> watched_ = false, shows_frames_ = false, wants_frame_ = false;
  std::mutex mutex_;  ///< guards the inbox
  Inbox inbox_;

  // Used by the server's thread only.
  FoxgloveChannels channels_;
  Pace::Clock::time_point next_frame_{};
};

/// The limits of its server: on loopback, for large lists of subscriptions.
LiveServerOptions foxglove_server_options(std::uint16_t port);

/// ws://127.0.0.1:PORT
std::string foxglove_url(const Gate& gate);

}  // namespace chasles
