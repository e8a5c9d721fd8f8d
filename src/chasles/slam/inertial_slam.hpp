#pragma once

#include <array>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>
#include <chasles/camera/track_noise.hpp>
#include <chasles/estimate/closure.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/estimate/recent_tracks.hpp>
#include <chasles/estimate/timed_measurement.hpp>
#include <chasles/filter/depth_rule.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/filter/multi_view_start.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/initialise/standstill.hpp>
#include <chasles/loop/appearance.hpp>
#include <chasles/loop/joint_compatibility.hpp>
#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/place.hpp>
#include <chasles/loop/spatial_choice.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// Visual-inertial SLAM. Feed samples and frames in the order of time; the samples up to a frame
/// (its time plus the time offset, `covers`) come before the frame.
/// Every observation is used once. A landmark in the state is observed from the present pose. With
/// `init: multi-view`, the observations of other points wait, with clones of the poses, until they
/// determine the depth; together they then initialise the landmark. With `fixed-depth`, the first
/// observation initialises it at an assumed depth. A track that ends earlier makes a null-space
/// update of its clones.
class InertialSlam {
 public:
  /// Throws UsageError for settings that cannot be used. `prior`: a map in which the run finds its
  /// place, with Recognise::kAppearance. `starts_in_map`: nav is the frame of this map, so that the
  /// start is a place in it.
  InertialSlam(const InertialSlamSettings& settings, std::vector<Camera> cameras,
               const ImuNoise& noise, const ImuBuffer::Options& imu, double pixel_sigma,
               const InertialStart& start, std::shared_ptr<const LandmarkMap> prior = nullptr,
               bool starts_in_map = false);

  void process(const ImuSample& sample) {
    if (imu_.add(sample) && standstill_) standstill_->add(sample);
  }
  /// Applied at its own time, before the next frame that is not earlier; with an estimated time
  /// offset, at the time of that frame.
  void process(TimedMeasurement measurement) { timed_.push_back(std::move(measurement)); }
  Estimate process(const FeatureFrame& frame);

  /// Where landmarks have returned in the frame just processed: the filter in this frame as if they
  /// had not, and would not later. conclude() then gives its estimate for the frame.
  std::shared_ptr<InertialSlam> take_without() { return std::exchange(without_, nullptr); }
  Estimate conclude(const FeatureFrame& frame) { return conclude(frame, false, std::nullopt); }
  /// The landmarks that returned last.
  std::span<const LandmarkId> returned() const { return returned_; }
  /// The landmarks that left in the last frame because the gate had rejected them too often.
  std::span<const LandmarkId> rejected() const { return rejected_; }
  /// Closures of a filter that this one replaces.
  void note_undone(std::span<const Closure> closures);

  /// The IMU's time of a camera time, by the present estimate of the time offset.
  Time clock(Time of_cameras) const;
  /// Whether the samples reach the time of this frame. If a frame is processed earlier, the filter
  /// holds the last sample; the error of this is not in the covariance.
  bool covers(Time frame) const;

  const Ekf& filter() const { return filter_; }
  /// The map in nav axes. Without exact_map, where the world's attitude is estimated, its error is
  /// not in the covariances of the landmarks.
  std::vector<MapLandmark> map_nav() const { return past_nav().landmarks; }
  /// The map, and the poses of all frames given all measurements; no poses without exact_map.
  Past::Estimates past_nav() const;
  /// The outcomes of the usable observations of the last frame, in the frame's order.
  std::span<const PixelOutcome> outcomes() const { return outcomes_; }
  ImuBuffer::Counts imu_counts() const { return imu_.counts(); }
  const TimedMeasurementCounts& timed_counts() const { return timed_counts_; }
  /// Landmarks that were recognised by their appearance.
  const std::vector<Closure>& closures() const { return closures_; }
  /// When a search found past landmarks, whether they returned or would have added too little.
  const std::vector<Time>& recognised() const { return recognised_; }
  /// The landmarks of the tracks that were recognised: (id of the track, id of the landmark).
  const std::map<LandmarkId, LandmarkId>& known_as() const { return known_as_; }
  /// What another run can recognise, with Recognise::kAppearance: in the frame of the prior map if
  /// the run has found its place in it, else in nav. Without sessions[].name. Of own landmarks only
  /// those that have left before `until`, if it is given (on the cameras' clock).
  LandmarkMap landmark_map(std::optional<Time> until = std::nullopt) const;
  /// Where the prior map lies in nav; none before the run has found its place.
  std::optional<SE3> nav_T_map() const;
  const PlaceCounts& place_counts() const { return place_counts_; }
  int timed_waiting() const { return static_cast<int>(timed_.size()); }

