#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/image_frame.hpp>
#include <chasles/foxglove/protocol.hpp>
#include <chasles/foxglove/way_channel.hpp>
#include <chasles/live/live_run.hpp>

namespace chasles {

/// What is known of a run before its first estimate.
struct FoxgloveStart {
  Run header;             ///< no states and landmarks yet
  std::string summary;    ///< the available part of summary.json (an object)
  int cameras = 0;        ///< those whose points can be shown
  bool pictures = false;  ///< whether their images can be shown, too
};

/// A frame of a run: its points, and its pictures where the recording has them.
struct FoxgloveFrame {
  std::vector<ShownImage> images;   ///< one per camera, without jpeg
  std::vector<GrayImage> pictures;  ///< one per camera; empty: none
};

/// A run in progress as channels of messages, those of its MCAP file (docs/viewers.md). Used on the
/// server's thread only.
class FoxgloveChannels {
 public:
  FoxgloveChannels();
  ~FoxgloveChannels();

  /// Declares the channels.
  void begin(FoxgloveStart start);
  void add(const std::vector<RunState>& states);
  void map(LiveMap map);
  /// Shows the frame to those who have subscribed to its camera.
  void frame(FoxgloveFrame frame);
  /// The final run replaces what there was before.
  void finish(Run run, const std::string& summary);
  void notice(StatusLevel level, std::string text);
  /// Shows the path so far, now and then.
  void show();

  /// Channels are never removed.
  const std::vector<std::unique_ptr<FoxgloveChannel>>& channels() const { return channels_; }
  /// Changes when all states were replaced: cursors then begin anew.
  std::uint64_t epoch() const { return epoch_; }
  /// Status messages for every client, in their order.
  struct Notice {
    StatusLevel level;
    std::string text;
  };
  const std::vector<Notice>& notices() const { return notices_; }
  /// The time of the newest state; none before the first.
  std::optional<Time> now() const;
  /// Whether anyone has subscribed to a camera.
  bool shows_frames() const;
  const std::string& name() const { return run_.name; }

 private:
  struct Camera {
    LatestChannel *image = nullptr, *annotations = nullptr;
    bool is_shown() const;
  };
  using Clock = std::chrono::steady_clock;

  template <typename Kind, typename... Arguments>
  Kind* declare(Arguments&&... arguments);
  LatestChannel* latest(const ViewerTopic& topic);
  void declare_states();
  void declare_truth();
  void declare_cameras(int cameras, bool pictures);
  void show_map();
  void show_closures(const nlohmann::json& known);

  ProtoSchemas schemas_;
  Run run_;
  std::string summary_;
  GrowingComparison comparison_;
  std::vector<std::unique_ptr<FoxgloveChannel>> channels_;
  WayChannel* ways_ = nullptr;
  LatestChannel *tf_cameras_ = nullptr, *tf_map_ = nullptr;
  LatestChannel *map_ = nullptr, *ellipsoids_ = nullptr, *prior_map_ = nullptr;
  ListChannel* closures_ = nullptr;
  std::vector<Camera> cameras_;
  std::vector<Notice> notices_;
  std::uint64_t epoch_ = 0;
  Clock::time_point next_way_{};
  bool reported_early_times_ = false;
};

}  // namespace chasles
