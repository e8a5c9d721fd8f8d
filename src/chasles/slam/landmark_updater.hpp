#pragma once

#include <span>
#include <vector>

#include <chasles/camera/pixel_outcome.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/slam/innovation_correlation.hpp>
#include <chasles/slam/slam_context.hpp>
#include <chasles/slam/study_hooks.hpp>

namespace chasles {

/// Updates the filter with the pixels of landmarks in its state, and says which landmarks leave it.
/// Association is by the ids of the tracks; each observation passes the gate alone.
class LandmarkUpdater {
 public:
  using Observations = std::vector<const PixelObservation*>;

  /// The observed points have slid over their surfaces since the last frame. During a standstill
  /// the same patch is seen from the same place: nothing slides.
  void add_drift(SlamContext& x, Time since) const;

  /// The update with the usable observations of the frame. `returned`: landmarks have returned, and
  /// the correction may be large. Writes the innovations and counts of `e`. During a standstill
  /// (e.zero_velocity) a pixel has the same error in every image: its observations are one, not
  /// many, and the zero-velocity update contains more information.
  void update(SlamContext& x, const Observations& observations, bool returned,
              const StudyHooks& studies, Estimate& e);
  /// Of these observations, those whose points are not in the state.
  const Observations& fresh() const { return fresh_; }

  /// Anchored landmarks with a well-known depth become Cartesian.
  void make_cartesian(SlamContext& x) const;
  /// The landmarks that leave the state (indices, rising): rejected too often, or out of view. One
  /// out of view ages in the frames whose images might have shown it. `looking`: the cameras that
  /// observe anything.
  const std::vector<int>& find_leaving(SlamContext& x, CameraSet looking);
  /// The frame has initialised so many landmarks, the last ones of the state.
  void note_initialised(SlamContext& x, int added);

  /// The outcomes of the usable observations of the last frame, in their order.
  std::span<const PixelOutcome> outcomes() const { return outcomes_; }
  /// Names them by other observations than those of the update, one for each.
  template <typename Original>
  void name_outcomes(const Observations& observations, const Original& original) {
    for (std::size_t i = 0; i < outcomes_.size(); ++i) {
      outcomes_[i].observation = original(*observations[i]);
    }
  }

 private:
  void linearise(SlamContext& x, const Observations& observations, const StudyHooks& studies,
                 Estimate& e);
  bool measure(const SlamContext& x, const PixelObservation& o, int landmark,
               const StudyHooks& studies, Measurement& z) const;
  void relinearise(const SlamContext& x);
  void note_report(SlamContext& x, const UpdateReport& report);

  LandmarkIndex index_;
  Reused<Measurement> known_;            ///< measurements of this frame
  Observations predicted_, fresh_;       ///< predicted_: of these measurements
  std::vector<std::size_t> of_outcome_;  ///< index of the outcome of each
  std::vector<PixelOutcome> outcomes_;
  std::vector<int> leaving_;
  InnovationCorrelation correlation_;
};

}  // namespace chasles
