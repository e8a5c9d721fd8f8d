#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include <chasles/pipeline/sensor_event.hpp>
#include <chasles/time.hpp>

namespace chasles {

/// What a playback goes by; tests have one of their own. Called from several threads.
struct PlaybackClock {
  std::function<Time()> now;           ///< since any instant; never goes back
  std::function<void(Time)> wait_for;  ///< about so long; may return sooner
};

/// The machine's steady clock.
PlaybackClock wall_clock();

struct PlaybackOptions {
  Time begin{};             ///< of the recording, that is played at once
  double speed = 1;         ///< recorded seconds in a second; above 0
  std::size_t waiting = 3;  ///< frames; one that comes while so many wait is dropped
  /// Asked again and again by a thread of the playback's own: true ends it.
  std::function<bool()> stop = [] { return false; };
  PlaybackClock clock = wall_clock();
};

/// A recording as sensors would deliver it live: its events come at their own times, on a thread of
/// its own, whether anybody is ready for them or not. Samples always wait to be taken; of images
/// and frames only so many do, and later ones are dropped and counted. Their order is kept.
class Playback {
 public:
  /// Of images and frames. Once next() has given none, came = taken + dropped; after a stop, those
  /// that still waited count as dropped.
  struct Counts {
    std::size_t came = 0, taken = 0, dropped = 0;
  };

  /// `next` gives the events, none at the end; it is called from the other thread, ahead of the
  /// event's time. What it throws is thrown by next() below, after all that came before.
  Playback(std::function<std::optional<SensorEvent>()> next, PlaybackOptions options);
  Playback(const Playback&) = delete;
  Playback& operator=(const Playback&) = delete;
  ~Playback();

  /// The next event that came and was not dropped; waits for it. None at the end or after a stop.
  std::optional<SensorEvent> next();
  /// Ends the playback now, from any thread.
  void stop();

  /// How long ago what has that time was due [s]; negative if it is not due yet.
  double seconds_since(Time recorded) const;
  Counts counts() const;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace chasles
