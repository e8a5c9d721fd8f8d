#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include <chasles/pipeline/sensor_event.hpp>

namespace chasles {

/// What came, and what of it gives no estimate.
struct ArrivalCounts {
  std::size_t samples = 0;             ///< that came
  std::size_t samples_not_finite = 0;  ///< NaN or infinite
  std::size_t samples_late = 0;        ///< not later than one that was passed on, or repeated
  std::size_t samples_dropped = 0;     ///< the oldest of more than kMostSamples
  std::size_t images = 0;              ///< frames that came
  std::size_t images_late = 0;         ///< likewise
  std::size_t images_uncovered = 0;    ///< passed on without samples until their time
};

/// Puts samples and frames of images into the order that a recording of them has (EventStream),
/// whatever the order in which they come: a frame follows the first sample that is not earlier, and
/// a sample later than that one waits for the next frame. So samples may come long before their
/// images, or images before their samples, and what waits may come in any order. An estimate never
/// waits for it: a frame is passed on with the sample that covers it.
///
/// At most kMostSamples samples (64 MiB) and kMostFrames frames wait. One more, and the oldest
/// sample is dropped, and the oldest frame passed on without samples until its time. What comes too
/// late, or repeats a time, is left out. A sample that is not finite covers no frame; the estimator
/// ignores it. Deterministic.
class ArrivalOrder {
 public:
  static constexpr std::size_t kMostSamples = std::size_t{1} << 20;
  static constexpr std::size_t kMostFrames = 64;

  void add(const ImuSample& sample);
  void add(ImageFrame frame);

  /// The next event whose place is known; none: more must come first.
  std::optional<SensorEvent> next();
  /// The next of all others; nothing more comes.
  std::optional<SensorEvent> next_at_end();

  std::size_t waiting_frames() const { return frames_.size(); }
  const ArrivalCounts& counts() const { return counts_; }

 private:
  bool is_covered(const ImageFrame& frame) const;
  SensorEvent take_sample();
  SensorEvent take_frame();

  std::deque<ImuSample> samples_;                 ///< in order of time
  std::deque<ImageFrame> frames_;                 ///< likewise
  std::optional<Time> covered_until_;             ///< of the finite samples that came
  std::optional<Time> passed_on_;                 ///< of the finite samples that were passed on
  std::optional<Time> last_sample_, last_frame_;  ///< that were passed on
  ArrivalCounts counts_;
};

}  // namespace chasles
