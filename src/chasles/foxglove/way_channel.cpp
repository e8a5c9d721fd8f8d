#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/foxglove/way_channel.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/way_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

constexpr int kAll = 1;  // of foxglove.SceneEntityDeletion.Type

Json scene(Json entity) { return {{"entities", Json::array({std::move(entity)})}}; }

}  // namespace

WayChannel::WayChannel(const ProtoSchemas& schemas, const Run& run,
                       const GrowingComparison& comparison)
    : FoxgloveChannel(kWaysTopic, schemas), run_(run), comparison_(comparison) {}

// A cursor counts the beginning, then the states.

bool WayChannel::owes_truth(const ChannelCursor& cursor) const {
  return !cursor.truth && comparison_.started();
}

std::size_t WayChannel::end_of(std::size_t state) const {
  return std::min(shown_, (state / kPiece + 1) * kPiece);
}

std::optional<Time> WayChannel::due(const ChannelCursor& cursor) const {
  if (shown_ == 0) return std::nullopt;
  if (cursor.next == 0) return run_.states.front().time;
  const std::size_t states = cursor.next - 1;
  if (states < shown_) return run_.states[end_of(states) - 1].time;
  return owes_truth(cursor) ? std::optional(run_.states[shown_ - 1].time) : std::nullopt;
}

std::optional<std::string> WayChannel::take(ChannelCursor& cursor) {
  if (cursor.next == 0) {
    cursor.next = 1;
    return encoded(beginning());
  }
  const std::size_t states = cursor.next - 1;
  if (states < shown_) {
    cursor.next = end_of(states) + 1;
    return encoded(piece(states / kPiece * kPiece, end_of(states)));
  }
  cursor.truth = true;
  return encoded(scene(way("truth", comparison_.truth(), comparison_.world_T_truth(), kTruthColour,
                           run_.states[shown_ - 1].time)));
}

// It also removes the lines of an earlier run, or of an earlier estimate of this one.
Json WayChannel::beginning() const {
  const Time time = run_.states.front().time;
  Json entities = Json::array();
  if (!run_.dead_reckoning.empty()) {
    entities.push_back(way("dead reckoning", run_.dead_reckoning, {}, kDeadReckoningColour, time));
  }
  return {{"deletions", Json::array({{{"timestamp", proto_time(time)}, {"type", kAll}}})},
          {"entities", std::move(entities)}};
}

// Each piece begins with the last state of the one before.
Json WayChannel::piece(std::size_t from, std::size_t to) const {
  Trajectory poses;
  for (std::size_t i = from - (from > 0 ? 1 : 0); i < to; ++i) {
    const RunState& s = run_.states[i];
    if (s.world_T_imu.p.allFinite()) poses.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  return scene(way(fmt::format("estimate {}", from / kPiece), poses, {}, kEstimateColour,
                   run_.states[to - 1].time));
}

}  // namespace chasles
