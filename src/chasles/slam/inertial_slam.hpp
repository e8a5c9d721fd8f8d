#pragma once

#include <array>
#include <span>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/filter/multi_view_start.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/slam/estimate.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/slam/inertial_start.hpp>
#include <chasles/slam/recent_tracks.hpp>
#include <chasles/slam/standstill.hpp>

namespace chasles {

/// SLAM from an IMU and cameras: feed it samples and frames in the order of time, the samples up to
/// a frame (by its time and the time offset, `covers`) before the frame. Every observation is used
/// once: a landmark in the state is observed from the present pose; another's observations wait
/// with clones of the poses until they tell its depth, and then begin it all together (`init:
/// multi-view`), or the first of them begins it at a guessed depth (`fixed-depth`). A track that
/// ends before that still tells of its clones.
class InertialSlam {
 public:
  /// Throws UsageError for settings that cannot be used.
  InertialSlam(const InertialSlamSettings& settings, std::vector<Camera> cameras,
               const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma,
               const InertialStart& start);

  void process(const ImuSample& sample) {
    imu_.add(sample);
    if (standstill_) standstill_->add(sample);
  }
  Estimate process(const FeatureFrame& frame);

  /// What the IMU's clock showed at a time of the cameras', as far as is known.
  Time clock(Time of_cameras) const;
  /// Whether the samples reach up to a frame of that time. One that is processed before is
  /// predicted by holding the last sample, and what that does wrong is not known to the filter.
  bool covers(Time frame) const;

  const Ekf& filter() const { return filter_; }
  /// The map in nav's axes. Where the world's attitude is estimated its error is not in the
  /// landmarks' covariances.
  std::vector<MapLandmark> map_nav() const;
  /// What became of the observations of the last frame, those that can be used, in its order.
  std::span<const PixelOutcome> outcomes() const { return outcomes_; }
  const ImuBuffer::Counts& imu_counts() const { return imu_.counts(); }

 private:
  using Views = std::vector<ClonedView>;
  struct Track {
    LandmarkId id = 0;
    Views views;
    int seen = 0;        ///< the latest frame
    bool ended = false;  ///< it is now a landmark, or not seen any more
  };

  void advance_to(Time time);
  const Prediction& predict_to(Time time);
  Vector9d rate_at(const InertialState& state, Time of_imu) const;
  NavState motion();
  double time_offset() const;
  bool has_sane_clock() const;
  const std::vector<const PixelObservation*>& usable(const FeatureFrame& frame);
  void number_landmarks();
  std::optional<int> number_of(LandmarkId id) const;
  void observe(const std::vector<const PixelObservation*>& observations, Estimate& e);
  void begin_at_once(const std::vector<const PixelObservation*>& fresh, Estimate& e);
  void begin_from_tracks(Estimate& e);
  void begin_what_is_missing(Estimate& e);
  Track& track_of(LandmarkId id);
  void forget_ended_tracks();
  bool find_start(LandmarkId id, const Views& views);
  bool is_certain(const MultiViewStart& start) const;
  bool is_somewhere(const MultiViewStart& start) const;
  bool take_rest(const MultiViewStart& start);
  void add_begun(Estimate& e);
  void null_space_update(Estimate& e);
  Linearisation linearisation() const {
    return settings_.first_estimates ? Linearisation::kFirstEstimates : Linearisation::kCurrent;
  }
  void keep_pose(Time time);
  bool zero_velocity_update(const FeatureFrame& frame, Time since);
  double noise_inflation(int landmark) const;
  bool cannot_be(const Landmark& landmark) const;
  double gate_square(int dof) const;  ///< what a squared innovation may be
  void settle();
  void note_refusals(std::span<const Measurement> known, const std::vector<bool>& accepted);
  void note_outcomes(std::span<const Measurement> known, const UpdateReport& report);
  void note_begun(int added);
  void compare_innovations(const std::vector<const PixelObservation*>& observations,
                           const UpdateReport& report, Estimate& e);
  void retire_unseen();
  void forget_unused_clones();
  void compose_when_due();
  void note_prediction();
  Health judge(const Estimate& e);
  TrackUse use_of_tracks();
  bool has_room() const;
  static bool has_view(const Track& track, int clone);

  InertialSlamSettings settings_;
  std::vector<Camera> cameras_;
  double pixel_sigma_;
  InertialModel model_;
  ImuBuffer imu_;
  Ekf filter_;
  std::optional<Standstill> standstill_;  ///< where it is used
  Time now_;                              ///< of the last frame, by the cameras' clock
  Time composed_;
  bool at_image_ = false;  ///< the state is of the instant of an image, not yet of the start's
  std::optional<int> still_since_;  ///< clone of the pose that the rest began with
  PredictedMotion predicted_;       ///< for first estimates
  int frame_ = 0;
  std::vector<int> window_;                    ///< clones that tracks may have views from
  bool cloned_ = false;                        ///< the present frame's pose is a clone
  Reused<Track> tracks_;                       ///< not in the state; ids rise
  std::optional<RecentTracks> recent_tracks_;  ///< where the filter lives on them
  struct Last {
    int seen = 0;     ///< frame
    int refused = 0;  ///< frames in a row in which the gate refused it
  };
  std::vector<Last> last_;  ///< of the landmarks of the state, in their order
  struct WhitenedPixel {
    LandmarkId landmark = 0;
    int camera = 0;
    Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  };
  std::vector<PixelOutcome> outcomes_;      ///< of the last frame
  std::vector<WhitenedPixel> innovations_;  ///< of the last frame; landmark and camera rise
  int starved_ = 0;                         ///< frames in a row with hardly an observation

  // Lists of the function that is at work: they keep their room.
  struct Workspace {
    struct Place {
      LandmarkId landmark = 0;
      int camera = 0;
      std::size_t index = 0;
    };
    std::vector<Place> places;
    std::vector<std::pair<LandmarkId, int>> numbers;  ///< of the landmarks of the state; rising
    std::vector<const PixelObservation*> usable, predicted, fresh;
    std::vector<std::size_t> judged;  ///< of those that are predicted
    Reused<Measurement> known, rests;
    std::array<Measurement, 2> rest;
    std::vector<WhitenedPixel> innovations;
    Reused<NewLandmark> begun;
    std::vector<int> retired, used, unused;
    std::vector<ImuInterval> intervals;
    Prediction prediction;
    NavScratch nav;
    MultiViewScratch multi_view;
    MultiViewStart start;
  };
  Workspace work_;
};

}  // namespace chasles
