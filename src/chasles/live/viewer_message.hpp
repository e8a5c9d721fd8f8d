#pragma once

#include <optional>
#include <string_view>

#include <chasles/live/feed.hpp>

namespace chasles {

/// What a viewer may say: {"join": {…}} with what it has, or {"stop": true}.
struct ViewerMessage {
  std::optional<LiveCursor> join;
  bool stop = false;
};

/// None where the text is neither. Of "join" everything may be left out: run (a string of 64 bytes
/// at most), rows and landmarks (whole numbers from 0), truth and all (yes or no).
std::optional<ViewerMessage> parse_viewer_message(std::string_view text);

}  // namespace chasles
