#pragma once

#include <optional>
#include <string_view>

#include <chasles/live/feed.hpp>

namespace chasles {

/// A message from a viewer: {"join": {…}} with the viewer's cursor, or {"stop": true}.
struct ViewerMessage {
  std::optional<LiveCursor> join;
  bool stop = false;
};

/// Nothing if the text is neither. All members of "join" are optional: run (a string of at most 64
/// bytes), rows and landmarks (integers from 0), truth and all (booleans).
std::optional<ViewerMessage> parse_viewer_message(std::string_view text);

}  // namespace chasles
