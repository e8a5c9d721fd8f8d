#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include <chasles/pipeline/sensor_event.hpp>

namespace chasles {

/// Puts the samples of an IMU and the images of a rig into the order that a recording of them has
/// (EventStream), whatever the order in which their topics deliver them. The estimates then are
/// those of `chasles run` on a bag of the same messages, to the byte. No estimate waits for it: an
/// image is held up only for the images of the other cameras at the same instant and for the
/// samples until its time, and a sample only while an earlier image may still come, which no
/// estimate can do without. A camera for whose image a frame has waited in vain is silent: until
/// its next image no frame waits for it. Without samples, or images of the first camera, there is
/// no estimate that could be held up.
///
/// Images are paired as pair_images() does without finders beside the first camera, whose images
/// make the frames; others join the nearest frame, within kSameInstant. Where the first camera has
/// more than 250 images a second, an image between two frames joins the earlier one.
class SensorOrder {
 public:
  struct Options {
    std::size_t cameras = 1;
    /// How long a topic without data holds up the others, on the clock of the data.
    Time patience = std::chrono::milliseconds(500);
  };
  /// What did not become an event, and frames that lack an image.
  struct Counts {
    int late_samples = 0;     ///< not later than one that was passed on, or repeated
    int unknown_samples = 0;  ///< not finite
    int late_images = 0;      ///< of the first camera, likewise
    int unpaired = 0;         ///< images of other cameras that belong to no frame
    int incomplete = 0;       ///< frames without the image of another camera
  };
  explicit SensorOrder(const Options& options)
      : options_(options), cameras_(options.cameras), silent_(options.cameras, false) {}

  void add(const ImuSample& sample);
  /// `time`: by the IMU's clock. The image may be empty: it could not be decoded.
  void add(std::size_t camera, Time time, GrayImage image);

  /// The events whose order is known by now, and that were not returned before.
  std::vector<SensorEvent> take();
  /// All others: nothing more comes.
  std::vector<SensorEvent> finish();

  const Counts& counts() const { return counts_; }

 private:
  struct TimedImage {
    Time time{};
    GrayImage image;
  };
  using Images = std::deque<TimedImage>;

  bool gives_up(Time on) const;
  bool sample_is_due() const;
  bool is_decided(std::size_t camera, Time frame) const;
  bool frame_is_due() const;
  void give_up_unpaired();
  ImageFrame take_frame();
  GrayImage partner(Images& images, Time frame, const std::optional<Time>& next);

  Options options_;
  std::deque<ImuSample> samples_;
  std::vector<Images> cameras_;
  std::optional<Time> newest_;
  std::vector<bool> silent_;                      ///< cameras for which no frame waits
  std::optional<Time> last_sample_, last_frame_;  ///< that were returned
  bool finished_ = false;
  Counts counts_;
};

}  // namespace chasles