 private:
  using Views = std::vector<ClonedView>;
  struct Track {
    LandmarkId id = 0;
    Views views;
    int seen = 0;           ///< the latest frame
    CameraSet cameras = 0;  ///< that have observed it
    bool ended = false;     ///< it is now a landmark, or no longer in view
  };

  Estimate conclude(const FeatureFrame& frame, bool returned, const std::optional<SE3>& closed_at);
  void advance_to(Time time);
  void apply_timed(Time frame);
  const Prediction& predict_to(Time time);
  Vector9d rate_at(const InertialState& state, Time of_imu) const;
  NavState motion();
  double time_offset() const;
  bool has_sane_clock() const;
  const std::vector<const PixelObservation*>& usable(std::span<const PixelObservation> pixels);
  void number_landmarks();
  std::optional<int> number_of(LandmarkId id) const;
  void observe(const std::vector<const PixelObservation*>& observations, bool returned,
               Estimate& e);
  void relinearise(const std::vector<const PixelObservation*>& predicted,
                   std::span<Measurement> known) const;
  std::optional<NewLandmark> initialise_undelayed(LandmarkId id, int camera,
                                                  const Eigen::Vector2d& pixel,
                                                  bool anchored) const;
  void initialise_fresh(const std::vector<const PixelObservation*>& fresh, Estimate& e);
  void initialise_from_tracks(CameraSet observers, Estimate& e);
  void initialise_missing(Estimate& e);
  Track& track_of(LandmarkId id);
  void remove_ended_tracks();
  bool find_start(LandmarkId id, const Views& views);
  bool is_certain(const MultiViewStart& start) const;
  bool is_somewhere(const MultiViewStart& start) const;
  bool take_null_space(const MultiViewStart& start);
  void add_initialised(Estimate& e);
  void null_space_update(Estimate& e);
  Linearisation linearisation() const {
    return settings_.first_estimates ? Linearisation::kFirstEstimates : Linearisation::kCurrent;
  }
  TrackNoise track_noise() const {
    return {.sigma = settings_.track_sigma.value_or(pixel_sigma_),
            .drift = settings_.track_drift.value_or(0),
            .match = settings_.match_sigma.value_or(0)};
  }
  void keep_pose(Time time);
  bool is_clone_due(const FeatureFrame& frame);
  bool zero_velocity_update(const FeatureFrame& frame, Time since);
  double noise_inflation(int landmark) const;
  bool cannot_be(const Landmark& landmark) const;
  double gate_square(int dof) const;  ///< limit of a squared normalised innovation
  double shared_variance() const;     ///< of a pixel, beyond its scatter [px^2]
  void make_landmarks_cartesian();
  void note_rejections(std::span<const Measurement> known, const std::vector<bool>& accepted);
  void note_outcomes(std::span<const Measurement> known, const UpdateReport& report);
  void note_initialised(int added);
  void compare_innovations(const std::vector<const PixelObservation*>& observations,
                           const UpdateReport& report, Estimate& e);
  void retire_unseen(CameraSet observers);
  void note_inactive(std::span<const int> leaving);
  SE3 nav_T_camera(int index) const;
  std::span<const PixelObservation> renamed(const FeatureFrame& frame);
  void name_outcomes(const FeatureFrame& frame,
                     const std::vector<const PixelObservation*>& observations);
  bool revive_ids(const std::vector<const PixelObservation*>& observations);
  void revive(std::vector<int> numbers);
  /// A landmark that was observed so often is a point, and remains one.
  static constexpr int kLeastObservations = 10;
  /// A past landmark that may return.
  struct InactiveLandmark {
    int number = 0;                                   ///< in Ekf::past()
    Eigen::Vector3d p_nav = Eigen::Vector3d::Zero();  ///< when it left, or was last recalled [m]
    Appearance appearance = {};
    Time left{};  ///< when it left
  };
  /// A landmark of the state, as it looks now.
  struct SeenLandmark {
    LandmarkId id = 0;
    int index = 0;  ///< into the state's landmarks
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    PatchView view;
  };
  struct Candidate {
    LandmarkId id = 0;
    InactiveLandmark* inactive = nullptr;
    std::vector<std::pair<int, int>> like = {};  ///< Hamming distance, index of a SeenLandmark
  };
  struct Comparison {
    std::vector<ProposedMatch> matches;  ///< of seen landmarks and candidates
    Eigen::VectorXd r;
    Eigen::MatrixXd S;
    Eigen::MatrixXd by_place;  ///< of r
  };
  using InactiveLandmarks = std::map<LandmarkId, InactiveLandmark>;
  /// Matches (track, landmark) that the last search found compatible, and from where first.
  using CompatibleMatches = std::map<std::pair<LandmarkId, LandmarkId>, Eigen::Vector3d>;
  /// Landmarks in nav, in the order of the candidates, with their joint covariance P and C, that
  /// with the errors of the state.
  struct KnownLandmarks {
    std::vector<Landmark> landmarks;
    Eigen::MatrixXd C, P;
    Eigen::MatrixXd by_place;  ///< derivative by the unit errors of a proposed place, if any
  };
  /// A map in which the run has not yet found its place, and where it may lie.
  struct Prior {
    std::shared_ptr<const LandmarkMap> map;
    std::optional<MapPlace> place = {};  ///< proposed
    InactiveLandmarks points = {};       ///< at that place; the number is the index in the map
    CompatibleMatches compatible = {};
    int failures = 0;  ///< searches in a row that found nothing compatible there
  };
  bool recognise(const FeatureFrame& frame,
                 const std::vector<const PixelObservation*>& observations);
  bool recognise_among(InactiveLandmarks& past, CompatibleMatches& compatible,
                       const std::vector<SeenLandmark>& seen);
  bool find_place_in_map(const std::vector<SeenLandmark>& seen);
  std::optional<PlaceInMap> search_place(const std::vector<SeenLandmark>& seen);
  void propose_place(const std::vector<SeenLandmark>& seen);
  bool finds_place_again(const Comparison& comparison, const std::vector<int>& accepted,
                         const std::vector<Candidate>& candidates,
                         const std::vector<SeenLandmark>& seen);
  void refine_place(const Comparison& comparison, const std::vector<int>& accepted,
                    const std::vector<Candidate>& candidates,
                    const std::vector<SeenLandmark>& seen);
  void put_points_in_place();
  void place_map();
  bool considers_map() const { return settings_.prior_map == PriorMapUse::kConsidered; }
  void bound_considered();
  KnownLandmarks known_landmarks(const std::vector<Candidate>& candidates) const;
  KnownLandmarks known_points(const std::vector<Candidate>& candidates) const;
  /// The frame of the placed map, and the derivative of its errors by those that the map shares.
  struct MapFrame {
    SE3 nav_T_map;
    Eigen::MatrixXd by_shared;
  };
  MapFrame map_frame(const Carried& shared) const;
  std::optional<PoseInMap> pose_in_map(const NavState& now) const;
  struct SavedLandmark {
    enum Kind { kOfMap, kPast, kInState };
    LandmarkId id = 0;
    Kind kind = kOfMap;  ///< kOfMap: of the prior map, and has not returned
    int place = 0;       ///< number in Ekf::past(), or index into the state's landmarks
    int observations = 0;
    Appearance appearance;
  };
  std::vector<SavedLandmark> landmarks_to_save(const SE3& map_T_nav,
                                               std::optional<Time> until) const;
  std::vector<SeenLandmark> see_landmarks(const GrayImage& image,
                                          const std::vector<const PixelObservation*>& observations);
  std::vector<Candidate> similar_landmarks(InactiveLandmarks& past,
                                           const std::vector<SeenLandmark>& seen);
  Comparison compare(std::vector<Candidate>& candidates, const KnownLandmarks& known,
                     const std::vector<SeenLandmark>& seen) const;
  std::vector<int> accepted_matches(const Comparison& comparison,
                                    const std::vector<Candidate>& candidates,
                                    const std::vector<SeenLandmark>& seen,
                                    CompatibleMatches& compatible);
  std::vector<int> confirmed_matches(const std::vector<int>& joint, const Comparison& comparison,
                                     const std::vector<Candidate>& candidates,
                                     const std::vector<SeenLandmark>& seen,
                                     CompatibleMatches& compatible) const;
  std::shared_ptr<InertialSlam> without(const Comparison& comparison,
                                        const std::vector<int>& accepted,
                                        const std::vector<Candidate>& candidates) const;
  void note_change(const SE3& before, const SE3& after);
  void close_loop(const Comparison& comparison, const std::vector<int>& accepted,
                  std::vector<Candidate>& candidates, const std::vector<SeenLandmark>& seen);
  void remove_unused_clones();
  void let_points_drift(Time since);
  void compose_when_due();
  void note_prediction();
  bool was_blind(Time time, bool sees);
  void assess(Estimate& e);
  TrackUse use_of_tracks();
  bool has_room() const;
  static bool has_view(const Track& track, int clone);

