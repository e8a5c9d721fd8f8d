#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/past/condensed_run.hpp>
#include <chasles/filter/past/fixed_interval.hpp>
#include <chasles/filter/past/segment_chain.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A pose of the past, with the covariance of its errors [rotation; position] (standard chart).
struct PastPose {
  Time time{};
  SE3 map_T_imu;
  Matrix6d covariance = Matrix6d::Zero();
};

/// The pose after a correction, with another covariance.
PastPose corrected(PastPose pose, const Vector6d& correction, const Matrix6d& covariance);

/// A landmark of the whole map.
struct MapLandmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< additive error, world axes [m^2]
  int observations = 0;                                  ///< used, including the first
};

/// Landmarks that are known from elsewhere, and the frame of their map, independent of a filter.
/// The errors of the frame [rotation; position] and of the landmarks are linear functions of some
/// shared errors x of covariance I; each landmark has an independent error of its own too.
struct PriorMap {
  SE3 map_T_prior;                   ///< the frame, in the axes of the filter's map
  std::vector<Landmark> landmarks;   ///< Cartesian, in the axes of the filter's map
  Eigen::MatrixXd shared;            ///< by x: six rows of the frame, then three a landmark
  std::vector<Eigen::Matrix3d> own;  ///< covariances of the landmarks' own errors
  int of_frame = 0;  ///< the last of the shared errors that are those of the frame, not of the map
};

/// The states that have left a filter: landmarks, and poses of its path. Their estimates given all
/// measurements, and their joint covariance with the present state, follow from the segments of
/// its run (docs/map.md).
class Past {
 public:
  struct Options {
    bool recalls = false;  ///< landmarks can return into the state
    bool records = false;  ///< all segments are kept, for estimates of every past state
    /// Bound on the memory of those segments [bytes]; 0: none. Where it is reached, the poses that
    /// left in the older half are final: later measurements no longer change them. So are the
    /// landmarks, unless they can return.
    std::size_t most_bytes = 0;
    /// Without recalls: past states are condensed when one to two times as many segments have
    /// ended.
    int condensed_after = 10;
  };

  explicit Past(Options options) : options_(options), run_(options.condensed_after) {}

  /// A state leaves the filter. Returns its number; numbers rise from 0.
  int add(const Landmark& landmark);  ///< Cartesian, in the map's axes
  int add(Time time, const SE3& map_T_imu);
  /// States that were never in the filter. Returns the number of the frame, which stands for the
  /// shared errors; those of the landmarks follow. The landmarks become items of the segments when
  /// they return, or are already.
  int add(PriorMap prior, bool are_items = false);

  /// This landmark does not return: recall() and revive() cost less with fewer that can.
  void bar_return(int number);

  /// The filter's run since the last segment. `end`: covariance of the state at its end.
  void append(Segment segment, const Eigen::MatrixXd& end);

  /// Whether it is a landmark of a prior map that has not yet returned.
  bool follows(int number) const { return frame_of(number).has_value(); }
  /// The number of that map's frame.
  std::optional<int> frame_of(int number) const;
  /// The states from which these follow: a landmark of a prior map that has not yet returned
  /// follows from the shared errors of the map.
  std::vector<int> sources(const std::vector<int>& numbers) const;
  /// Sources, with all that has been measured until the end of the last segment.
  Carried recall(const std::vector<int>& sources) const;
  /// The states that follow from sources.
  Carried derived(const Carried& sources, const std::vector<int>& numbers) const;
  /// The same, and they are states of the filter from now on: the last rows of the next segment's
  /// starts, in this order.
  Carried revive(const std::vector<int>& numbers);
  void note_returned(const std::vector<int>& numbers);
  void note_left(int number);  ///< a landmark that had returned

  /// Estimates given all measurements; `latest` is the run since the last segment. Landmarks of
  /// the past in the order in which they left, without those that have returned.
  struct Estimates {
    std::vector<MapLandmark> landmarks;
    std::vector<PastPose> poses;
  };
  Estimates estimates(const Segment& latest) const;

  bool recalls() const { return options_.recalls; }
  bool can_return(int number) const;
  bool has_returned(int number) const { return past_landmark(number)->has_returned; }
  /// A prior map, as it was added, by the number of its frame.
  const PriorMap& prior(int frame) const;
  /// A past landmark as it left.
  const Landmark& landmark(int number) const;
  int states() const { return static_cast<int>(states_.size()); }
  int landmarks() const { return landmarks_; }  ///< that have not returned
  std::size_t bytes() const;                    ///< of the segments

 private:
  struct PastLandmark {
    Landmark landmark;
    bool may_return = true;
    bool has_returned = false;
    std::optional<int> frame = {};  ///< of the prior map from whose shared errors it follows
  };
  struct LeftPose {
    Time time{};
    SE3 map_T_imu;
  };
  struct Recorded {
    Segment segment;
    std::vector<int> revived;  ///< landmarks that are the last of its starts
  };

  const PastLandmark* past_landmark(int number) const;
  bool may_return(int number) const;
  bool is_frame(int number) const;
  Segment of_recalled(const Segment& segment) const;
  void make_items(const std::vector<int>& numbers);
  DerivedItem derived_item(int frame, int number) const;
  void append_prior(const SmoothedState& shared, const PriorMap& map, Estimates& estimates) const;
  void give_up_older_half();
  std::vector<Stretch> recorded() const;
  void append_estimate(const SmoothedState& smoothed, Estimates& estimates) const;

  Options options_;
  Estimates final_;
  std::deque<std::variant<PastLandmark, LeftPose, PriorMap>> states_;
  SegmentChain chain_;                              ///< of landmarks and frames, with recalls
  CondensedRun run_;                                ///< of all states, without recalls
  std::vector<std::shared_ptr<Recorded>> records_;  ///< all segments, with both; shared with copies
  std::vector<int> revived_;                        ///< since the last segment
  int landmarks_ = 0;
  std::size_t recorded_bytes_ = 0;
};

}  // namespace chasles
