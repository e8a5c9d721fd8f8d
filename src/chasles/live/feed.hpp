#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace chasles {

/// The part of a feed that a viewer has received. A new viewer has received nothing.
struct LiveCursor {
  std::string run;              ///< identifier of the run
  std::size_t rows = 0;         ///< number of states
  std::uint64_t landmarks = 0;  ///< version of the landmarks; 0: none
  std::uint64_t progress = 0;   ///< version of the progress; 0: none
  bool truth = false;           ///< has the true trajectory
  bool prior_map = false;       ///< has the map in which the run found its place
  bool all = false;             ///< has the page of the finished run
};

/// Text that several viewers share.
using LiveText = std::shared_ptr<const std::string>;

/// The source of the live server's updates. All functions are called on the server's thread.
class LiveFeed {
 public:
  LiveFeed() = default;
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;
  virtual ~LiveFeed() = default;

  /// Called periodically, before next(); `viewers` is the number of viewers.
  virtual void refresh(std::size_t viewers) = 0;
  /// The next update for a viewer at `cursor`, which is moved forward; null if the viewer has
  /// everything. A slow viewer receives a larger update next time; nothing waits for it.
  virtual LiveText next(LiveCursor& cursor) = 0;
  /// A viewer requests the end of the run.
  virtual void stop() = 0;
};

}  // namespace chasles