  InertialSlamSettings settings_;
  std::vector<Camera> cameras_;
  double pixel_sigma_;
  DepthRule depth_rule_;  ///< of undelayed initialisations; empty: that of the settings
  InertialModel model_;
  ImuBuffer imu_;
  Ekf filter_;
  std::vector<TimedMeasurement> timed_;  ///< that wait for a frame
  TimedMeasurementCounts timed_counts_;
  std::optional<Standstill> standstill_;  ///< where it is used
  Time now_;                              ///< of the state, by the cameras' clock
  Time composed_;
  Time since_{};           ///< the frame before
  bool at_image_ = false;  ///< the state is at the time of an image, no longer at the start's
  std::optional<int> standstill_since_;  ///< clone of the pose at which the standstill began
  PredictedMotion predicted_;            ///< for first estimates
  int frame_ = 0;
  int since_clone_ = 0;                        ///< frames with observations since a clone was due
  std::optional<Time> last_clone_;             ///< when it was due
  std::vector<int> window_;                    ///< clones that views of tracks may refer to
  bool cloned_ = false;                        ///< the present frame's pose is a clone
  Reused<Track> tracks_;                       ///< not in the state; in the order of their ids
  std::optional<RecentTracks> recent_tracks_;  ///< where the filter works mainly with tracks
  struct Last {
    int seen = 0;           ///< number of a frame
    CameraSet cameras = 0;  ///< that have observed it
    int missed = 0;         ///< later frames in which one of them observes anything
    int rejected = 0;       ///< consecutive frames in which the gate rejected it
    int matches = 0;        ///< used, in the cameras after the first
  };
  std::vector<Last> last_;  ///< of the landmarks of the state, in the same order
  InactiveLandmarks inactive_;
  std::optional<Prior> prior_;  ///< until the run has found its place in it
  std::shared_ptr<const LandmarkMap> placed_map_;
  std::optional<int> map_number_;  ///< of the placed map, in Ekf::past()
  PlaceCounts place_counts_;
  std::optional<Time> searched_;                  ///< when landmarks were last looked for
  std::map<LandmarkId, Appearance> appearances_;  ///< of landmarks in the state
  std::map<LandmarkId, LandmarkId> known_as_;     ///< tracks of recognised landmarks
  CompatibleMatches compatible_;
  SpatialChoice choice_;
  Describer describer_;
  std::vector<Closure> closures_;
  std::vector<Time> recognised_;
  std::vector<LandmarkId> returned_;  ///< the last ones
  std::vector<LandmarkId> rejected_;
  std::shared_ptr<InertialSlam> without_;  ///< them, until it is taken
  struct WhitenedPixel {
    LandmarkId landmark = 0;
    int camera = 0;
    Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  };
  std::vector<PixelOutcome> outcomes_;      ///< of the last frame
  std::vector<WhitenedPixel> innovations_;  ///< of the last frame; sorted by landmark and camera
  RecentInnovations recent_innovations_;
  int starved_ = 0;                ///< consecutive frames with almost no observation
  std::optional<Time> last_seen_;  ///< the last frame with observations, or at a standstill
  std::optional<Time> regained_;   ///< the first such frame after a second without

  // Temporary lists; they keep their memory.
  struct Workspace {
    struct Place {
      LandmarkId landmark = 0;
      int camera = 0;
      std::size_t index = 0;
    };
    std::vector<Place> places;
    std::vector<std::pair<LandmarkId, int>>
        numbers;  ///< of the landmarks in the state; sorted by id
    std::vector<PixelObservation> renamed;
    std::vector<const PixelObservation*> usable, predicted, fresh;
    std::vector<std::size_t> assessed;  ///< indices of the predicted observations
    Reused<Measurement> known, null_space;
    std::array<Measurement, 2> zero_velocity;
    std::vector<WhitenedPixel> innovations;
    Reused<NewLandmark> initialised;
    std::vector<int> retired, used, unused, marginalised;
    std::vector<ImuInterval> intervals;
    Prediction prediction;
    NavScratch nav;
    MultiViewScratch multi_view;
    MultiViewStart start;
  };
  Workspace work_;
};

}  // namespace chasles
