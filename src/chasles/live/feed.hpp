#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace chasles {

/// How much of a feed a viewer has. A new viewer has nothing.
struct LiveCursor {
  std::string run;              ///< which run it is that it has something of
  std::size_t rows = 0;         ///< states
  std::uint64_t landmarks = 0;  ///< version of the landmarks; 0: none
  std::uint64_t progress = 0;   ///< version of the progress; 0: none
  bool truth = false;           ///< the true way
  bool all = false;             ///< the page of the finished run
};

/// Text that many viewers may be sent at once.
using LiveText = std::shared_ptr<const std::string>;

/// What the live server tells its viewers. All is called on the server's thread.
class LiveFeed {
 public:
  LiveFeed() = default;
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;
  virtual ~LiveFeed() = default;

  /// Now and then, before viewers are asked for: `viewers` are there.
  virtual void refresh(std::size_t viewers) = 0;
  /// What a viewer that has so much is told next, and has then; none: it has everything. Whoever is
  /// slow to take it is told more at once the next time, and nothing waits for it.
  virtual LiveText next(LiveCursor& cursor) = 0;
  /// A viewer wants the run to stop.
  virtual void stop() = 0;
};

}  // namespace chasles
