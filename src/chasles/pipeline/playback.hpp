#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include <chasles/base/time.hpp>
#include <chasles/pipeline/sensor_event.hpp>

namespace chasles {

/// The clock of a playback; tests use their own. Called from several threads.
struct PlaybackClock {
  std::function<Time()> now;           ///< time since any instant; never decreases
  std::function<void(Time)> wait_for;  ///< approximately; may return sooner
};

/// The machine's steady clock.
PlaybackClock wall_clock();

struct PlaybackOptions {
  Time begin{};             ///< time of the recording that is played first
  double speed = 1;         ///< recorded seconds per second; above 0
  std::size_t waiting = 3;  ///< frames; one that arrives while so many wait is dropped
  /// Polled by a thread of the playback; true ends it.
  std::function<bool()> stop = [] { return false; };
  PlaybackClock clock = wall_clock();
};

/// Plays a recording as live sensors would deliver it: its events arrive at their own times, on a
/// thread of its own, independently of the consumer. Samples always wait to be taken. Of images and
/// frames only so many wait; further ones are dropped and counted. The order is kept.
class Playback {
 public:
  /// Counts of images and frames. After next() has returned none, came = taken + dropped. After a
  /// stop, those that still waited count as dropped.
  struct Counts {
    std::size_t came = 0, taken = 0, dropped = 0;
  };

  /// `next` returns the events, none at the end. It is called from the other thread, before the
  /// event's time. Its exceptions are rethrown by next() below, after the events before them.
  Playback(std::function<std::optional<SensorEvent>()> next, PlaybackOptions options);
  Playback(const Playback&) = delete;
  Playback& operator=(const Playback&) = delete;
  ~Playback();

  /// The next event that was not dropped; waits for it. None at the end or after a stop.
  std::optional<SensorEvent> next();
  /// Ends the playback now, from any thread.
  void stop();

  /// Time since the data of that recorded time were due [s]; negative if they are not due yet.
  double seconds_since(Time recorded) const;
  Counts counts() const;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace chasles
